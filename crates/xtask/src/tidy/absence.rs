//! The two invariants of absence.
//!
//! 1. Planning scenes are compiled from belief, never from the running simulation. So the rooms that plan cannot reach
//!    `worlds` at all, and reach `physics` only through the rooms that make kinematic questions of it
//!    ([`DOORS_TO_PHYSICS`]); the executive cannot name a simulator even by a re-export.
//! 2. Whether a chore was achieved is said by the judge in `worlds`, never by the executive that tried. So a module
//!    called `judge` exists nowhere else, and no room below writes or reads a thing called `achieved`.

use std::collections::BTreeSet;

use super::rust_text::{self, has_word};
use super::{TextFile, Violation};
use crate::workspace::Crate;

/// Rooms that work from belief.
const BELIEVERS: [&str; 4] = ["agent", "skills", "semantic_map", "motion"];

/// The only rooms below `agent` that may import `physics`, for kinematics and dynamics of the robot's own model.
const DOORS_TO_PHYSICS: [&str; 3] = ["motion", "control", "perception"];

/// Rooms that must not know the judge's word.
const JUDGED: [&str; 6] = [
    "agent",
    "skills",
    "semantic_map",
    "motion",
    "control",
    "perception",
];

/// Checks the imports of the crates, of their tests too.
pub(super) fn check_imports(crates: &[Crate]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for believer in crates
        .iter()
        .filter(|member| BELIEVERS.contains(&member.folder.as_str()))
    {
        let place = format!("crates/{}", believer.folder);
        let within = reach(&believer.folder, crates);
        if within.contains("worlds") {
            violations.push(Violation::new(
                &place,
                "reaches `worlds`; planning works from belief, not from the simulation",
            ));
        }
        for importer in crates
            .iter()
            .filter(|member| within.contains(&member.folder))
        {
            if importer.imports.contains("physics")
                && !DOORS_TO_PHYSICS.contains(&importer.folder.as_str())
            {
                violations.push(Violation::new(
                    &place,
                    format!(
                        "reaches `physics` through `{}`; only {} may open it",
                        importer.folder,
                        DOORS_TO_PHYSICS.join(", ")
                    ),
                ));
            }
        }
        if believer.imports_for_tests.contains("worlds") {
            violations.push(Violation::new(
                &place,
                "tests against `worlds`; such a test belongs on floor 5 or 6",
            ));
        }
    }
    violations
}

/// Checks the text of the Rust sources.
pub(super) fn check_sources(files: &[TextFile]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for file in files.iter().filter(|file| file.path.ends_with(".rs")) {
        let Some(room) = file
            .path
            .strip_prefix("crates/")
            .and_then(|path| path.split('/').next())
        else {
            continue;
        };
        let code = rust_text::code(&file.text);
        if room == "agent" {
            for simulator in [
                "factotum_physics",
                "factotum_worlds",
                "physics",
                "worlds",
                "mujoco",
                "mujoco_rs",
            ] {
                if rust_text::has_path_segment(&code, simulator) {
                    violations.push(Violation::new(
                        &file.path,
                        format!("names `{simulator}`; the executive cannot know whether the robot is simulated"),
                    ));
                }
            }
        }
        if DOORS_TO_PHYSICS.contains(&room) && code.contains("pub use factotum_physics") {
            violations.push(Violation::new(
                &file.path,
                "re-exports `physics`, which would open it to the executive",
            ));
        }
        if room != "worlds" && (has_module(&code, "judge") || file.path.ends_with("/judge.rs")) {
            violations.push(Violation::new(
                &file.path,
                "has a judge; the only judge is in `worlds`",
            ));
        }
        if JUDGED.contains(&room) && has_word(&code, "achieved") {
            violations.push(Violation::new(
                &file.path,
                "says `achieved`, which only the judge in `worlds` may say",
            ));
        }
    }
    violations
}

