//! Skills that look for a way first, and then go it: whether there is one is I, going it is π.

use factotum_control::{Robot, RobotState};
use factotum_geometry::Pose;
use factotum_motion::{
    IkOptions, IkOutcome, PlanningScene, ToolLineOptions, plan_tool_line, solve_ik,
};
use rand_chacha::ChaCha8Rng;

use crate::arm::{Stop, in_words};
use crate::{Initiation, Outcome, Situation, Skill, SkillError};

/// A skill in two steps. Each such skill is a [`Skill`].
pub(crate) trait WaySkill {
    /// A way to do it.
    type Way;

    /// Name for people and reports.
    fn name(&self) -> &str;

    /// Looks for a way from the posture `from` (lift and arm); moves nothing.
    fn find_way(
        &self,
        situation: &Situation,
        from: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<Self::Way, Stop>;

    /// Goes the way.
    fn go(
        &self,
        way: Self::Way,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, Stop>;
}

impl<S: WaySkill> Skill for S {
    fn name(&self) -> &str {
        WaySkill::name(self)
    }

    fn initiation(
        &self,
        situation: &Situation,
        state: &RobotState,
        rng: &mut ChaCha8Rng,
    ) -> Result<Initiation, SkillError> {
        match self.find_way(situation, &situation.posture(state), rng) {
            Ok(_) => Ok(Initiation::Possible),
            Err(Stop::Failed(failure)) => Ok(Initiation::Impossible(failure)),
            Err(Stop::Error(error)) => Err(error),
        }
    }

    fn run(
        &self,
        robot: &mut dyn Robot,
        situation: &Situation,
        rng: &mut ChaCha8Rng,
    ) -> Result<Outcome, SkillError> {
        let from = situation.posture(&robot.state()?);
        let gone = self
            .find_way(situation, &from, rng)
            .and_then(|way| self.go(way, robot, situation, rng));
        match gone {
            Ok(outcome) => Ok(outcome),
            Err(Stop::Failed(failure)) => Ok(Outcome::Failed(failure)),
            Err(Stop::Error(error)) => Err(error),
        }
    }
}

impl Situation {
    /// Lift and arm positions in a state.
    fn posture(&self, state: &RobotState) -> Vec<f64> {
        self.robot.q_from_state(state.lift_m, &state.arm_positions)
    }

    /// The scene in which the object must not be touched, and the one in which the tool may touch it, with the gripper
    /// open by a fraction.
    pub(crate) fn scenes(
        &self,
        gripper_opening: f64,
    ) -> Result<(PlanningScene, PlanningScene), SkillError> {
        let mut obstacles = self.obstacles.clone();
        obstacles.push(self.object.as_obstacle());
        let mut free = PlanningScene::new(&self.robot, &obstacles, None)?;
        free.set_gripper(gripper_opening);
        let mut near = PlanningScene::new(&self.robot, &obstacles, None)?;
        near.set_gripper(gripper_opening);
        near.allow_contact(&self.object.name);
        Ok((free, near))
    }
}

/// A way for the tool, by the posture that it starts from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ToolWay {
    /// Posture at the first pose, free of collisions.
    pub(crate) start: Vec<f64>,
    /// Manipulability at the start (Eq. 3.2), the larger the better.
    pub(crate) manipulability: f64,
}

/// Looks for a posture at the first pose from which the tool can follow all the others.
///
/// `free` is the scene for the posture at the first pose, `near` the one for the way on, in which contacts may be
/// allowed. The error says how near the best try came.
pub(crate) fn find_tool_way(
    free: &mut PlanningScene,
    near: &mut PlanningScene,
    poses: &[Pose],
    seeds: &[Vec<f64>],
    rng: &mut ChaCha8Rng,
) -> Result<ToolWay, String> {
    let Some((first, rest)) = poses.split_first() else {
        return Err("no poses".to_owned());
    };
    let options = IkOptions {
        avoid_collision: true,
        ..IkOptions::default()
    };
    match solve_ik(free, first, seeds, &options, rng) {
        IkOutcome::Failed(failure) => Err(match failure.collision {
            Some((a, b)) => format!("`{a}` would touch `{b}`"),
            None => format!(
                "the nearest posture is {:.2} m off",
                failure.best_position_error_m
            ),
        }),
        IkOutcome::Solved(solution) => {
            plan_tool_line(near, &solution.q, rest, &ToolLineOptions::default())
                .map_err(|failure| in_words(&failure))?;
            Ok(ToolWay {
                start: solution.q,
                manipulability: solution.manipulability,
            })
        }
    }
}
