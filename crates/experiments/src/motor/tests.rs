use std::path::Path;
use std::sync::atomic::AtomicBool;

use factotum_descriptions::{MotorPolicy, TaskSpec};

use factotum_worlds::TaskRig;

use super::*;

fn task(name: &str) -> TaskSpec {
    let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/tasks");
    TaskSpec::load(&tasks.join(format!("{name}.toml"))).unwrap()
}

fn record(init: Init) -> MotorRecord {
    MotorRecord {
        rollouts: 2,
        ..MotorRecord::new("drawer-heavy".into(), init, MotorPolicy::Dmp, 5)
    }
}

/// Learns for so many epochs in a folder.
fn learn(dir: &Path, init: Init, n_epochs: u64, resume: bool) -> MotorSummary {
    let (task, record) = (task("drawer-heavy"), record(init));
    let training = MotorTraining {
        folder: &MotorFolder::at(dir),
        task: &task,
        record: &record,
        recorded: &[],
        n_epochs,
        resume,
    };
    let never = AtomicBool::new(false);
    training.run(&never, &mut |_| {}, &mut |_| {}).unwrap()
}

#[test]
fn a_plan_moves_the_drawer_but_not_all_the_way_and_a_stopped_search_goes_on_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| dir.path().join(name));
    let summary = learn(&whole, Init::Plan, 2, false);
    assert!(summary.complete);
    assert!(
        (0.1..0.285).contains(&summary.first.object_state),
        "{:?}",
        summary.first
    );
    assert!(!summary.first.success);

    learn(&parts, Init::Plan, 1, false);
    // An epoch whose search was not stored any more is made again.
    let metrics = MotorFolder::at(&parts).metrics();
    let text = std::fs::read_to_string(&metrics).unwrap();
    let last = text
        .lines()
        .last()
        .unwrap()
        .replace("\"epoch\":1", "\"epoch\":2");
    std::fs::write(&metrics, format!("{text}{last}\n{{\"epo")).unwrap();
    let gone_on = learn(&parts, Init::Plan, 2, true);
    assert_eq!(gone_on, summary);
    for file in ["metrics.jsonl", "search.json"] {
        let read = |dir: &Path| std::fs::read_to_string(dir.join(file)).unwrap();
        assert_eq!(read(&whole), read(&parts), "{file}");
    }

    // It is rolled out again as it was, and no other run is written over it.
    let (task, record) = (task("drawer-heavy"), record(Init::Plan));
    let training = MotorTraining {
        folder: &MotorFolder::at(&whole),
        task: &task,
        record: &record,
        recorded: &[],
        n_epochs: 2,
        resume: false,
    };
    let rollout = training.judge(&mut |_| {}).unwrap();
    assert!((rollout.total_reward - summary.last.total_reward).abs() < 1e-12);
    let never = AtomicBool::new(false);
    let taken = training.run(&never, &mut |_| {}, &mut |_| {}).unwrap_err();
    assert!(
        taken.is_of_input() && taken.to_string().contains("drawer-heavy"),
        "{taken}"
    );
}

#[test]
fn random_weights_move_the_arm_and_a_contact_task_is_refused() {
    let mut rig = MotorRig::new(&task("drawer-heavy")).unwrap();
    let (mut search, demo) = search::begin(&mut rig, &record(Init::Random), &[]).unwrap();
    assert!(demo.is_none());
    let mut moved: f64 = 0.0;
    let start = task("drawer-heavy").motor.unwrap().q_start;
    assert!(start.is_empty(), "it begins in the ready posture");
    let mut first = None;
    let mut watch = |rig: &TaskRig| {
        use factotum_skills::cip::rig::Rig as _;
        let q = rig.reading().arm_positions.clone();
        let first: &Vec<f64> = first.get_or_insert_with(|| q.clone());
        for (a, b) in first.iter().zip(&q) {
            moved = moved.max((a - b).abs());
        }
    };
    search.roll_out(&mut rig, &mut watch).unwrap();
    assert!(moved > 0.2, "{moved} rad");
    let refused = MotorRig::new(&task("door")).unwrap_err();
    assert!(
        refused.is_of_input() && refused.to_string().contains("`door`"),
        "{refused}"
    );
}

