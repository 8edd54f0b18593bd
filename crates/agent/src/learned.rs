//! Learned skills at work: which one does an option, and where the base should stand for it.
//!
//! A learned skill is taken where the object stands before the base as it did in training, with its joint where it began
//! there, and where the skill itself says that it could start. Everywhere else the given skill does the option.

use factotum_descriptions::PlacementRange;
use factotum_geometry::Pose2;
use factotum_geometry::frames::{planar_from_pose, wrap_angle};
use factotum_semantic_map::{OptionKind, OptionSpec};
use factotum_skills::cip::Primitive;
use factotum_skills::{Initiation, Skill};
use factotum_symbols::{BasePoseClassifier, NavigationSymbol};
use rand::{Rng, RngExt as _};

use crate::act::skill_for;
use crate::{AgentError, Executive, LogLevel};

/// How far outside of where it stood in training the object may stand, since a base parks with such errors: metres, radians.
const SLACK: (f64, f64) = (0.04, 0.06);

/// How far the joint may be from where it began in training, as a share of its way to the goal.
const BEGUN: f64 = 0.15;

/// What does an option.
pub(crate) struct Chosen {
    pub(crate) skill: Box<dyn Skill>,
    /// Its name, if it was learned.
    pub(crate) learned: Option<String>,
}

impl Executive<'_> {
    /// Gives it learned skills, for the options that they do.
    pub fn teach(&mut self, skills: Vec<Primitive>) {
        self.learned = skills;
    }

    /// The learned skill that does an option, if there is one and the joint is where it began in training.
    pub(crate) fn learned_for(&self, option: &OptionSpec) -> Result<Option<Primitive>, AgentError> {
        let OptionKind::Articulate { action } = &option.kind else {
            return Ok(None);
        };
        let object = self.aosm.object(&option.object)?;
        let class = self.aosm.class(&object.class)?;
        let is_fit = |skill: &&Primitive| {
            let task = skill.task();
            let at = object.joints.get(&task.joint).copied();
            skill.does(class, action)
                && task.progress(at.unwrap_or(task.start)).abs() < BEGUN
                && skill.robot().description().name == self.model.description().name
        };
        Ok(self.learned.iter().find(is_fit).cloned())
    }

    /// The skill for an option from where the robot stands.
    pub(crate) fn choose_skill(&mut self, option: &OptionSpec) -> Result<Chosen, AgentError> {
        if let Some(skill) = self.learned_for(option)? {
            let map_from_base = self.map_from_base()?;
            let situation = self.situation(option, &map_from_base)?;
            let object_from_base = planar_from_pose(&situation.object.base_from_object).inverse();
            let name = skill.task().name.clone();
            let why = if TrainedRegion::of(&skill).probability(&object_from_base) > 0.0 {
                let state = self.robot.state()?;
                match skill.initiation(&situation, &state, &mut self.rng)? {
                    Initiation::Possible => {
                        let text = format!("by the learned skill {name}");
                        self.log(LogLevel::Info, text)?;
                        return Ok(Chosen {
                            skill: Box::new(skill),
                            learned: Some(name),
                        });
                    }
                    Initiation::Impossible(failure) => failure.to_string(),
                }
            } else {
                "the object stands otherwise than in its training".to_owned()
            };
            self.log(
                LogLevel::Info,
                format!("not by the learned skill {name}: {why}"),
            )?;
        }
        Ok(Chosen {
            skill: skill_for(option),
            learned: None,
        })
    }
}

/// The navigation symbol of a learned skill: the base stands as in its training.
pub(crate) fn symbol_of(skill: &Primitive, class: &str) -> NavigationSymbol {
    NavigationSymbol::given(&skill.task().name, class, TrainedRegion::of(skill))
}

/// Base poses from which an object stands before the robot as in training; less and less likely over the slack.
#[derive(Debug, Clone, Copy)]
struct TrainedRegion(PlacementRange);

impl TrainedRegion {
    fn of(skill: &Primitive) -> Self {
        Self(skill.task().placement)
    }
}

impl BasePoseClassifier for TrainedRegion {
    fn probability(&self, object_from_base: &Pose2) -> f64 {
        let base_from_object = object_from_base.inverse();
        let PlacementRange {
            x_m, y_m, yaw_rad, ..
        } = self.0;
        let beyond = |value: f64, [low, high]: [f64; 2]| (low - value).max(value - high).max(0.0);
        let middle = 0.5 * (yaw_rad[0] + yaw_rad[1]);
        let yaw = middle + wrap_angle(base_from_object.rotation.angle() - middle);
        let off = [
            beyond(base_from_object.translation.x, x_m) / SLACK.0,
            beyond(base_from_object.translation.y, y_m) / SLACK.0,
            beyond(yaw, yaw_rad) / SLACK.1,
        ];
        (1.0 - off.into_iter().fold(0.0, f64::max)).max(0.0)
    }

    /// In the inner half: parking adds its own error.
    fn propose(&self, rng: &mut dyn Rng) -> Pose2 {
        let shares = std::array::from_fn(|_| rng.random_range(0.25..=0.75));
        planar_from_pose(&self.0.at(shares)).inverse()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_base_stands_as_in_training_or_a_little_off() {
        let region = TrainedRegion(PlacementRange {
            x_m: [0.9, 1.0],
            y_m: [-0.1, 0.1],
            z_m: [0.0, 0.0],
            yaw_rad: [3.0, 3.3],
        });
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..20 {
            let pose = region.propose(&mut rng);
            assert!((region.probability(&pose) - 1.0).abs() < 1e-9, "{pose}");
        }
        let at =
            |x: f64, yaw: f64| region.probability(&Pose2::new(Vector2::new(x, 0.0), yaw).inverse());
        assert!((at(0.95, -3.1) - 1.0).abs() < 1e-9);
        assert!((at(1.02, 3.2) - 0.5).abs() < 1e-9);
        assert!(at(1.05, 3.2) < 1e-9 && at(0.95, 2.9) < 1e-9);
    }
}
