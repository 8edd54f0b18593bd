//! Backing out of contact: where a plan begins when the chain already touches something.
//!
//! What a robot believes of its surroundings is some millimetres or centimetres off, so an arm that has just worked among
//! them may be believed, rightly or not, to touch them. A planner refuses such a start. Rather than to look away from what
//! is touched, the chain moves the way that leaves the contact: step by step, each the best of some random ones, and never
//! deeper into anything.

use rand::Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::joint_space::JointSpace;
use crate::scene::PlanningScene;

/// Length of a step, in the joint metric (rad).
const STEP_RAD: f64 = 0.03;
/// Cap: steps. Together they are a short way: who is deeper in has not just touched something.
const N_STEPS_MAX: usize = 40;
/// Directions tried for a step.
const N_DIRECTIONS: usize = 48;
/// Out is where this much is free beyond the scene's margin, metres: the arm does not end exactly where it was sent.
const OUT_M: f64 = 0.003;

/// A short path from `q_start` out of contact along which the clearance only grows; the start alone if it is clear
/// already, and nothing where no such path was found.
pub fn back_out(
    scene: &mut PlanningScene,
    q_start: &[f64],
    rng: &mut impl Rng,
) -> Option<Vec<Vec<f64>>> {
    let robot = scene.robot().clone();
    let space = robot.space();
    let mut clearance_m = scene.clearance_m(q_start);
    let mut path = vec![q_start.to_vec()];
    let mut last_step: Option<Vec<f64>> = None;
    while clearance_m < OUT_M {
        if path.len() > N_STEPS_MAX {
            return None;
        }
        let q = &path[path.len() - 1];
        let mut best: Option<(f64, Vec<f64>)> = None;
        // The way that helped last is tried first.
        for i in 0..N_DIRECTIONS {
            let step = match last_step.take_if(|_| i == 0) {
                Some(step) => step,
                None => random_step(space, rng),
            };
            let next: Vec<f64> = q.iter().zip(&step).map(|(q, dq)| q + dq).collect();
            if !space.is_within_limits(&next) {
                continue;
            }
            let gained_m = scene.clearance_m(&next);
            if gained_m > best.as_ref().map_or(clearance_m, |(most, _)| *most) {
                best = Some((gained_m, step));
            }
        }
        let (gained_m, step) = best?;
        path.push(q.iter().zip(&step).map(|(q, dq)| q + dq).collect());
        clearance_m = gained_m;
        last_step = Some(step);
    }
    // (a clearance that is not a number is no clearance)
    (clearance_m >= OUT_M).then_some(path)
}

/// A step of [`STEP_RAD`] in a uniformly random direction.
fn random_step(space: &JointSpace, rng: &mut impl Rng) -> Vec<f64> {
    let mut step: Vec<f64> = (0..space.n()).map(|_| StandardNormal.sample(rng)).collect();
    let length = space.distance(&vec![0.0; space.n()], &step);
    for dq in &mut step {
        *dq *= STEP_RAD / length;
    }
    step
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::scene::{Obstacle, ObstacleShape};
    use crate::test_robots::load;
    use crate::{PathOutcome, PlanLimits, RobotModel, plan_joints};

    /// A box whose near face is `depth_m` behind the tool's origin, seen from the robot.
    fn among_boxes(robot: &RobotModel, depth_m: f64) -> PlanningScene {
        let tool = robot.chain().base_from_tcp(&robot.q_ready()).translation;
        let obstacle = Obstacle {
            name: "shelf".to_owned(),
            shape: ObstacleShape::Box {
                half_extents_m: [0.1, 0.3, 0.3],
            },
            base_from_obstacle: Isometry3::translation(tool.x + 0.1 - depth_m, tool.y, tool.z),
        };
        PlanningScene::new(robot, &[obstacle], None).unwrap()
    }

    #[test]
    fn an_arm_in_contact_backs_out_and_can_plan_again() {
        let robot = load("movo");
        for (seed, depth_m) in [(0, 0.005), (1, 0.02), (2, 0.04)] {
            let mut scene = among_boxes(&robot, depth_m);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            assert!(!scene.is_free(&robot.q_ready()));
            let path = back_out(&mut scene, &robot.q_ready(), &mut rng).unwrap();
            let clearances: Vec<f64> = path.iter().map(|q| scene.clearance_m(q)).collect();
            assert!(
                clearances.is_sorted_by(|a, b| a < b),
                "never deeper: {clearances:?}"
            );
            let plan = plan_joints(
                &mut scene,
                &path[path.len() - 1],
                &[robot.q_rest()],
                &PlanLimits::default(),
                &mut rng,
            );
            assert!(matches!(plan, PathOutcome::Solved(_)), "{plan:?}");
        }
    }

    #[test]
    fn a_clear_arm_stays_where_it_is() {
        let robot = load("movo");
        let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let path = back_out(&mut scene, &robot.q_ready(), &mut rng);
        assert_eq!(path, Some(vec![robot.q_ready()]));
    }

    #[test]
    fn what_is_walled_in_or_no_number_gets_no_path() {
        let robot = load("movo");
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let tool = robot.chain().base_from_tcp(&robot.q_ready()).translation;
        let block = Obstacle {
            name: "block".to_owned(),
            shape: ObstacleShape::Box {
                half_extents_m: [2.0; 3],
            },
            base_from_obstacle: Isometry3::translation(tool.x, tool.y, tool.z),
        };
        let mut scene = PlanningScene::new(&robot, &[block], None).unwrap();
        assert_eq!(back_out(&mut scene, &robot.q_ready(), &mut rng), None);
        let not_a_number = vec![f64::NAN; robot.n()];
        assert_eq!(back_out(&mut scene, &not_a_number, &mut rng), None);
    }
}
