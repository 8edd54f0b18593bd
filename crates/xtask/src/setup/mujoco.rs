//! MuJoCo's library and headers, in `.deps/mujoco`, where `.cargo/config.toml` and the rpath expect them.
//!
//! A copy of the right version that the machine already has (named by `MUJOCO_DYNAMIC_LINK_DIR`, or known to
//! pkg-config) is linked to; otherwise the library comes from the wheel that DeepMind publishes on PyPI.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};

use super::Outcome;
use super::wheel::{self, Wheel};
use crate::process;
use crate::workspace::Workspace;

const VERSION: &str = "3.17.0";

/// What MuJoCo ships for one platform.
struct Release {
    os: &'static str,
    arch: &'static str,
    wheel: Wheel,
    /// The library's name in the wheel.
    library: &'static str,
    /// The name the linker looks for.
    link_name: &'static str,
    library_sha256: Option<&'static str>,
}

const RELEASES: [Release; 3] = [
    Release {
        os: "linux",
        arch: "x86_64",
        wheel: Wheel {
            requirement: "mujoco==3.17.0",
            python: "3.12",
            platforms: &["manylinux_2_28_x86_64", "manylinux_2_27_x86_64"],
            sha256: "42371356efe53a5f5f73ed03fcb967bdf04048017f80e2fca01e71a360e42da2",
        },
        library: "libmujoco.so.3.17.0",
        link_name: "libmujoco.so",
        library_sha256: Some("23496b023ee80fb61ab71167e94bc649f9941710fde96b18bb8204fb332523ad"),
    },
    Release {
        os: "linux",
        arch: "aarch64",
        wheel: Wheel {
            requirement: "mujoco==3.17.0",
            python: "3.12",
            platforms: &["manylinux_2_28_aarch64", "manylinux_2_27_aarch64"],
            sha256: "525e09a00ecd964f06582773d9eeb03bb0e5a1675edf296a6868024759b3b235",
        },
        library: "libmujoco.so.3.17.0",
        link_name: "libmujoco.so",
        library_sha256: Some("e2edd0204fb9229f75f332a4fcd1a32345bb9f90651dc0fddfa20ec0670db789"),
    },
    Release {
        os: "macos",
        arch: "aarch64",
        wheel: Wheel {
            requirement: "mujoco==3.17.0",
            python: "3.12",
            platforms: &["macosx_11_0_arm64"],
            sha256: "c677ab789299db70ca3fffe96b44a424bdad516cc87cc2a83898140923c2e91e",
        },
        library: "libmujoco.3.17.0.dylib",
        link_name: "libmujoco.dylib",
        library_sha256: None,
    },
];

/// Sees to `.deps/mujoco/lib` and `.deps/mujoco/include`.
pub(super) fn ensure(workspace: &Workspace) -> Result<Outcome> {
    let place = workspace.deps().join("mujoco");
    let release = RELEASES
        .iter()
        .find(|r| r.os == std::env::consts::OS && r.arch == std::env::consts::ARCH);
    if is_right(&place, release) {
        return Ok(Outcome::Found(format!("{VERSION} is in .deps/mujoco")));
    }
    if let Some(installed) = installed(&place) {
        let workshop = wheel::workshop(&place)?;
        installed.link_into(&workshop)?;
        wheel::put_in_place(&workshop, &place)?;
        return Ok(Outcome::Fetched(format!(
            "linked to {}",
            installed.library.display()
        )));
    }
    let Some(release) = release else {
        bail!(
            "there is no MuJoCo {VERSION} wheel for {} on {}; install MuJoCo {VERSION} and set \
             MUJOCO_DYNAMIC_LINK_DIR to the folder of its library",
            std::env::consts::OS,
            std::env::consts::ARCH,
        );
    };
    let workshop = wheel::workshop(&place)?;
    fetch(release, &workshop).with_context(|| {
        format!("cannot fetch MuJoCo {VERSION}, without which Factotum does not build")
    })?;
    wheel::put_in_place(&workshop, &place)?;
    Ok(Outcome::Fetched(format!(
        "{VERSION} fetched into .deps/mujoco"
    )))
}

/// Whether the folder holds the library and headers of the right version.
fn is_right(place: &Path, release: Option<&Release>) -> bool {
    let Some(library) = library_in(&place.join("lib")) else {
        return false;
    };
    if !place.join("include/mujoco/mujoco.h").is_file() {
        return false;
    }
    // A library that is not ours to check (a link to the machine's own) was checked by its version when linked.
    let ours = library.starts_with(fs::canonicalize(place).unwrap_or_default());
    match release.and_then(|r| r.library_sha256).filter(|_| ours) {
        Some(expected) => wheel::sha256_of(&library).is_ok_and(|found| found == expected),
        None => true,
    }
}

/// The file of the right version that the linker would find in a folder, with every link followed.
fn library_in(folder: &Path) -> Option<PathBuf> {
    ["libmujoco.so", "libmujoco.dylib"]
        .iter()
        .find_map(|link_name| {
            let library = fs::canonicalize(folder.join(link_name)).ok()?;
            library
                .file_name()?
                .to_str()?
                .contains(VERSION)
                .then_some(library)
        })
}

