//! Documents that stay true: ARCHITECTURE.md names each crate and only paths that exist, and no link is broken.

use super::{TextFile, Violation};
use crate::workspace::Crate;

const ARCHITECTURE: &str = "ARCHITECTURE.md";
const N_LINES_MAX: usize = 200;

/// Checks that ARCHITECTURE.md names every crate, names no path that is not there, and stays short.
pub(super) fn check_architecture(
    crates: &[Crate],
    paths: &[String],
    files: &[TextFile],
) -> Vec<Violation> {
    let Some(file) = files.iter().find(|file| file.path == ARCHITECTURE) else {
        return vec![Violation::new(ARCHITECTURE, "is missing")];
    };
    let names: Vec<&str> = code_spans(&file.text).collect();
    let mut violations = Vec::new();
    for member in crates {
        let path = format!("crates/{}", member.folder);
        if !names
            .iter()
            .any(|name| *name == member.folder || name.trim_end_matches('/') == path)
        {
            violations.push(Violation::new(
                ARCHITECTURE,
                format!("does not name the crate `{}`", member.folder),
            ));
        }
    }
    for name in names
        .iter()
        .filter(|name| is_path_here(name, paths) && !exists(name, paths))
    {
        violations.push(Violation::new(
            ARCHITECTURE,
            format!("names `{name}`, which does not exist"),
        ));
    }
    let n_lines = file.text.lines().count();
    if n_lines > N_LINES_MAX {
        violations.push(Violation::new(
            ARCHITECTURE,
            format!("has {n_lines} lines, at most {N_LINES_MAX} are wanted"),
        ));
    }
    violations
}

/// Checks that each relative link in a Markdown file leads to a tracked file or folder.
pub(super) fn check_links(paths: &[String], files: &[TextFile]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with(".md")) {
        for target in links(&file.text).filter(|target| is_relative(target)) {
            let without_anchor = target.split('#').next().unwrap_or(target);
            let resolved = resolve(&file.path, without_anchor);
            if !resolved.as_deref().is_some_and(|path| exists(path, paths)) {
                violations.push(Violation::new(
                    &file.path,
                    format!("links to `{target}`, which does not exist"),
                ));
            }
        }
    }
    violations
}

/// The text between single back quotes, outside fenced blocks.
fn code_spans(markdown: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    markdown
        .lines()
        .filter(move |line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            !fenced && !fence
        })
        .flat_map(|line| line.split('`').skip(1).step_by(2))
}

/// Whether the words look like a path of this repository: their first part is a folder or a file at the root.
fn is_path_here(name: &str, paths: &[String]) -> bool {
    let plain = !name.contains([' ', '*', '<', '{', '$']);
    let first = name.split('/').next().unwrap_or(name);
    let folder = name.contains('/')
        && paths
            .iter()
            .any(|path| path.split_once('/').is_some_and(|(f, _)| f == first));
    let root_file = !name.contains('/') && name.ends_with(".md");
    plain && (folder || root_file)
}

fn exists(name: &str, paths: &[String]) -> bool {
    let name = name.trim_end_matches('/');
    paths.iter().any(|path| {
        path.strip_prefix(name)
            .is_some_and(|rest| name.is_empty() || rest.is_empty() || rest.starts_with('/'))
    })
}

/// Targets of `[text](target)` and `![text](target)`.
fn links(markdown: &str) -> impl Iterator<Item = &str> {
    markdown
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split([')', ' ', '\n']).next())
}

fn is_relative(target: &str) -> bool {
    !target.is_empty()
        && !target.starts_with('#')
        && !target.contains("://")
        && !target.starts_with("mailto:")
}

/// The target's path from the root; nothing if it leaves the repository.
fn resolve(from: &str, target: &str) -> Option<String> {
    let mut parts: Vec<&str> = from.split('/').collect();
    parts.pop();
    for part in target.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn paths() -> Vec<String> {
        [
            "ARCHITECTURE.md",
            "README.md",
            "crates/geometry/src/lib.rs",
            "docs/frames.md",
            "docs/images/a.png",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn architecture(text: &str) -> Vec<Violation> {
        let geometry = Crate {
            folder: "geometry".to_owned(),
            imports: BTreeSet::new(),
            imports_for_tests: BTreeSet::new(),
        };
        check_architecture(
            &[geometry],
            &paths(),
            &[TextFile {
                path: ARCHITECTURE.to_owned(),
                text: text.to_owned(),
            }],
        )
    }

    fn broken(path: &str, text: &str) -> usize {
        check_links(
            &paths(),
            &[TextFile {
                path: path.to_owned(),
                text: text.to_owned(),
            }],
        )
        .len()
    }

    #[test]
    fn a_true_page_passes() {
        assert_eq!(
            architecture(
                "`geometry` is in `crates/geometry/src/lib.rs`, see `docs/frames.md`; `a * b`"
            ),
            []
        );
    }

    #[test]
    fn a_crate_that_is_not_named_is_caught() {
        let violations = architecture("geometry without quotes is not a name");
        assert!(
            violations[0].to_string().contains("`geometry`"),
            "{}",
            violations[0]
        );
    }

    #[test]
    fn a_path_that_went_stale_is_caught() {
        assert_eq!(
            architecture("`geometry`, `crates/geometry/src/old.rs`").len(),
            1
        );
        assert_eq!(architecture("`geometry`, `STYLE.md`").len(), 1);
    }

    #[test]
    fn a_missing_or_long_page_is_caught() {
        assert_eq!(check_architecture(&[], &paths(), &[]).len(), 1);
        assert_eq!(
            architecture(&"`geometry`\n".repeat(N_LINES_MAX + 1)).len(),
            1
        );
    }

    #[test]
    fn fenced_blocks_name_nothing() {
        assert_eq!(architecture("`geometry`\n```\n`crates/nowhere`\n```\n"), []);
    }

    #[test]
    fn links_are_followed_from_their_file() {
        assert_eq!(
            broken(
                "docs/frames.md",
                "[a](images/a.png) [b](../README.md#top) [c](https://example.org)"
            ),
            0
        );
        assert_eq!(broken("docs/frames.md", "![a](a.png)"), 1);
        assert_eq!(broken("README.md", "[out](../elsewhere.md)"), 1);
    }
}
