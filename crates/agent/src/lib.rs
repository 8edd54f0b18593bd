//! The executive: explore, build the AOSM, plan, interleave navigation, act, monitor, recover.
//!
//! It speaks to a [`Robot`](factotum_control::Robot) and believes what it has seen; it cannot know whether the robot is
//! simulated, and it never says that a chore is achieved, only that it believes so.
//!
//! A chore goes: manipulation-only plan p_O from the AOSM's domain; for each option, base poses sampled from its
//! navigation symbol and kept if the option could start there; a path to one of them (p_O becomes {n₁, o₁, n₂, o₂, …},
//! thesis 5.3); the skill; a look at what came of it; then on, again from elsewhere, or a new plan.

mod act;
mod braking;
mod checkpoint;
mod drive;
mod drive_by_hand;
mod effects;
mod error;
mod event;
mod executive;
mod explore;
mod learned;
mod localise;
mod navigate;
mod perform;
mod report;
mod senses;
mod settings;
mod surroundings;
mod tell;
mod viewed;

pub use checkpoint::{Checkpoint, Stage};
pub use drive_by_hand::{Driver, Steer};
pub use error::AgentError;
pub use event::{Event, LogLevel, Observer, StepKind, StepState, StepView, Wish};
pub use executive::Executive;
pub use localise::find_in_map;
pub use navigate::ground_home;
pub use report::{ExecutedStep, RunReport};
pub use settings::Settings;
