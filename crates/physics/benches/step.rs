//! Cost of a step through this crate against MuJoCo's own.

fn main() {
    divan::main();
}
