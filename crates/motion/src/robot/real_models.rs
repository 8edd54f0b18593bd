//! Other people's models, unchanged, through a `robot.toml`.
//!
//! `cargo x models` fetches them into `.deps/`. FACTOTUM_ROBOSUITE_DIR and FACTOTUM_PYBULLET_DATA_DIR name the folders
//! `robosuite` and `pybullet_data` of wheels that are elsewhere.

use std::path::{Path, PathBuf};

use factotum_descriptions::RobotDescription;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::{
    IkOptions, IkPreference, PathOutcome, PlanLimits, PlanningScene, RobotModel, plan_joints,
    solve_ik,
};

#[expect(clippy::print_stdout, reason = "a skipped test says why")]
fn folder(variable: &str, in_deps: &str) -> Option<PathBuf> {
    let deps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.deps");
    let folder = std::env::var_os(variable).map_or_else(|| deps.join(in_deps), PathBuf::from);
    let found = folder.is_dir().then_some(folder);
    if found.is_none() {
        println!("skipped: `.deps/{in_deps}` is absent (cargo x models) and {variable} is not set");
    }
    found
}

/// A robot of one model, seven joints and a tool frame in a body of it.
fn describe(model: PathBuf, joint_prefix: &str, first: usize, body: &str) -> RobotDescription {
    let joints: Vec<String> = (first..first + 7)
        .map(|i| format!("\"{joint_prefix}{i}\""))
        .collect();
    let sevens = |value: &str| [value; 7].join(", ");
    let text = format!(
        r#"
name = "other"
[[parts]]
name = "arm"
model = "{}"
[arm]
joints = [{}]
tcp_site = "tool"
velocity_max_rad_per_s = [{}]
acceleration_max_rad_per_s2 = [{}]
torque_max_nm = [{}]
rest = [{}]
ready = [{}]
[arm.tcp]
body = "{body}"
xyz = [0.0, 0.0, 0.1]
"#,
        model.display(),
        joints.join(", "),
        sevens("1.5"),
        sevens("5.0"),
        sevens("50.0"),
        sevens("0.0"),
        sevens("0.0"),
    );
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("robot.toml"), text).unwrap();
    RobotDescription::load(dir.path()).unwrap()
}

/// Solves the poses of free configurations and plans between them.
fn solve_and_plan(name: &str, description: &RobotDescription) {
    let robot = RobotModel::load(description).unwrap();
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let options = IkOptions {
        prefer: IkPreference::First,
        ..IkOptions::default()
    };
    let mut q = vec![0.0; robot.n()];
    let mut free = Vec::new();
    while free.len() < 20 {
        robot.space().sample_into(&mut rng, &mut q);
        if scene.is_free(&q) {
            free.push(q.clone());
        }
    }
    let mut solved = Vec::new();
    for q in &free {
        let target = robot.chain().base_from_tcp(q);
        let outcome = solve_ik(&mut scene, &target, &[], &options, &mut rng);
        solved.extend(outcome.q().map(<[f64]>::to_vec));
    }
    assert!(
        solved.len() >= 19,
        "{name}: {} of 20 poses solved",
        solved.len()
    );
    for pair in solved[..5].windows(2) {
        let limits = PlanLimits::default();
        let outcome = plan_joints(&mut scene, &pair[0], &pair[1..], &limits, &mut rng);
        assert!(
            matches!(outcome, PathOutcome::Solved(_)),
            "{name}: {outcome:?}"
        );
    }
}

#[test]
fn robosuite_arms_are_solved_and_planned_for() {
    let Some(robosuite) = folder("FACTOTUM_ROBOSUITE_DIR", "robosuite/robosuite") else {
        return;
    };
    for (name, prefix) in [
        ("panda", "joint"),
        ("iiwa", "joint_"),
        ("jaco", "j2s7s300_joint_"),
    ] {
        let model = robosuite
            .join("models/assets/robots")
            .join(name)
            .join("robot.xml");
        solve_and_plan(name, &describe(model, prefix, 1, "right_hand"));
    }
}

#[test]
fn the_pybullet_iiwa_is_solved_and_planned_for() {
    let Some(pybullet) = folder("FACTOTUM_PYBULLET_DATA_DIR", "pybullet/pybullet_data") else {
        return;
    };
    let model = pybullet.join("kuka_iiwa/model.urdf");
    solve_and_plan(
        "kuka_iiwa",
        &describe(model, "lbr_iiwa_joint_", 1, "lbr_iiwa_link_7"),
    );
}
