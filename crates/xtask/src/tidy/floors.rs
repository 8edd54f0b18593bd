//! The floors of the house: a crate imports only crates on lower floors.

use super::Violation;
use crate::workspace::Crate;

/// Each crate's floor. `xtask` stands outside: it imports no room and no room imports it.
const FLOORS: [(&str, u8); 18] = [
    ("geometry", 0),
    ("protocol", 0),
    ("task_planning", 0),
    ("descriptions", 1),
    ("learning", 1),
    ("physics", 1),
    ("symbols", 1),
    ("control", 2),
    ("motion", 2),
    ("perception", 2),
    ("semantic_map", 3),
    ("skills", 3),
    ("agent", 4),
    ("worlds", 4),
    ("experiments", 5),
    ("ros", 5),
    ("studio", 5),
    ("cli", 6),
];

const OUTSIDE: &str = "xtask";

/// Imports by tests alone that the floors would forbid: importer, imported, and why it is right.
const TEST_EXCEPTIONS: [(&str, &str, &str); 0] = [];

pub(super) fn check(crates: &[Crate]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for member in crates {
        if member.folder != OUTSIDE && floor(&member.folder).is_none() {
            violations.push(Violation::new(
                place(member),
                "has no floor; give it one in xtask's table of floors",
            ));
        }
        for imported in &member.imports {
            violations.extend(import_violation(member, imported));
        }
        let for_tests = member.imports_for_tests.iter().filter(|imported| {
            !TEST_EXCEPTIONS
                .iter()
                .any(|(from, to, _)| *from == member.folder && to == imported)
        });
        for imported in for_tests {
            violations.extend(import_violation(member, imported));
        }
    }
    violations
}

pub(super) fn floor(folder: &str) -> Option<u8> {
    FLOORS
        .iter()
        .find(|(name, _)| *name == folder)
        .map(|(_, floor)| *floor)
}

fn place(member: &Crate) -> String {
    format!("crates/{}", member.folder)
}

fn import_violation(member: &Crate, imported: &str) -> Option<Violation> {
    let (from, to) = (floor(&member.folder), floor(imported));
    match (from, to) {
        (Some(from), Some(to)) if to < from => None,
        (Some(from), Some(to)) => Some(Violation::new(
            place(member),
            format!(
                "floor {from} imports `{imported}` on floor {to}; a crate imports only lower floors"
            ),
        )),
        _ => Some(Violation::new(
            place(member),
            format!("imports `{imported}`, and xtask and the rooms stay apart"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn member(folder: &str, imports: &[&str], imports_for_tests: &[&str]) -> Crate {
        let set = |names: &[&str]| {
            names
                .iter()
                .map(|&name| name.to_owned())
                .collect::<BTreeSet<_>>()
        };
        Crate {
            folder: folder.to_owned(),
            imports: set(imports),
            imports_for_tests: set(imports_for_tests),
        }
    }

    #[test]
    fn lower_floors_may_be_imported() {
        assert_eq!(
            check(&[member(
                "motion",
                &["physics", "geometry"],
                &["descriptions"]
            )]),
            []
        );
    }

    #[test]
    fn a_higher_floor_is_caught() {
        let violations = check(&[member("physics", &["motion"], &[])]);
        assert_eq!(violations.len(), 1);
        assert!(
            violations[0]
                .to_string()
                .contains("floor 1 imports `motion` on floor 2"),
            "{}",
            violations[0]
        );
    }

    #[test]
    fn the_same_floor_is_caught_in_tests_too() {
        assert_eq!(check(&[member("agent", &[], &["worlds"])]).len(), 1);
    }

    #[test]
    fn a_crate_without_a_floor_is_caught() {
        assert_eq!(check(&[member("attic", &[], &[])]).len(), 1);
    }

    #[test]
    fn xtask_stays_outside() {
        assert_eq!(check(&[member("xtask", &[], &[])]), []);
        assert_eq!(check(&[member("xtask", &["geometry"], &[])]).len(), 1);
        assert_eq!(check(&[member("cli", &["xtask"], &[])]).len(), 1);
    }
}