#[test]
fn a_search_of_another_policy_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let folder = MotorFolder::at(dir.path());
    learn(dir.path(), Init::Random, 0, false);
    let Some(SearchState::Primitive(mut state)) = folder.search().unwrap() else {
        panic!("a primitive is searched by PI²-CMA");
    };
    state.mean.truncate(8);
    state.first_std.truncate(8);
    state.block_sizes = vec![8];
    state.covariances = vec![vec![1.0; 36]];
    folder.write_search(&SearchState::Primitive(state)).unwrap();
    let (task, record) = (task("drawer-heavy"), record(Init::Random));
    let training = MotorTraining {
        folder: &folder,
        task: &task,
        record: &record,
        recorded: &[],
        n_epochs: 1,
        resume: true,
    };
    let refused = training.judge(&mut |_| {}).unwrap_err();
    assert!(
        refused.is_of_input() && refused.to_string().contains("search.json"),
        "{refused}"
    );
}

#[test]
fn a_network_is_cloned_from_the_plan_and_goes_on_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let task = task("microwave");
    let record = MotorRecord {
        rollouts: 2,
        ..MotorRecord::new("microwave".into(), Init::Plan, MotorPolicy::Mlp, 2)
    };
    assert_eq!(record.search, SearchName::Dapg);
    let learn = |name: &str, n_epochs, resume| {
        let training = MotorTraining {
            folder: &MotorFolder::at(&dir.path().join(name)),
            task: &task,
            record: &record,
            recorded: &[],
            n_epochs,
            resume,
        };
        let never = AtomicBool::new(false);
        training.run(&never, &mut |_| {}, &mut |_| {}).unwrap()
    };
    let summary = learn("whole", 2, false);
    // It begins by pushing the door some of its way.
    assert!(
        (0.07..1.2).contains(&summary.first.object_state),
        "{:?}",
        summary.first
    );
    assert_eq!(summary.last.rollouts, 4);
    learn("parts", 1, false);
    assert_eq!(learn("parts", 2, true), summary);
    let search = |name| MotorFolder::at(&dir.path().join(name)).search().unwrap();
    assert_eq!(search("whole"), search("parts"));
}

#[test]
fn what_does_not_go_together_is_refused() {
    let mut rig = MotorRig::new(&task("drawer-heavy")).unwrap();
    for (policy, init, search, wanted) in [
        (MotorPolicy::Dmp, Init::Random, SearchName::Npg, "`dmp`"),
        (MotorPolicy::Mlp, Init::Random, SearchName::Pi2cma, "`mlp`"),
        (
            MotorPolicy::Mlp,
            Init::Random,
            SearchName::Dapg,
            "demonstrations",
        ),
    ] {
        let record = MotorRecord {
            search,
            ..MotorRecord::new("drawer-heavy".into(), init, policy, 5)
        };
        let Err(refused) = search::begin(&mut rig, &record, &[]) else {
            panic!("{policy:?} went with {search:?}");
        };
        assert!(
            refused.is_of_input() && refused.to_string().contains(wanted),
            "{refused}"
        );
    }
}

#[test]
fn a_recorded_motion_is_what_a_policy_begins_with() {
    let mut rig = MotorRig::new(&task("drawer-heavy")).unwrap();
    // The arm turns about its base for a second and stays.
    let mut n = 0;
    let motion = rig.record("a test", &mut |_, action| {
        n += 1;
        action[0] = if n <= 20 { 0.4 } else { 0.0 };
        n <= 40
    });
    let motion = motion.unwrap();
    let dir = tempfile::tempdir().unwrap();
    let folder = MotorFolder::at(dir.path());
    let (task, record) = (task("drawer-heavy"), record(Init::Demo));
    let training = MotorTraining {
        folder: &folder,
        task: &task,
        record: &record,
        recorded: std::slice::from_ref(&motion),
        n_epochs: 0,
        resume: false,
    };
    let never = AtomicBool::new(false);
    training.run(&never, &mut |_| {}, &mut |_| {}).unwrap();
    let kept = folder.demonstrations().unwrap();
    assert_eq!(kept, std::slice::from_ref(&motion));
    let mut turned = 0.0;
    let mut watch = |rig: &TaskRig| {
        use factotum_skills::cip::rig::Rig as _;
        turned = rig.reading().arm_positions[0] - motion.samples()[0].positions[0];
    };
    training.judge(&mut watch).unwrap();
    assert!((turned - 0.4).abs() < 0.03, "{turned}");
}
