//! Runs of the grid, with a shell script in place of the program.

use std::sync::atomic::{AtomicBool, Ordering as Atomic};
use std::time::Duration;

use super::*;
use crate::skill_folder::SkillRecord;
use crate::sweep::RESULTS_NAME;

/// Stands in for `factotum`: `skill train` leaves metrics of two episodes and a checkpoint, `skill eval` judges; each
/// call is noted in `calls` beside the cells. `$train` is run first by `skill train`, `$eval` by `skill eval`.
const STAND_IN: &str = r#"
echo "$*" >> CALLS
case "$2" in
train)
    shift 2; for word in "$@"; do case "$last" in --out|--resume) dir=$word;; esac; last=$word; done
    TRAIN
    echo '{"episode":1,"env_steps":7,"success":false,"violation":true,"steps":7,"peak_force_n":90.5,"grasp":2,"failure":null}
{"episode":2,"env_steps":12,"success":true,"violation":false,"steps":5,"peak_force_n":40.0,"grasp":2,"failure":null}
{"episode":2,"env_steps":12,"rollouts":10,"success_rate":0.5,"violation_rate":0.1,"peak_force_n":40.0,"time_to_success_secs":0.4}' > "$dir/metrics.jsonl"
    echo state > "$dir/checkpoint.safetensors"
    echo '{}' ;;
eval)
    EVAL
    rate=0.25; [ "$5" = best ] && rate=0.75
    echo "{\"success_rate\":$rate,\"violation_rate\":0.0,\"peak_force_n\":33.0,\"time_to_success_secs\":null,\"rollouts\":4}" ;;
esac
"#;

/// A grid of `door` and `slide`, `mv` and `cip`, seeds 100 and 101, whose stand-in runs `train` and `eval` on its way.
fn grid(dir: &Path, train: &str, eval: &str) -> Grid {
    let script = STAND_IN
        .replace("CALLS", &format!("'{}'", dir.join("calls").display()))
        .replace("TRAIN", train)
        .replace("EVAL", eval);
    Grid {
        program: PathBuf::from("sh"),
        leading: ["-c", &script, "factotum"].map(str::to_owned).to_vec(),
        tasks: vec!["door".to_owned(), "slide".to_owned()],
        ablations: vec![Ablation::Mv, Ablation::Cip],
        seeds: vec![100, 101],
        episodes: 2,
        rollouts: 4,
        n_workers: 2,
        keep_checkpoints: false,
        folder: dir.join("grid"),
    }
}

/// The same of one cell, `door` `cip` 100, by one worker.
fn one_cell(dir: &Path, train: &str, eval: &str) -> Grid {
    Grid {
        tasks: vec!["door".to_owned()],
        ablations: vec![Ablation::Cip],
        seeds: vec![100],
        n_workers: 1,
        ..grid(dir, train, eval)
    }
}

fn run(grid: &Grid) -> Vec<CellResult> {
    grid.run(&StopWish::default(), |_, _| {}).unwrap()
}

fn calls(dir: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(dir.join("calls")).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

fn cell_dir(grid: &Grid) -> PathBuf {
    grid.folder.join("cells/door-cip-100")
}

#[test]
fn each_cell_is_trained_and_its_last_and_best_policy_judged() {
    let dir = tempfile::tempdir().unwrap();
    let grid = one_cell(dir.path(), "", "");
    let [result] = &run(&grid)[..] else {
        panic!("one cell has one result")
    };
    let folder = cell_dir(&grid).display().to_string();
    assert_eq!(
        calls(dir.path()),
        [
            format!(
                "skill train door --ablation cip --seed 100 --out {folder} --episodes 2 --json"
            ),
            format!("skill eval {folder} --policy last --rollouts 4 --seed 100 --json"),
            format!("skill eval {folder} --policy best --rollouts 4 --seed 100 --json"),
        ]
    );
    assert_eq!(result.cell().to_string(), "door cip seed 100");
    assert_eq!((result.n_episodes, result.n_env_steps), (2, 12));
    assert_eq!(result.training_violations, [1]);
    assert!((result.training_peak_force_n - 90.5).abs() < 1e-12);
    assert_eq!(
        (result.evaluations.len(), result.evaluations[0].episode),
        (1, 2)
    );
    let rates = [result.last, result.best].map(|judged| judged.map(|judged| judged.success_rate));
    assert_eq!(rates, [Some(0.25), Some(0.75)]);
    assert_eq!(result.failure, None);
}

#[test]
fn all_cells_are_run_once_and_checkpoints_go_when_they_are_done() {
    let dir = tempfile::tempdir().unwrap();
    let grid = grid(dir.path(), "", "");
    assert_eq!(grid.n_cells(), 8);
    let mut heard = Vec::new();
    let results = grid
        .run(&StopWish::default(), |_, progress| {
            heard.push(progress.n_done)
        })
        .unwrap();
    assert!(results.is_sorted_by_key(CellResult::cell));
    assert_eq!(heard, (1..=8).collect::<Vec<_>>());
    assert_eq!(calls(dir.path()).len(), 8 * 3);
    assert_eq!(run(&grid), results);
    assert_eq!(calls(dir.path()).len(), 8 * 3, "nothing ran again");
    let checkpoint = cell_dir(&grid).join("checkpoint.safetensors");
    assert!(!checkpoint.exists() && cell_dir(&grid).join("metrics.jsonl").exists());
    // More seeds go into the same folder.
    let more = Grid {
        seeds: vec![100, 101, 102],
        keep_checkpoints: true,
        ..grid
    };
    assert_eq!(run(&more).len(), 12);
    assert_eq!(calls(dir.path()).len(), 12 * 3);
    assert!(
        more.folder
            .join("cells/door-cip-102/checkpoint.safetensors")
            .exists()
    );
}

#[test]
fn a_cell_that_was_interrupted_goes_on_another_time() {
    let dir = tempfile::tempdir().unwrap();
    // Training ends by its own word for being interrupted, and the folder is begun.
    let interrupted = one_cell(dir.path(), "exit 1", "");
    assert_eq!(run(&interrupted), []);
    assert!(!interrupted.folder.join(RESULTS_NAME).exists());
    let record = SkillRecord::new("door".into(), Ablation::Cip, 100);
    SkillFolder::at(&cell_dir(&interrupted))
        .begin(&record)
        .unwrap();
    // Then somebody kills it.
    assert_eq!(run(&one_cell(dir.path(), "kill -9 $$", "")), []);
    assert_eq!(run(&one_cell(dir.path(), "", "")).len(), 1);
    let trained: Vec<String> = calls(dir.path())
        .into_iter()
        .filter(|call| call.starts_with("skill train"))
        .collect();
    assert!(
        trained[0].starts_with("skill train door --ablation cip"),
        "{trained:?}"
    );
    let resumed = format!(
        "skill train --resume {} --episodes 2 --json",
        cell_dir(&interrupted).display()
    );
    assert_eq!(trained[1..], [resumed.clone(), resumed]);
}

#[test]
fn an_urgent_stop_leaves_the_cell_to_go_on() {
    let dir = tempfile::tempdir().unwrap();
    let begun = AtomicBool::new(false);
    let endless = one_cell(dir.path(), "exec sleep 600", "");
    let stop = StopWish::default();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while calls(dir.path()).is_empty() {
                std::thread::sleep(Duration::from_millis(5));
            }
            begun.store(true, Atomic::Relaxed);
            stop.raise();
            stop.raise();
        });
        assert_eq!(endless.run(&stop, |_, _| {}).unwrap(), []);
    });
    assert!(begun.load(Atomic::Relaxed));
    assert_eq!(run(&one_cell(dir.path(), "", "")).len(), 1);
}

