//! An action whose way was shown once instead of planned from the joint.

use factotum_descriptions::{Demonstration, Placement};

use crate::known_home::{do_chore, household, near_the_switch, true_map};

/// The tool's way in Λ as a hand might lead it: along the lever's motion, slow at both ends, and not quite true.
fn shown(class: &factotum_descriptions::ObjectClass, action: &str) -> Demonstration {
    const N_POSES: usize = 40;
    const WOBBLE_M: f64 = 0.003;
    let action = class.action(action).unwrap();
    let joint = class.joint(action.joint.as_deref().unwrap()).unwrap();
    let grasp = class
        .grasps
        .iter()
        .find(|grasp| Some(&grasp.name) == action.grasp.as_ref())
        .unwrap();
    let (from, to) = (action.initiation.unwrap(), action.termination.unwrap());
    let pose = |k: usize| {
        let t = k as f64 / (N_POSES - 1) as f64;
        let share = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
        let position = from + (to - from) * share;
        let mut pose = joint.motion(0.0, position) * grasp.object_from_tcp();
        pose.translation.vector.y += WOBBLE_M * (std::f64::consts::TAU * t).sin();
        Placement::from(pose)
    };
    Demonstration {
        step_secs: 0.1,
        object_from_tcp: (0..N_POSES).map(pose).collect(),
    }
}

#[test]
fn the_light_is_turned_off_as_it_was_shown() {
    let mut sim = household(1, near_the_switch());
    let mut aosm = true_map(&sim);
    let class = aosm.classes.get_mut("light_switch").unwrap();
    let demonstration = shown(class, "turn_off");
    let action = class
        .actions
        .iter_mut()
        .find(|action| action.name == "turn_off")
        .unwrap();
    action.demonstration = Some(demonstration);
    let report = do_chore(
        &mut sim,
        aosm,
        near_the_switch(),
        "light_switch",
        "turn_off",
    );
    assert!(report.is_believed_done, "{report:?}");
    let verdict = sim.judge().achieved("turn-light-off").unwrap();
    assert!(verdict.achieved, "{}", verdict.measured);
}
