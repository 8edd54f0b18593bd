//! The judge says no unless physics says yes.

use factotum_control::Robot as _;
use factotum_worlds::{SimRobot, WorldConfig};

use crate::fixture::{config, household};

#[test]
fn nothing_is_achieved_at_the_start_nor_by_an_idle_robot() {
    for seed in [0, 1, 2] {
        let mut robot = household(seed);
        for _ in 0..2 {
            for chore in ["throw-away-bottle", "turn-light-off", "close-faucet"] {
                let verdict = robot.judge().achieved(chore).unwrap();
                assert!(
                    !verdict.achieved,
                    "seed {seed}, {chore}: {}",
                    verdict.measured
                );
            }
            robot.wait(1.0).unwrap();
        }
    }
}

#[test]
fn a_home_without_its_bin_never_has_the_bottle_in_it() {
    let scene = config(1).scene.without_class("bin");
    let robot = SimRobot::new(WorldConfig { scene, ..config(1) }).unwrap();
    let verdict = robot.judge().achieved("throw-away-bottle").unwrap();
    assert!(!verdict.achieved);
    assert_eq!(verdict.measured, "this home has no `bin_1`");
}

#[test]
fn an_unknown_chore_is_an_error() {
    let error = household(1).judge().achieved("make-tea").unwrap_err();
    assert_eq!(
        error.to_string(),
        "chore `make-tea` is not in scene `household`; available: `throw-away-bottle`, `turn-light-off`, `close-faucet`, \
         `open-door`, `open-drawer`"
    );
}
