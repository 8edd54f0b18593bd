//! Makes sure that the folder of the built page exists, so that the crate builds without the page;
//! the studio then serves a note on how to build it.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let manifest_dir = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    let dist = Path::new(&manifest_dir).join("../../web/dist");
    std::fs::create_dir_all(&dist)?;
    println!("cargo::rerun-if-changed={}", dist.display());
    Ok(())
}
