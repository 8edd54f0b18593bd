//! Trials, with a shell script in place of the program, and their table.

use std::path::Path;

use super::*;
use crate::grid::student::MeanInterval;
use crate::skill_folder::SkillRecord;

/// Notes its call and judges; a grasp that is off ends in a crash.
const STAND_IN: &str = r#"
echo "$*" >> CALLS
case "$*" in *grasp*) echo broken >&2; exit 3;; esac
rate=0.8; case "$*" in *"--friction 3"*) rate=0.5;; esac
echo "{\"success_rate\":$rate,\"violation_rate\":0.0,\"peak_force_n\":33.0,\"time_to_success_secs\":null,\"rollouts\":4}"
"#;

fn robustness(dir: &Path) -> Robustness {
    let script = STAND_IN.replace("CALLS", &format!("'{}'", dir.join("calls").display()));
    Robustness {
        program: "sh".into(),
        leading: ["-c", &script, "factotum"].map(str::to_owned).to_vec(),
        skills: dir.join("grid"),
        cells: Cell::all(&["door".to_owned()], &[Ablation::Fast], &[100, 101]),
        policy: WhichPolicy::Best,
        rollouts: 4,
        n_workers: 2,
        folder: dir.join("robustness"),
    }
}

/// Skill folders of its cells, with a policy that nobody reads.
fn learn(robustness: &Robustness) {
    for cell in &robustness.cells {
        let skill = robustness.skill(cell);
        let record = SkillRecord::new("door".into(), cell.ablation, cell.seed);
        skill.begin(&record).unwrap();
        std::fs::write(skill.policy(), "a policy").unwrap();
    }
}

fn calls(dir: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(dir.join("calls")).unwrap_or_default();
    let mut calls: Vec<String> = text.lines().map(str::to_owned).collect();
    calls.sort();
    calls
}

#[test]
fn each_skill_is_judged_once_under_each_condition() {
    let dir = tempfile::tempdir().unwrap();
    let robustness = robustness(dir.path());
    learn(&robustness);
    assert_eq!(robustness.n_trials(), 10);
    let run = || robustness.run(&StopWish::default(), |_, _| ()).unwrap();
    let results = run();
    assert_eq!(results.len(), 10);
    assert!(results.is_sorted_by_key(Outcome::key));
    let skill = robustness.skill(&robustness.cells[0]);
    let eval = format!(
        "skill eval {} --policy best --rollouts 4 --seed 100 --json",
        skill.dir().display()
    );
    let calls_made = calls(dir.path());
    for condition in Condition::ALL {
        let arguments = condition.arguments().join(" ");
        let wanted = format!("{eval} {arguments}").trim_end().to_owned();
        assert!(calls_made.contains(&wanted), "{wanted}: {calls_made:?}");
    }
    assert_eq!(run(), results);
    assert_eq!(calls(dir.path()).len(), 10, "nothing ran again");
    let crashed = &results[4];
    assert_eq!(
        crashed.key().to_string(),
        "door fast seed 100, grasp 3 mm, 3° off"
    );
    assert_eq!(crashed.failure.as_ref().unwrap().exit_code, Some(3));

    let (table, files) = report(&robustness.folder, dir.path()).unwrap();
    assert_eq!((table.n_trials, table.n_failed, files.len()), (10, 2, 2));
    let both = |mean| MeanInterval::of(&[mean, mean]);
    let [trained, _, heavy, _, grasp] = &table.rows[..] else {
        panic!("{:?}", table.rows)
    };
    assert_eq!(Some(trained.success_rate), both(0.8));
    assert_eq!(trained.success_change, None);
    let change = heavy.success_change.unwrap();
    assert!(
        change.n == 2 && (change.mean + 0.3).abs() < 1e-12,
        "{change:?}"
    );
    // A crash is no success, and has nothing else to tell.
    assert_eq!(Some(grasp.success_rate), both(0.0));
    assert_eq!(grasp.peak_force_n, None);
    let markdown = table.to_markdown();
    let row = "| door | resistance × 3 | 2 | 50.0 ± 0.0 | -30.0 ± 0.0 | 0.0 ± 0.0 | 33 ± 0 |";
    assert!(markdown.contains(row), "{markdown}");
}

#[test]
fn a_skill_that_is_not_there_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let mut robustness = robustness(dir.path());
    let refused = |robustness: &Robustness| {
        let error = robustness.run(&StopWish::default(), |_, _| ()).unwrap_err();
        assert!(error.is_of_input());
        error.to_string()
    };
    let said = refused(&robustness);
    assert!(said.contains("policy.safetensors"), "{said}");
    assert!(said.contains("door fast seed 100"), "{said}");
    learn(&robustness);
    robustness.policy = WhichPolicy::Last;
    let said = refused(&robustness);
    assert!(
        said.contains("checkpoint.safetensors") && said.contains("--keep-checkpoints"),
        "{said}"
    );
    assert!(!robustness.folder.exists());
}
