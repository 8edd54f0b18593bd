mod reports;
mod runs;

use factotum_skills::cip::training::EvaluationRecord;

use super::*;

/// An evaluation of ten rollouts.
fn evaluation(episode: u64, success_rate: f64, violation_rate: f64) -> EvaluationRecord {
    EvaluationRecord {
        episode,
        env_steps: 20 * episode,
        rollouts: 10,
        success_rate,
        violation_rate,
        peak_force_n: 50.0,
        time_to_success_secs: None,
    }
}

fn judgement(success_rate: f64) -> Judgement {
    Judgement {
        rollouts: 50,
        success_rate,
        violation_rate: 0.1,
        peak_force_n: 80.0,
        time_to_success_secs: (success_rate > 0.0).then_some(1.5),
    }
}

/// A cell of 20 episodes with these success rates: after 10 and 20 episodes, last, and best.
fn result(task: &str, ablation: Ablation, seed: u64, rates: [f64; 4]) -> CellResult {
    CellResult {
        task: task.to_owned(),
        ablation,
        seed,
        setting: setting_digest(&CipSetting::of(ablation)),
        wall_secs: 30.0,
        n_episodes: 20,
        n_env_steps: 400,
        training_violations: vec![3, 10, 11],
        training_peak_force_n: 300.0,
        evaluations: vec![evaluation(10, rates[0], 0.4), evaluation(20, rates[1], 0.2)],
        last: Some(judgement(rates[2])),
        best: Some(judgement(rates[3])),
        failure: None,
    }
}

/// A cell that crashed after an evaluation at 10 episodes.
fn crashed(task: &str, ablation: Ablation, seed: u64) -> CellResult {
    let mut result = result(task, ablation, seed, [0.5, 0.0, 0.0, 0.0]);
    result.evaluations.truncate(1);
    CellResult {
        n_episodes: 13,
        last: None,
        best: None,
        failure: Some(CellFailure {
            command: "skill train".to_owned(),
            exit_code: Some(3),
            messages: "error: not a number".to_owned(),
        }),
        ..result
    }
}

#[test]
fn cells_are_ordered_by_seed_then_task_then_setting() {
    let cell = |seed, task: &str, ablation| Cell {
        seed,
        task: task.to_owned(),
        ablation,
    };
    let ordered = [
        cell(100, "door", Ablation::Head),
        cell(100, "door", Ablation::Fast),
        cell(100, "slide", Ablation::Unstructured),
        cell(101, "door", Ablation::Head),
    ];
    assert!(ordered.is_sorted());
    assert_eq!(ordered[1].to_string(), "door fast seed 100");
}

#[test]
fn settings_are_told_apart_by_their_digests() {
    let digests: BTreeSet<String> = Ablation::ALL
        .into_iter()
        .map(|ablation| setting_digest(&CipSetting::of(ablation)))
        .collect();
    assert_eq!(digests.len(), Ablation::ALL.len());
    assert!(digests.iter().all(|digest| digest.len() == 16));
}

#[test]
fn a_result_is_the_same_when_it_is_read_again() {
    for written in [
        result("door", Ablation::HardGuard, 100, [0.1, 0.3, 0.3, 0.3]),
        crashed("door", Ablation::Cip, 3),
    ] {
        let line = serde_json::to_string(&written).unwrap();
        assert!(line.len() < 4_000, "{}", line.len());
        assert_eq!(serde_json::from_str::<CellResult>(&line).unwrap(), written);
    }
}
