use std::path::Path;
use std::thread;

use super::super::RESULTS_NAME;
use super::super::folder::COMMAND_NAME;
use super::*;

/// A sweep over a shell script that finds its seed in `$seed`.
fn sweep(folder: &Path, script: &str, seeds: std::ops::Range<u64>, n_workers: usize) -> SeedSweep {
    // The arguments after the script are `sh --seed SEED`, of which the shell takes the first for its own name.
    let arguments = ["-c", &format!("seed=$2; {script}"), "sh"];
    SeedSweep {
        program: PathBuf::from("sh"),
        arguments: arguments.map(str::to_owned).to_vec(),
        seeds: seeds.collect(),
        n_workers,
        folder: folder.to_path_buf(),
    }
}

const ODD_SEEDS_FAIL: &str = r#"echo "{\"achieved\": $([ $((seed % 2)) = 0 ] && echo true || echo false)}"; exit $((seed % 2))"#;

fn run(sweep: &SeedSweep) -> Vec<RunResult> {
    sweep.run(&StopWish::default(), |_, _| {}).unwrap()
}

#[test]
fn successes_and_failures_are_counted() {
    let dir = tempfile::tempdir().unwrap();
    let results = run(&sweep(dir.path(), ODD_SEEDS_FAIL, 0..6, 2));
    assert_eq!(
        results.iter().map(|result| result.seed).collect::<Vec<_>>(),
        [0, 1, 2, 3, 4, 5]
    );
    assert_eq!(
        results[2].output,
        Some(serde_json::json!({"achieved": true}))
    );
    let summary = summarize(&results).unwrap();
    assert_eq!((summary.n_runs, summary.n_successes), (6, 3));
    assert_eq!(summary.seeds_failed, [1, 3, 5]);
    assert!(summary.seeds_unanswered.is_empty());
}

#[test]
fn the_number_of_workers_changes_nothing_but_the_time() {
    let dir = tempfile::tempdir().unwrap();
    let timeless = |results: Vec<RunResult>| -> Vec<RunResult> {
        results
            .into_iter()
            .map(|result| RunResult {
                wall_secs: 0.0,
                ..result
            })
            .collect()
    };
    let alone = run(&sweep(&dir.path().join("one"), ODD_SEEDS_FAIL, 0..8, 1));
    let together = run(&sweep(&dir.path().join("four"), ODD_SEEDS_FAIL, 0..8, 4));
    assert_eq!(timeless(alone), timeless(together));
}

#[test]
fn a_crash_counts_as_a_failure_and_its_messages_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let results = run(&sweep(dir.path(), "echo why >&2; kill -9 $$", 0..1, 1));
    assert_eq!(results[0].exit_code, None);
    assert_eq!(results[0].messages.trim(), "why");
    let summary = summarize(&results).unwrap();
    assert_eq!(
        (summary.n_successes, summary.seeds_unanswered),
        (0, vec![0])
    );
}

#[test]
fn a_sweep_goes_on_where_it_was() {
    let dir = tempfile::tempdir().unwrap();
    let count = "echo x >> count; echo '{}'";
    let in_folder = format!("cd '{}'; {count}", dir.path().display());
    let stop = StopWish::default();
    let first = sweep(dir.path(), &in_folder, 0..5, 1);
    let partial = first
        .run(&stop, |result, _| {
            if result.seed == 1 {
                stop.raise();
            }
        })
        .unwrap();
    assert!(
        (2..5).contains(&partial.len()),
        "stopped after {}",
        partial.len()
    );
    // A crash cuts the last line short.
    let file = dir.path().join(RESULTS_NAME);
    let whole = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("{whole}{{\"seed\":9,")).unwrap();
    assert_eq!(run(&first).len(), 5);
    let n_runs = std::fs::read_to_string(dir.path().join("count"))
        .unwrap()
        .lines()
        .count();
    assert_eq!(n_runs, 5, "no seed ran twice");
}