#[test]
fn a_cell_that_crashed_is_kept_as_a_failure() {
    let dir = tempfile::tempdir().unwrap();
    let check = |name: &str, train: &str, eval: &str, wanted: (&str, Option<i32>, &str)| {
        let grid = one_cell(&dir.path().join(name), train, eval);
        std::fs::create_dir_all(dir.path().join(name)).unwrap();
        let [result] = &run(&grid)[..] else {
            panic!("one cell has one result")
        };
        let failure = result.failure.as_ref().unwrap();
        assert_eq!((&*failure.command, failure.exit_code), (wanted.0, wanted.1));
        assert!(failure.messages.contains(wanted.2), "{failure:?}");
        assert_eq!(result.best, None);
        result.clone()
    };
    let early = "echo not a number >&2; exit 3";
    let early = check("early", early, "", ("skill train", Some(3), "not a number"));
    assert_eq!((early.n_episodes, early.last), (0, None));
    let late = check("late", "", "kill -11 $$", ("skill eval", None, ""));
    assert_eq!(late.n_episodes, 2, "what it had learned is kept");
    check(
        "silent",
        "",
        "exit 0",
        ("skill eval", Some(0), "no judgement"),
    );
}

#[test]
fn what_does_not_belong_to_the_grid_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let grid = one_cell(dir.path(), "", "");
    let refused = |grid: &Grid, wanted: &[&str]| {
        let error = grid.run(&StopWish::default(), |_, _| {}).unwrap_err();
        let message = error.to_string();
        assert!(
            wanted.iter().all(|words| message.contains(words)),
            "{message}"
        );
        assert!(error.is_of_input(), "{error:?}");
    };
    // A cell begun with other numbers.
    let mut record = SkillRecord::new("door".into(), Ablation::Cip, 100);
    record.setting.evaluate_every += 1;
    SkillFolder::at(&cell_dir(&grid)).begin(&record).unwrap();
    refused(
        &grid,
        &["door cip seed 100", "other numbers than `cip` has now"],
    );
    std::fs::remove_dir_all(cell_dir(&grid)).unwrap();
    let results = run(&grid);
    // One that is done and was learned with other numbers.
    let file = grid.folder.join(RESULTS_NAME);
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace(&results[0].setting, "0123456789abcdef")).unwrap();
    refused(
        &grid,
        &["door cip seed 100", "other numbers than `cip` has now"],
    );
    std::fs::write(&file, "{\"task\": \"door\"}\n").unwrap();
    refused(&grid, &["results.jsonl", "line 1"]);
    std::fs::write(&file, &text).unwrap();
    let longer = Grid {
        episodes: 3,
        ..grid.clone()
    };
    refused(&longer, &["there `--episodes 2`, here `--episodes 3`"]);
    // Metrics of something else.
    let odd = one_cell(&dir.path().join("odd"), "", "echo odd > CELL");
    let cell = cell_dir(&odd).join("metrics.jsonl");
    std::fs::create_dir_all(dir.path().join("odd")).unwrap();
    let odd = one_cell(
        &dir.path().join("odd"),
        "",
        &format!("echo odd > '{}'", cell.display()),
    );
    refused(
        &odd,
        &[
            "metrics.jsonl",
            "line 1",
            "neither an episode nor an evaluation",
        ],
    );
}

#[test]
fn two_at_work_on_one_cell_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let grid = one_cell(dir.path(), "", "");
    std::fs::create_dir_all(cell_dir(&grid)).unwrap();
    let lock = std::fs::File::create(cell_dir(&grid).join(".lock")).unwrap();
    lock.lock().unwrap();
    let error = grid.run(&StopWish::default(), |_, _| {}).unwrap_err();
    assert!(matches!(error, GridError::InUse { .. }), "{error:?}");
    drop(lock);
    assert_eq!(run(&grid).len(), 1);
}
