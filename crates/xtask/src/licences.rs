//! `cargo x licences`: the licence and source of every dependency, against the lists in `deny.toml`.
//!
//! cargo-deny does this where it is installed; otherwise the same lists are checked from `cargo metadata`.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result, bail};
use serde_json::Value;

use crate::process;
use crate::workspace::{Dependencies, Workspace};

const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let policy = Policy::read(
        &std::fs::read_to_string(workspace.path("deny.toml")).context("cannot read deny.toml")?,
    )?;
    if process::find_on_path("cargo-deny").is_some() {
        process::run(&mut workspace.cargo(&["deny", "check", "licenses", "bans", "sources"]))?;
    } else {
        check_crates(workspace, &policy)?;
    }
    check_page(workspace, &policy)
}

fn check_crates(workspace: &Workspace, policy: &Policy) -> Result<()> {
    let metadata = workspace.metadata(Dependencies::Resolved)?;
    let packages = metadata["packages"]
        .as_array()
        .context("`cargo metadata` lists no packages")?;
    let problems = packages
        .iter()
        .filter_map(|package| policy.problem(package))
        .collect();
    none_of(problems)?;
    eprintln!(
        "licences: {} crates are allowed by deny.toml (cargo-deny is not installed)",
        packages.len()
    );
    Ok(())
}

/// Checks the npm packages that the built page contains; those that only build it do not travel with it.
fn check_page(workspace: &Workspace, policy: &Policy) -> Result<()> {
    let Ok(lock) = std::fs::read_to_string(workspace.path("web/package-lock.json")) else {
        return Ok(());
    };
    let lock: Value = serde_json::from_str(&lock).context("web/package-lock.json is not JSON")?;
    none_of(policy.page_problems(&lock))?;
    eprintln!("licences: the page's packages are allowed by deny.toml");
    Ok(())
}

fn none_of(problems: Vec<String>) -> Result<()> {
    if problems.is_empty() {
        return Ok(());
    }
    bail!(
        "{} dependencies are not allowed:\n  {}",
        problems.len(),
        problems.join("\n  ")
    );
}

/// What `deny.toml` allows.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Policy {
    licences: BTreeSet<String>,
    /// Crates by name with the further licences that are allowed for them alone.
    exceptions: Vec<(String, BTreeSet<String>)>,
    banned: BTreeSet<String>,
}

impl Policy {
    fn read(text: &str) -> Result<Self> {
        let table: toml::Table = text.parse().context("deny.toml is not TOML")?;
        let array = |section: &str, key: &str| {
            table
                .get(section)
                .and_then(|s| s.get(key))
                .and_then(toml::Value::as_array)
                .cloned()
                .unwrap_or_default()
        };
        let licences = strings(&array("licenses", "allow"));
        if licences.is_empty() {
            bail!("deny.toml has no list `licenses.allow`");
        }
        let exceptions = array("licenses", "exceptions")
            .iter()
            .filter_map(|entry| {
                let name = entry
                    .get("crate")
                    .or_else(|| entry.get("name"))?
                    .as_str()?
                    .to_owned();
                Some((name, strings(entry.get("allow")?.as_array()?)))
            })
            .collect();
        let banned = array("bans", "deny")
            .iter()
            .filter_map(|entry| {
                Some(
                    entry
                        .get("crate")
                        .or_else(|| entry.get("name"))?
                        .as_str()?
                        .to_owned(),
                )
            })
            .collect();
        Ok(Self {
            licences,
            exceptions,
            banned,
        })
    }

    /// Why a package is not allowed, if it is not.
    fn problem(&self, package: &Value) -> Option<String> {
        let name = package["name"].as_str()?;
        let what = format!("{name} {}", package["version"].as_str().unwrap_or("?"));
        if self.banned.contains(name) {
            return Some(format!("{what} is banned"));
        }
        // Packages of the workspace have no source.
        let source = package["source"].as_str()?;
        if source != CRATES_IO {
            return Some(format!("{what} comes from {source}, expected crates.io"));
        }
        let Some(expression) = package["license"].as_str() else {
            return Some(format!("{what} states no licence"));
        };
        let further = self
            .exceptions
            .iter()
            .find(|(exempt, _)| exempt == name)
            .map(|(_, licences)| licences);
        let allowed = |licence: &str| {
            self.licences.contains(licence)
                || further.is_some_and(|licences| licences.contains(licence))
        };
        (!Expression::new(expression).satisfied_by(&allowed))
            .then(|| format!("{what} is under {expression}"))
    }

    /// Packages of an npm lock file, the page's own aside, that are shipped and not allowed.
    fn page_problems(&self, lock: &Value) -> Vec<String> {
        let allowed = |licence: &str| self.licences.contains(licence);
        let packages = lock["packages"].as_object().into_iter().flatten();
        packages
            .filter(|(place, package)| !place.is_empty() && package["dev"] != Value::Bool(true))
            .filter_map(|(place, package)| {
                let licence = package["license"].as_str().unwrap_or("no stated licence");
                let is_allowed = Expression::new(licence).satisfied_by(&allowed);
                (!is_allowed).then(|| format!("{place} is under {licence}"))
            })
            .collect()
    }
}

