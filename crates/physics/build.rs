//! Compiles the C shim that turns MuJoCo's fatal errors into return codes (see `shim/guard.h`).

use std::io;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-env-changed=MUJOCO_DYNAMIC_LINK_DIR");
    println!("cargo::rerun-if-changed=shim");
    let mut build = cc::Build::new();
    // A library found by pkg-config has its headers on the default search path.
    if let Some(library_dir) = std::env::var_os("MUJOCO_DYNAMIC_LINK_DIR").map(PathBuf::from) {
        let include = library_dir.join("../include");
        assert!(
            include.join("mujoco/mujoco.h").is_file(),
            "MuJoCo's headers are not in {}; `cargo x setup` fetches them",
            include.display()
        );
        build.include(include.join("mujoco")).include(include);
        offer_to_doc_tests(&library_dir)
            .unwrap_or_else(|error| panic!("{}: {error}", library_dir.display()));
    }
    build
        .std("c11")
        .warnings(true)
        .extra_warnings(true)
        .opt_level(2)
        .files(["shim/guard.c", "shim/simulate.c", "shim/spec.c"])
        .compile("factotum_mujoco_shim");
}

/// Doc tests run from temporary folders, where an rpath relative to the program finds nothing. Cargo
/// puts native search folders under `target` on their library path, so the library is linked there.
fn offer_to_doc_tests(library_dir: &Path) -> io::Result<()> {
    let Some(out_dir) = std::env::var_os("OUT_DIR").map(PathBuf::from) else {
        return Ok(());
    };
    let offered = out_dir.join("mujoco");
    std::fs::create_dir_all(&offered)?;
    for entry in std::fs::read_dir(library_dir)? {
        let entry = entry?;
        let link = offered.join(entry.file_name());
        if link.symlink_metadata().is_ok() {
            std::fs::remove_file(&link)?;
        }
        link_file(&entry.path(), &link)?;
    }
    println!("cargo::rustc-link-search=native={}", offered.display());
    Ok(())
}

#[cfg(unix)]
fn link_file(from: &Path, to: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(from, to)
}

#[cfg(not(unix))]
fn link_file(from: &Path, to: &Path) -> io::Result<()> {
    std::fs::copy(from, to).map(drop)
}
