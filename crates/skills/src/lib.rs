//! Skills: options (I, π, β) that a plan is made of.
//!
//! A [`Skill`] says whether it can start ([`Skill::initiation`], I), runs its policy π through a
//! [`Robot`](factotum_control::Robot) until its termination condition β, and reports an [`Outcome`] with a reason.
//! It knows nothing of maps and symbols: it is told what is around the robot, in the base frame, as a [`Situation`].
//! Taught skills (thesis 6.2.1) are given by poses in the object's frame Λ; they end with the arm in free space,
//! so that any other skill can follow. [`cip`] has skills that are learned in contact, [`bootstrap`] the plans by which a robot
//! shows itself how to begin.

mod arm;
mod articulate;
pub mod bootstrap;
pub mod cip;
mod demonstrated;
mod pick;
mod place;
mod skill;
mod way;

pub use arm::{ArmMotion, ToolPathNeeds, is_holding};
pub use articulate::Articulate;
pub use pick::Pick;
pub use place::Place;
pub use skill::{Failure, HeldView, Initiation, ObjectView, Outcome, Situation, Skill, SkillError};
