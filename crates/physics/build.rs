//! Compiles the C shim that turns MuJoCo's fatal errors into return codes (see `shim/guard.h`).

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-env-changed=MUJOCO_DYNAMIC_LINK_DIR");
    println!("cargo::rerun-if-changed=shim");
    let mut build = cc::Build::new();
    // A library found by pkg-config has its headers on the default search path.
    if let Ok(library_dir) = std::env::var("MUJOCO_DYNAMIC_LINK_DIR") {
        let include = PathBuf::from(library_dir).join("../include");
        assert!(
            include.join("mujoco/mujoco.h").is_file(),
            "MuJoCo's headers are not in {}; `cargo x setup` fetches them",
            include.display()
        );
        build.include(include.join("mujoco")).include(include);
    }
    build
        .std("c11")
        .warnings(true)
        .extra_warnings(true)
        .opt_level(2)
        .files(["shim/guard.c", "shim/simulate.c", "shim/spec.c"])
        .compile("factotum_mujoco_shim");
}
