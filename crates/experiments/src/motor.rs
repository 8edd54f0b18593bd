//! Motor skills: a first policy from the robot's own plan, or none, and policy search from there (thesis Chapter 4,
//! Algorithm 1).
//!
//! A policy is a movement primitive of the arm's joints, or a network of where arm and object are. An action is a joint
//! velocity: that of the primitive and a little of what the arm lags behind, or what the network says. The reward is
//! Eq. 4.1 with c = 60 and R = 0.001 I, at each step:
//!
//! ```text
//! r = -c (q_O* - q_O)² - aᵀ R a
//! ```
//!
//! [`MotorRig`] is where it is tried, a search looks for better ones (`search.rs`: `primitive.rs`, `network.rs`),
//! [`MotorTraining`] keeps it all in a folder, [`Study`] does so over seeds.

mod demonstration;
mod folder;
mod network;
mod primitive;
mod rig;
mod search;
mod study;
mod training;

use factotum_descriptions::{DescriptionError, MotionFileError, MotionProblem};
use factotum_learning::dmp::DmpError;
use factotum_learning::pi2::Pi2Error;
use factotum_learning::policy_gradient::PolicyGradientError;
use factotum_motion::MotionError;
use factotum_skills::bootstrap::BootstrapError;
use factotum_worlds::RigError;

use crate::storage::StorageError;

pub use demonstration::{DemoError, demos_to_begin_with};
pub use folder::{MotorFolder, MotorRecord};
pub use rig::{MotorRig, MotorRollout};
pub use search::{Init, SearchName, SearchState};
pub use study::{
    Comparison, Row, Study, StudyError, Table, Trial, TrialResult, Variant, report as study_report,
};
pub use training::{EpochRecord, MotorSummary, MotorTraining};

/// Why a motor skill could not be learned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MotorError {
    /// The task is no motor skill.
    #[error(
        "task `{task}` has no table `[motor]`, so there is nothing to plan and search; train it as a contact skill"
    )]
    NoMotor {
        /// The task.
        task: String,
    },
    /// The robot's description.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The robot's kinematics.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// There is no demonstration.
    #[error(transparent)]
    Bootstrap(#[from] BootstrapError),
    /// The primitive.
    #[error(transparent)]
    Dmp(#[from] DmpError),
    /// The search.
    #[error(transparent)]
    Search(#[from] Pi2Error),
    /// The network, or its search.
    #[error(transparent)]
    Network(#[from] PolicyGradientError),
    /// A recorded motion in a file.
    #[error(transparent)]
    MotionFile(#[from] MotionFileError),
    /// What was recorded is no motion.
    #[error("what was recorded is no motion: {0}")]
    Recorded(MotionProblem),
    /// A recorded motion that is none of this task.
    #[error(transparent)]
    Demo(#[from] DemoError),
    /// A search that is for another form of policy.
    #[error(
        "policy `{policy}` cannot be improved by `{search}`; dmp is by pi2cma, mlp by npg or dapg"
    )]
    Misfit {
        /// The policy.
        policy: &'static str,
        /// The search.
        search: &'static str,
    },
    /// A search by demonstrations without any.
    #[error("`dapg` needs demonstrations, and random weights have none; use npg")]
    NothingShown,
    /// The folder.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The folder holds another run.
    #[error(
        "`{folder}` holds a run of task `{found_task}`, `{found_init}`, seed {found_seed}; go on with that by --resume, or choose \
         another folder"
    )]
    Taken {
        /// The folder.
        folder: String,
        /// Its task.
        found_task: String,
        /// Where its first policy is from.
        found_init: &'static str,
        /// Its seed.
        found_seed: u64,
    },
    /// A later program wrote it.
    #[error("`{folder}` has format {found}, expected {wanted}")]
    Format {
        /// The folder.
        folder: String,
        /// Its format.
        found: u32,
        /// What can be read.
        wanted: u32,
    },
    /// What is stored of the search cannot be read, or is of another task.
    #[error("`{file}` is not the search of this run: {reason}")]
    Stored {
        /// The file.
        file: String,
        /// What stands against it.
        reason: String,
    },
    /// A record that cannot be written as text.
    #[error("the record of the run cannot be written: {0}")]
    Text(String),
}

impl MotorError {
    /// Whether it is the user's to mend: a task, a folder, a file.
    pub fn is_of_input(&self) -> bool {
        match self {
            Self::NoMotor { .. }
            | Self::Description(_)
            | Self::Bootstrap(_)
            | Self::Misfit { .. }
            | Self::NothingShown
            | Self::MotionFile(_)
            | Self::Recorded(_)
            | Self::Demo(_)
            | Self::Taken { .. }
            | Self::Format { .. }
            | Self::Stored { .. } => true,
            Self::Rig(error) => error.is_of_input(),
            Self::Motion(_)
            | Self::Dmp(_)
            | Self::Search(_)
            | Self::Network(_)
            | Self::Storage(_)
            | Self::Text(_) => false,
        }
    }
}

#[cfg(test)]
mod tests;
