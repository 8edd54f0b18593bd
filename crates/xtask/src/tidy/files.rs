//! Rules about single files: their names, `unsafe`, ignored tests, places that exist on one machine only.

use super::rust_text::{self, has_word};
use super::{TextFile, Violation};

/// Names that say nothing about what is inside.
const EMPTY_NAMES: [&str; 4] = ["utils", "misc", "common", "helpers"];

/// The room that wraps the physics engine's C interface.
const UNSAFE_ROOM: &str = "crates/physics/";

/// Beginnings of absolute paths that mean something on one machine only.
const MACHINE_PATHS: [&str; 7] = [
    "/home/",
    "/root/",
    "/Users/",
    "/tmp/",
    "/var/tmp/",
    "/work/",
    "/mnt/",
];

/// This file has to spell out what it looks for.
const THIS_FILE: &str = "crates/xtask/src/tidy/files.rs";

const N_LINES_MAX: usize = 1000;

pub(super) fn check(files: &[TextFile]) -> Vec<Violation> {
    files
        .iter()
        .flat_map(|file| [name(file), code(file), machine_path(file), lock_file(file)])
        .flatten()
        .collect()
}

/// Files with more lines than one idea needs.
pub(super) fn long(files: &[TextFile]) -> Vec<(&str, usize)> {
    let by_hand = |path: &str| path.ends_with(".rs") || path.ends_with(".ts");
    files
        .iter()
        .filter(|file| by_hand(&file.path))
        .map(|file| (file.path.as_str(), file.text.lines().count()))
        .filter(|(_, n_lines)| *n_lines > N_LINES_MAX)
        .collect()
}

fn name(file: &TextFile) -> Option<Violation> {
    let parts = file
        .path
        .split('/')
        .map(|part| part.split('.').next().unwrap_or(part));
    let source = file.path.ends_with(".rs") || file.path.ends_with(".ts");
    let empty = parts
        .into_iter()
        .find(|part| EMPTY_NAMES.contains(part))
        .filter(|_| source)?;
    Some(Violation::new(
        &file.path,
        format!("is called `{empty}`; name the concept"),
    ))
}

fn code(file: &TextFile) -> Option<Violation> {
    if !file.path.ends_with(".rs") {
        return None;
    }
    let code = rust_text::code(&file.text);
    if !file.path.starts_with(UNSAFE_ROOM) && has_word(&code, "unsafe") {
        return Some(Violation::new(
            &file.path,
            "has `unsafe`, which only `physics` may have",
        ));
    }
    let ignored = code.replace(char::is_whitespace, "").contains("#[ignore");
    ignored.then(|| {
        Violation::new(
            &file.path,
            "ignores a test; assert today's behaviour with a FIXME instead",
        )
    })
}

fn machine_path(file: &TextFile) -> Option<Violation> {
    if file.path == THIS_FILE {
        return None;
    }
    let (line_idx, found) = file.text.lines().enumerate().find_map(|(line_idx, line)| {
        let begins = |at: usize| {
            let before = line[..at].chars().next_back();
            !before.is_some_and(|c| {
                c.is_alphanumeric()
                    || matches!(c, '.' | '_' | '-' | '/' | ':' | '}' | '~' | '*' | '>' | ')')
            })
        };
        let found = MACHINE_PATHS
            .iter()
            .find(|path| line.match_indices(**path).any(|(at, _)| begins(at)))?;
        Some((line_idx, found))
    })?;
    Some(Violation::new(
        format!("{}:{}", file.path, line_idx + 1),
        format!("names `{found}`, a place on one machine"),
    ))
}

/// Lock files must name the public registries, whatever mirror they were made behind.
fn lock_file(file: &TextFile) -> Option<Violation> {
    let (key, public) = match file.path.rsplit('/').next()? {
        "Cargo.lock" => (
            "source = \"",
            "registry+https://github.com/rust-lang/crates.io-index\"",
        ),
        "package-lock.json" => ("\"resolved\": \"", "https://registry.npmjs.org/"),
        _ => return None,
    };
    let source = file
        .text
        .split(key)
        .skip(1)
        .find(|rest| !rest.starts_with(public))?;
    let source = source.split('"').next().unwrap_or_default();
    Some(Violation::new(
        &file.path,
        format!(
            "takes a package from `{source}`, expected `{}`",
            public.trim_end_matches('"')
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violations(path: &str, text: &str) -> usize {
        check(&[TextFile {
            path: path.to_owned(),
            text: text.to_owned(),
        }])
        .len()
    }

    #[test]
    fn empty_names_are_caught() {
        assert_eq!(violations("crates/motion/src/utils.rs", ""), 1);
        assert_eq!(violations("crates/motion/src/common/mod.rs", ""), 1);
        assert_eq!(violations("crates/motion/src/shortcut.rs", ""), 0);
    }

    #[test]
    fn unsafe_outside_physics_is_caught() {
        assert_eq!(violations("crates/motion/src/lib.rs", "unsafe { f() }"), 1);
        assert_eq!(violations("crates/physics/src/lib.rs", "unsafe { f() }"), 0);
        assert_eq!(violations("crates/motion/src/lib.rs", "// unsafe"), 0);
    }

    #[test]
    fn ignored_tests_are_caught() {
        assert_eq!(
            violations("crates/motion/src/lib.rs", "#[test]\n#[ignore]\nfn f() {}"),
            1
        );
        assert_eq!(
            violations(
                "crates/motion/src/lib.rs",
                "#[ignore = \"slow\"]\nfn f() {}"
            ),
            1
        );
    }

    #[test]
    fn machine_paths_are_caught() {
        assert_eq!(violations("README.md", "see `/home/me/factotum`"), 1);
        assert_eq!(violations("a.rs", "\"/tmp/x\""), 1);
        assert_eq!(
            violations(
                "README.md",
                "https://example.org/home/me and docs/work/plan"
            ),
            0
        );
    }

    #[test]
    fn a_lock_file_made_behind_a_mirror_is_caught() {
        assert_eq!(
            violations(
                "web/package-lock.json",
                r#""resolved": "https://mirror.example/a.tgz""#
            ),
            1
        );
        assert_eq!(
            violations(
                "web/package-lock.json",
                r#""resolved": "https://registry.npmjs.org/a.tgz""#
            ),
            0
        );
        assert_eq!(
            violations("Cargo.lock", "source = \"git+https://example.org/a\""),
            1
        );
    }

    #[test]
    fn long_files_are_listed() {
        let file = TextFile {
            path: "a.rs".to_owned(),
            text: "\n".repeat(N_LINES_MAX + 1),
        };
        assert_eq!(long(&[file]), [("a.rs", N_LINES_MAX + 1)]);
    }
}
