//! Policy search, whatever the policy: from a first policy on, epoch by epoch.

use factotum_descriptions::{MotorPolicy, RecordedMotion};
use factotum_learning::pi2::Pi2State;
use factotum_learning::policy_gradient::NaturalGradient;
use factotum_skills::bootstrap::{JointDemo, KinematicError, PlannedDemo};
use factotum_worlds::TaskRig;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::demonstration::joint_demo;
use super::network::NetworkSearch;
use super::primitive::PrimitiveSearch;
use super::{MotorError, MotorRecord, MotorRig, MotorRollout};

/// Where the first policy is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Init {
    /// The robot's own plan.
    Plan,
    /// Recorded motions.
    Demo,
    /// Nowhere: random weights.
    Random,
}

impl Init {
    /// Name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Demo => "demo",
            Self::Random => "random",
        }
    }
}

/// How a policy is improved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchName {
    /// PI²-CMA, for primitives.
    Pi2cma,
    /// The natural policy gradient, for networks.
    Npg,
    /// The same with the demonstrations at its side, for networks.
    Dapg,
}

impl SearchName {
    /// What the dissertation takes for a policy and its beginning.
    pub fn usual(policy: MotorPolicy, init: Init) -> Self {
        match (policy, init) {
            (MotorPolicy::Dmp, _) => Self::Pi2cma,
            (MotorPolicy::Mlp, Init::Plan | Init::Demo) => Self::Dapg,
            (MotorPolicy::Mlp, Init::Random) => Self::Npg,
        }
    }

    /// Name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pi2cma => "pi2cma",
            Self::Npg => "npg",
            Self::Dapg => "dapg",
        }
    }
}

/// A policy under search.
pub(super) trait MotorSearch {
    /// Rolls out the policy found so far, without exploring; `watch` sees the rig after every step.
    fn roll_out(
        &mut self,
        rig: &mut MotorRig,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError>;

    /// Tries `n` neighbours of the policy and learns from them.
    fn epoch(&mut self, rig: &mut MotorRig, n: usize) -> Result<Vec<MotorRollout>, MotorError>;

    /// What must be stored to go on.
    fn state(&self) -> SearchState;

    /// Goes on from what was stored, or says why that is of another policy.
    fn restore(&mut self, state: SearchState) -> Result<(), String>;

    /// Updates made.
    fn n_updates(&self) -> u64;
}

/// A search as it is stored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchState {
    /// Of a primitive.
    Primitive(Pi2State),
    /// Of a network.
    Network(Box<NaturalGradient>),
}

/// Begins what a record says, with the plan that it begins from, if it does; `recorded` is what was recorded for it.
pub(super) fn begin(
    rig: &mut MotorRig,
    record: &MotorRecord,
    recorded: &[RecordedMotion],
) -> Result<(Box<dyn MotorSearch>, Option<PlannedDemo>), MotorError> {
    let mut rng = ChaCha8Rng::seed_from_u64(record.seed);
    let error = KinematicError {
        position_m: record.model_error_m,
        axis_rad: record.model_error_rad,
        range: 0.0,
    };
    let plan = match record.init {
        Init::Plan => Some(rig.plan(&error, &mut rng)?),
        Init::Demo | Init::Random => None,
    };
    let demos: Vec<JointDemo> = match (&plan, record.init) {
        (Some(plan), _) => vec![plan.motion.clone()],
        (None, Init::Demo) => recorded.iter().map(joint_demo).collect(),
        (None, _) => Vec::new(),
    };
    let search: Box<dyn MotorSearch> = match (record.policy, record.search) {
        (MotorPolicy::Dmp, SearchName::Pi2cma) => Box::new(PrimitiveSearch::new(
            rig,
            demos.first(),
            record.seed,
            &mut rng,
        )?),
        (MotorPolicy::Mlp, SearchName::Npg | SearchName::Dapg) => Box::new(NetworkSearch::new(
            rig,
            &demos,
            record.search,
            record.seed,
            &mut rng,
        )?),
        (policy, search) => {
            return Err(MotorError::Misfit {
                policy: policy.name(),
                search: search.name(),
            });
        }
    };
    Ok((search, plan))
}