#[test]
fn progress_counts_earlier_results() {
    let dir = tempfile::tempdir().unwrap();
    run(&sweep(dir.path(), ODD_SEEDS_FAIL, 0..3, 1));
    let mut heard = Vec::new();
    sweep(dir.path(), ODD_SEEDS_FAIL, 1..5, 1)
        .run(&StopWish::default(), |result, progress| {
            heard.push((result.seed, progress.n_done, progress.n_successes));
            assert_eq!(progress.n_runs, 4);
        })
        .unwrap();
    assert_eq!(heard, [(3, 3, 1), (4, 4, 2)]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_at_the_terminal_does_not_reach_the_runs() {
    let dir = tempfile::tempdir().unwrap();
    // The run asks for the group it is in: a terminal interrupts every process of the group in front.
    let results = run(&sweep(dir.path(), "ps -o pgid= -p $$", 0..1, 1));
    let own = std::process::Command::new("ps")
        .args(["-o", "pgid=", "-p", &std::process::id().to_string()])
        .output()
        .unwrap();
    let own: i64 = String::from_utf8(own.stdout)
        .unwrap()
        .trim()
        .parse()
        .unwrap();
    let group = results[0]
        .output
        .as_ref()
        .and_then(serde_json::Value::as_i64);
    assert!(
        group.is_some_and(|group| group != own),
        "{group:?}, ours is {own}"
    );
}

#[test]
fn the_first_stop_lets_runs_end_and_the_second_drops_them() {
    let dir = tempfile::tempdir().unwrap();
    let begun = dir.path().join("begun");
    let script = |body: &str| format!("echo $seed >> '{}'; {body}; echo '{{}}'", begun.display());
    let n_begun = || {
        let text = std::fs::read_to_string(&begun).unwrap_or_default();
        text.lines().count()
    };
    let stopped = |sweep: &SeedSweep, n_raised: usize| {
        let stop = StopWish::default();
        thread::scope(|scope| {
            scope.spawn(|| {
                while n_begun() < 2 {
                    thread::sleep(std::time::Duration::from_millis(5));
                }
                (0..n_raised).for_each(|_| stop.raise());
            });
            sweep.run(&stop, |_, _| {}).unwrap()
        })
    };
    let endless = sweep(
        &dir.path().join("urgent"),
        &script("exec sleep 600"),
        0..4,
        2,
    );
    assert_eq!(stopped(&endless, 2), [], "none came to its own end");
    assert_eq!(n_begun(), 2, "no other was begun");
    assert!(!dir.path().join("urgent").join(RESULTS_NAME).exists());
    std::fs::remove_file(&begun).unwrap();
    let patient = sweep(&dir.path().join("patient"), &script("sleep 0.3"), 0..4, 2);
    let results = stopped(&patient, 1);
    assert_eq!(
        results.len(),
        2,
        "those under way ended, no other was begun"
    );
    assert!(results.iter().all(RunResult::is_success));
}

#[test]
fn a_folder_of_another_command_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let first = sweep(dir.path(), ODD_SEEDS_FAIL, 0..2, 1);
    run(&first);
    let other = SeedSweep {
        arguments: [&first.arguments[..], &["--goal".into(), "other".into()]].concat(),
        ..first.clone()
    };
    let error = other.run(&StopWish::default(), |_, _| {}).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("there ``, here `--goal other`"),
        "{message}"
    );
    assert_eq!(run(&first).len(), 2, "its own command goes on");
    // Results of which nobody can say the command are not taken either.
    std::fs::remove_file(dir.path().join(COMMAND_NAME)).unwrap();
    let error = first.run(&StopWish::default(), |_, _| {}).unwrap_err();
    assert!(matches!(error, SweepError::NoCommand { .. }), "{error:?}");
}

#[test]
fn a_program_that_is_not_there_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let missing = SeedSweep {
        program: PathBuf::from("no-such-program"),
        ..sweep(dir.path(), "", 0..3, 2)
    };
    let error = missing.run(&StopWish::default(), |_, _| {}).unwrap_err();
    assert!(matches!(error, SweepError::Start { .. }), "{error:?}");
}

#[test]
fn foreign_results_are_not_taken_for_ours() {
    let dir = tempfile::tempdir().unwrap();
    let sweep = sweep(dir.path(), "", 0..1, 1);
    run(&sweep);
    std::fs::write(dir.path().join(RESULTS_NAME), "{\"sede\": 1}\n").unwrap();
    let error = sweep.run(&StopWish::default(), |_, _| {}).unwrap_err();
    assert!(
        matches!(error, SweepError::Result { line: 1, .. }),
        "{error:?}"
    );
}

#[test]
fn no_results_have_no_summary() {
    assert_eq!(summarize(&[]), None);
}

#[test]
fn the_median_lies_between_the_middle_two() {
    assert_eq!(median(&[1.0, 2.0, 4.0, 9.0]), Some(3.0));
    assert_eq!(median(&[1.0, 2.0, 4.0]), Some(2.0));
    assert_eq!(median(&[]), None);
}