fn strings(values: &[toml::Value]) -> BTreeSet<String> {
    values
        .iter()
        .filter_map(|value| Some(value.as_str()?.to_owned()))
        .collect()
}

/// An SPDX licence expression (SPDX 2.3, annex D), and the older form that separates choices by `/`.
struct Expression {
    words: Vec<String>,
    at: usize,
}

impl Expression {
    fn new(text: &str) -> Self {
        let spaced = text
            .replace('(', " ( ")
            .replace(')', " ) ")
            .replace('/', " OR ");
        Self {
            words: spaced.split_whitespace().map(str::to_owned).collect(),
            at: 0,
        }
    }

    /// Whether some choice among its licences is allowed throughout; an expression that cannot be read is not.
    fn satisfied_by(mut self, allowed: &dyn Fn(&str) -> bool) -> bool {
        let satisfied = self.choice(allowed);
        satisfied && self.at == self.words.len()
    }

    fn choice(&mut self, allowed: &dyn Fn(&str) -> bool) -> bool {
        let mut satisfied = self.conjunction(allowed);
        while self.take("OR") {
            satisfied |= self.conjunction(allowed);
        }
        satisfied
    }

    fn conjunction(&mut self, allowed: &dyn Fn(&str) -> bool) -> bool {
        let mut satisfied = self.licence(allowed);
        while self.take("AND") {
            satisfied &= self.licence(allowed);
        }
        satisfied
    }

    fn licence(&mut self, allowed: &dyn Fn(&str) -> bool) -> bool {
        if self.take("(") {
            let satisfied = self.choice(allowed);
            return self.take(")") && satisfied;
        }
        let Some(mut licence) = self.words.get(self.at).cloned() else {
            return false;
        };
        self.at += 1;
        if self.take("WITH")
            && let Some(exception) = self.words.get(self.at)
        {
            licence = format!("{licence} WITH {exception}");
            self.at += 1;
        }
        allowed(&licence)
    }

    fn take(&mut self, word: &str) -> bool {
        let found = self.words.get(self.at).is_some_and(|w| w == word);
        self.at += usize::from(found);
        found
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const POLICY: &str = r#"
        [licenses]
        allow = ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception"]
        exceptions = [{ crate = "webpki-roots", allow = ["MPL-2.0"] }]
        [bans]
        deny = [{ crate = "openssl-sys" }]
    "#;

    fn package(name: &str, license: &str, source: &str) -> Value {
        json!({"name": name, "version": "1.0.0", "license": license, "source": source})
    }

    fn is_allowed(package: &Value) -> bool {
        Policy::read(POLICY).unwrap().problem(package).is_none()
    }

    #[test]
    fn expressions_are_read_as_spdx_says() {
        for (license, allowed) in [
            ("MIT", true),
            ("MIT OR Apache-2.0", true),
            ("MIT/GPL-3.0", true),
            ("GPL-3.0-only", false),
            ("MIT AND GPL-3.0-only", false),
            ("GPL-3.0-only OR (MIT AND Apache-2.0)", true),
            ("(MIT OR Apache-2.0) AND GPL-3.0-only", false),
            ("Apache-2.0 WITH LLVM-exception", true),
            ("MIT WITH Unheard-of-exception", false),
            ("(MIT", false),
            ("", false),
        ] {
            assert_eq!(
                is_allowed(&package("a", license, CRATES_IO)),
                allowed,
                "{license}"
            );
        }
    }

    #[test]
    fn an_exception_is_for_one_crate_alone() {
        assert!(is_allowed(&package("webpki-roots", "MPL-2.0", CRATES_IO)));
        assert!(!is_allowed(&package("another", "MPL-2.0", CRATES_IO)));
    }

    #[test]
    fn other_sources_and_banned_crates_are_caught() {
        assert!(!is_allowed(&package(
            "a",
            "MIT",
            "git+https://example.org/a"
        )));
        assert!(!is_allowed(&package("openssl-sys", "MIT", CRATES_IO)));
    }

    #[test]
    fn a_package_without_a_licence_is_caught() {
        assert!(!is_allowed(
            &json!({"name": "a", "version": "1.0.0", "license": null, "source": CRATES_IO})
        ));
    }

    #[test]
    fn only_what_the_page_ships_is_checked() {
        let lock = json!({"packages": {
            "": {"license": "MIT OR Apache-2.0"},
            "node_modules/three": {"license": "MIT"},
            "node_modules/shipped": {"license": "GPL-3.0-only"},
            "node_modules/nameless": {},
            "node_modules/builder": {"license": "MPL-2.0", "dev": true},
        }});
        let problems = Policy::read(POLICY).unwrap().page_problems(&lock);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems.iter().any(|problem| problem.contains("shipped")));
        assert!(problems.iter().any(|problem| problem.contains("nameless")));
    }

    #[test]
    fn a_policy_that_allows_nothing_is_an_error() {
        assert!(Policy::read("[licenses]").is_err());
    }
}
