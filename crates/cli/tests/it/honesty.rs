//! That a chore is achieved is the judge's word, from physics: nothing that a robot believes or reports makes it so.

use factotum_semantic_map::{Aosm, Location};

use crate::known_home::{do_chore, household, near_the_switch, true_map};
use crate::small_home::SmallHome;

/// The home as it would be if every chore had been done.
fn wishful(mut aosm: Aosm) -> Aosm {
    for (object, joint, position) in [
        ("light_switch_1", "toggle", -0.4),
        ("faucet_1", "handle", 0.0),
    ] {
        let object = aosm.object_mut(object).unwrap();
        object.joints.insert(joint.to_owned(), position);
    }
    aosm.object_mut("bottle_1").unwrap().location = Location::In("bin_1".to_owned());
    aosm
}

/// An executive that believes that all is done has no step to take, reports success, and has achieved nothing.
#[test]
fn an_idle_executive_that_believes_it_is_done_has_achieved_nothing() {
    for seed in [0, 1, 2] {
        let mut sim = household(seed, near_the_switch());
        for (chore, class, action) in [
            ("throw-away-bottle", "bottle", "throw_away"),
            ("turn-light-off", "light_switch", "turn_off"),
            ("close-faucet", "faucet", "close_faucet"),
        ] {
            let aosm = wishful(true_map(&sim));
            let report = do_chore(&mut sim, aosm, near_the_switch(), class, action);
            assert!(report.is_believed_done, "seed {seed}, {chore}: {report:?}");
            assert!(
                report.executed.is_empty(),
                "seed {seed}, {chore}: {report:?}"
            );
            let verdict = sim.judge().achieved(chore).unwrap();
            assert!(
                !verdict.achieved,
                "seed {seed}, {chore}: {}",
                verdict.measured
            );
        }
    }
}

/// A user's own home: the bottle stands there, the bin does not, and the robot looks for it in vain.
#[test]
fn a_home_without_its_bin_is_a_no_with_a_reason() {
    let home = SmallHome::new();
    let said = home.run("throw-away-bottle");
    assert_eq!(said.code, Some(1), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["achieved"], false);
    let reason = document["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("no bin has been found in this home; found: ")
            && reason.contains("`bottle_1`"),
        "{reason}"
    );
    assert_eq!(document["measured"], "this home has no `bin_1`");
}

/// The switch is behind a counter as deep as the arm is long.
#[test]
fn a_goal_out_of_reach_is_a_no_with_a_reason() {
    let home = SmallHome::new();
    let said = home.run("turn-light-off");
    assert_eq!(said.code, Some(1), "{}", said.stderr);
    let document = said.json();
    assert_eq!(document["achieved"], false);
    let reason = document["reason"].as_str().unwrap();
    assert!(
        reason.contains("turn_off") && reason.contains("`light_switch_1`"),
        "{reason}"
    );
}