/// A MuJoCo of the right version that the machine has.
#[derive(Debug)]
struct Installed {
    library: PathBuf,
    headers: PathBuf,
}

impl Installed {
    fn in_folders(lib: &Path, include: &Path) -> Option<Self> {
        let library = library_in(lib)?;
        let headers = fs::canonicalize(include.join("mujoco")).ok()?;
        headers
            .join("mujoco.h")
            .is_file()
            .then_some(Self { library, headers })
    }

    fn link_into(&self, folder: &Path) -> Result<()> {
        let lib = folder.join("lib");
        let include = folder.join("include");
        fs::create_dir_all(&lib).with_context(|| format!("cannot create {}", lib.display()))?;
        fs::create_dir_all(&include)
            .with_context(|| format!("cannot create {}", include.display()))?;
        let name = self
            .library
            .file_name()
            .context("the library has no name")?;
        let link_name = if self.library.extension().is_some_and(|e| e == "dylib") {
            "libmujoco.dylib"
        } else {
            "libmujoco.so"
        };
        symlink(&self.library, lib.join(name)).context("cannot link the library")?;
        symlink(name, lib.join(link_name)).context("cannot link the library")?;
        symlink(&self.headers, include.join("mujoco")).context("cannot link the headers")
    }
}

/// Looks where the user says, then where pkg-config says.
fn installed(place: &Path) -> Option<Installed> {
    let named = std::env::var_os("MUJOCO_DYNAMIC_LINK_DIR")
        .map(PathBuf::from)
        .filter(|lib| *lib != place.join("lib"))
        .and_then(|lib| Installed::in_folders(&lib, &lib.parent()?.join("include")));
    named.or_else(|| {
        let ask = |what| {
            let answer =
                process::capture(Command::new("pkg-config").args([what, "mujoco"])).ok()?;
            Some(answer.trim().to_owned())
        };
        if ask("--modversion")? != VERSION {
            return None;
        }
        Installed::in_folders(
            Path::new(&ask("--variable=libdir")?),
            Path::new(&ask("--variable=includedir")?),
        )
    })
}

fn fetch(release: &Release, workshop: &Path) -> Result<()> {
    let unpacked = workshop.join("wheel");
    fs::create_dir_all(&unpacked)
        .with_context(|| format!("cannot create {}", unpacked.display()))?;
    wheel::fetch_into(&release.wheel, &unpacked)?;
    let lib = workshop.join("lib");
    fs::create_dir_all(&lib).with_context(|| format!("cannot create {}", lib.display()))?;
    let move_out = |from: &str, to: PathBuf| {
        let from = unpacked.join(from);
        fs::rename(&from, &to).with_context(|| format!("the wheel has no {}", from.display()))
    };
    move_out(
        &format!("mujoco/{}", release.library),
        lib.join(release.library),
    )?;
    move_out("mujoco/include", workshop.join("include"))?;
    symlink(release.library, lib.join(release.link_name)).context("cannot link the library")?;
    if let Some(expected) = release.library_sha256 {
        let found = wheel::sha256_of(&lib.join(release.library))?;
        if found != expected {
            bail!(
                "{} has SHA-256 {found}, expected {expected}",
                release.library
            );
        }
    }
    fs::remove_dir_all(&unpacked).with_context(|| format!("cannot remove {}", unpacked.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine_with(version: &str) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("lib")).unwrap();
        fs::create_dir_all(dir.path().join("include/mujoco")).unwrap();
        let file = format!("libmujoco.so.{version}");
        fs::write(dir.path().join("lib").join(&file), "library").unwrap();
        symlink(&file, dir.path().join("lib/libmujoco.so")).unwrap();
        fs::write(dir.path().join("include/mujoco/mujoco.h"), "").unwrap();
        dir
    }

    #[test]
    fn the_right_version_on_the_machine_is_linked_to_and_then_found_right() {
        let machine = machine_with(VERSION);
        let found =
            Installed::in_folders(&machine.path().join("lib"), &machine.path().join("include"))
                .unwrap();
        let dir = tempfile::tempdir().unwrap();
        let place = dir.path().join("mujoco");
        found.link_into(&place).unwrap();
        assert!(is_right(&place, RELEASES.first()));
        // The link dangles when the machine's copy goes.
        drop(machine);
        assert!(!is_right(&place, RELEASES.first()));
    }

    #[test]
    fn another_version_on_the_machine_is_not_used() {
        let machine = machine_with("3.2.7");
        assert!(
            Installed::in_folders(&machine.path().join("lib"), &machine.path().join("include"))
                .is_none()
        );
    }

    #[test]
    fn a_damaged_copy_of_our_own_is_not_right() {
        let place = machine_with(VERSION);
        assert!(
            !is_right(place.path(), RELEASES.first()),
            "its bytes are not those of the release"
        );
    }
}
