//! Time of localisation.
fn main() {
    divan::main();
}