fn has_module(code: &str, name: &str) -> bool {
    let words: Vec<&str> = code.split_whitespace().collect();
    words
        .windows(2)
        .any(|pair| pair[0] == "mod" && pair[1].trim_end_matches([';', '{']) == name)
}

/// Every crate that `from` imports, directly or not, and itself; imports for tests are not followed.
fn reach(from: &str, crates: &[Crate]) -> BTreeSet<String> {
    let mut within = BTreeSet::from([from.to_owned()]);
    let mut open = vec![from.to_owned()];
    while let Some(folder) = open.pop() {
        let imports = crates
            .iter()
            .filter(|member| member.folder == folder)
            .flat_map(|member| &member.imports);
        for imported in imports {
            if within.insert(imported.clone()) {
                open.push(imported.clone());
            }
        }
    }
    within
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(folder: &str, imports: &[&str]) -> Crate {
        Crate {
            folder: folder.to_owned(),
            imports: imports.iter().map(|&name| name.to_owned()).collect(),
            imports_for_tests: BTreeSet::new(),
        }
    }

    fn source(path: &str, text: &str) -> Vec<Violation> {
        check_sources(&[TextFile {
            path: path.to_owned(),
            text: text.to_owned(),
        }])
    }

    #[test]
    fn physics_behind_motion_is_allowed() {
        let crates = [
            member("agent", &["motion"]),
            member("motion", &["physics"]),
            member("physics", &[]),
        ];
        assert_eq!(check_imports(&crates), []);
    }

    #[test]
    fn the_executive_importing_physics_is_caught() {
        assert_eq!(
            check_imports(&[member("agent", &["physics"]), member("physics", &[])]).len(),
            1
        );
    }

    #[test]
    fn physics_through_another_room_is_caught_for_each_believer() {
        let crates = [
            member("agent", &["skills"]),
            member("skills", &["physics"]),
            member("physics", &[]),
        ];
        assert_eq!(check_imports(&crates).len(), 2);
    }

    #[test]
    fn reaching_the_simulation_indirectly_is_caught() {
        let crates = [
            member("semantic_map", &["symbols"]),
            member("symbols", &["worlds"]),
            member("worlds", &[]),
        ];
        assert_eq!(check_imports(&crates).len(), 1);
    }

    #[test]
    fn testing_against_the_simulation_is_caught() {
        let mut agent = member("agent", &[]);
        agent.imports_for_tests.insert("worlds".to_owned());
        assert_eq!(check_imports(&[agent]).len(), 1);
    }

    #[test]
    fn the_executive_naming_a_simulator_is_caught() {
        assert_eq!(
            source(
                "crates/agent/src/lib.rs",
                "use factotum_motion::physics::Model;"
            )
            .len(),
            1
        );
        assert_eq!(
            source(
                "crates/agent/src/lib.rs",
                "// the physics::engine is not known here"
            )
            .len(),
            0
        );
        assert_eq!(
            source("crates/motion/src/lib.rs", "use factotum_physics::Model;").len(),
            0
        );
    }

    #[test]
    fn a_door_that_re_exports_physics_is_caught() {
        assert_eq!(
            source(
                "crates/motion/src/lib.rs",
                "pub use factotum_physics::Model;"
            )
            .len(),
            1
        );
    }

    #[test]
    fn a_second_judge_is_caught() {
        assert_eq!(source("crates/agent/src/lib.rs", "mod judge;").len(), 1);
        assert_eq!(source("crates/skills/src/judge.rs", "").len(), 1);
        assert_eq!(
            source("crates/worlds/src/lib.rs", "pub mod judge;").len(),
            0
        );
    }

    #[test]
    fn the_executive_claiming_success_is_caught() {
        assert_eq!(
            source("crates/agent/src/report.rs", "Report { achieved: true }").len(),
            1
        );
        assert_eq!(
            source(
                "crates/agent/src/report.rs",
                "// what was achieved is the judge's word"
            )
            .len(),
            0
        );
        assert_eq!(
            source("crates/cli/src/run.rs", "let achieved = judge.verdict();").len(),
            0
        );
    }
}
