//! Learning contact skills on simulated rigs.

use factotum_descriptions::TaskSpec;
use factotum_skills::cip::environment::CipError;
use factotum_skills::cip::perturbation::Perturbation;
use factotum_skills::cip::setting::{Ablation, CipSetting};
use factotum_skills::cip::training::{EpisodeRecord, Trainer, TrainingError};
use factotum_worlds::{RigError, TaskRig};

use crate::fixture::assets;

fn task(name: &str) -> TaskSpec {
    TaskSpec::load(&assets().join(format!("tasks/{name}.toml"))).unwrap()
}

/// A setting that is quick to begin: grasps are held but not shaken.
fn quick(ablation: Ablation) -> CipSetting {
    CipSetting {
        jiggle_steps: 5,
        evaluation_rollouts: 3,
        ..CipSetting::of(ablation)
    }
}

fn trainer(task: &TaskSpec, setting: CipSetting, seed: u64) -> Trainer<TaskRig> {
    let rig = TaskRig::new(task).unwrap();
    Trainer::new(rig, task, setting, seed, &mut |_, _| ()).unwrap()
}

fn lived(trainer: &mut Trainer<TaskRig>, n: usize) -> Vec<EpisodeRecord> {
    (0..n).map(|_| trainer.episode().unwrap()).collect()
}

#[test]
fn the_objects_own_motion_opens_it_within_the_limits() {
    for name in ["door", "lever"] {
        let mut trainer = trainer(&task(name), quick(Ablation::Fast), 3);
        let evaluation = trainer.evaluate().unwrap();
        assert_eq!(evaluation.success_rate, 1.0, "{name}: {evaluation:?}");
        assert_eq!(evaluation.violation_rate, 0.0, "{name}");
        assert!(evaluation.peak_force_n < 150.0, "{name}: {evaluation:?}");
    }
}

#[test]
fn the_same_seed_lives_the_same_and_a_stopped_run_goes_on_as_if_it_never_stopped() {
    let task = task("door");
    let setting = quick(Ablation::Cip);
    let mut whole = trainer(&task, setting.clone(), 5);
    let mut stopped = trainer(&task, setting.clone(), 5);
    let wanted = lived(&mut whole, 4);
    assert_eq!(lived(&mut stopped, 2), wanted[..2]);
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("checkpoint.safetensors");
    stopped.save(&file).unwrap();
    let rig = TaskRig::new(&task).unwrap();
    let mut resumed = Trainer::resume(rig, &task, setting, 5, &file).unwrap();
    // An evaluation changes nothing of what follows.
    resumed.evaluate().unwrap();
    assert_eq!(lived(&mut resumed, 2), wanted[2..]);
    assert_eq!(resumed.policy(), whole.policy());
    let other = lived(&mut trainer(&task, quick(Ablation::Cip), 6), 1);
    assert_ne!(other, wanted[..1]);
}

#[test]
fn a_checkpoint_of_another_task_is_refused_by_name() {
    let door = task("door");
    let setting = quick(Ablation::Unstructured);
    let mut learner = trainer(&door, setting.clone(), 1);
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("checkpoint.safetensors");
    learner.save(&file).unwrap();
    let lever = task("lever");
    let rig = TaskRig::new(&lever).unwrap();
    let error = Trainer::resume(rig, &lever, setting, 1, &file).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("`door`") && text.contains("`lever`"),
        "{text}"
    );
}

fn refusal(spoil: impl Fn(&mut TaskSpec)) -> String {
    let mut task = task("door");
    spoil(&mut task);
    task.file = "door.toml".into();
    TaskRig::new(&task).unwrap_err().to_string()
}

#[test]
fn a_task_that_does_not_fit_its_object_is_refused_by_name() {
    assert_eq!(
        refusal(|task| task.joint = "hing".to_owned()),
        "`door.toml`: `joint` is `hing`, expected a joint of its model: `hinge`"
    );
    let region = refusal(|task| task.grasp_region = vec!["knob".to_owned()]);
    assert!(
        region.starts_with("`door.toml`: `grasp_region` is `knob`, expected geoms of its model: ")
            && region.contains("`handle`"),
        "{region}"
    );
    let goal = refusal(|task| task.goal = 2.0);
    assert!(
        goal.starts_with("`door.toml`: `goal` is 2, expected within the range 0 to"),
        "{goal}"
    );
    let model = refusal(|task| task.model = "no/such.xml".into());
    assert!(model.contains("no/such.xml"), "{model}");
}

#[test]
fn an_object_out_of_reach_is_said_to_be() {
    let mut task = task("door");
    task.placement.x_m = [2.0, 2.1];
    let rig = TaskRig::new(&task).unwrap();
    let error = Trainer::new(rig, &task, quick(Ablation::Cip), 1, &mut |_, _| ()).unwrap_err();
    assert!(
        matches!(&error, TrainingError::<RigError>::NoGrasp { n_points, .. } if *n_points > 0)
            || matches!(&error, TrainingError::Environment(CipError::NoGrasp { .. })),
        "{error}"
    );
    assert!(error.to_string().contains("placement"), "{error}");
}

#[test]
fn a_stiffer_joint_takes_longer_and_a_factor_that_is_none_is_refused() {
    let task = task("door");
    let secs = |damping: f64| {
        let perturbation = Perturbation {
            damping,
            ..Perturbation::default()
        };
        let rig = TaskRig::perturbed(&task, &perturbation).unwrap();
        let setting = quick(Ablation::Fast);
        let mut trainer = Trainer::new(rig, &task, setting, 3, &mut |_, _| ()).unwrap();
        let evaluation = trainer.evaluate().unwrap();
        assert_eq!(evaluation.success_rate, 1.0, "{damping}: {evaluation:?}");
        evaluation.time_to_success_secs.unwrap()
    };
    // The hinge has 0.1 N m s/rad: thirty times that is felt, and fifty times pulls the handle out of the fingers.
    assert!(secs(30.0) > 1.05 * secs(1.0));
    let none = Perturbation {
        friction: -1.0,
        ..Perturbation::default()
    };
    let error = TaskRig::perturbed(&task, &none).unwrap_err().to_string();
    assert!(error.contains("friction factor is -1"), "{error}");
}
