//! What has been learned, apart from how.

use crate::mlp::{Mlp, Pass};

use super::Td3Error;
use super::error::{check_observation, check_size};

/// A deterministic policy: from an observation to an action within -1..=1.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    pub(crate) network: Mlp,
    pass: Pass,
}

impl Policy {
    pub(crate) fn of(network: Mlp) -> Self {
        Self {
            pass: Pass::new(network.architecture(), 1),
            network,
        }
    }

    /// Components of an observation.
    #[must_use]
    pub fn n_observation(&self) -> usize {
        self.network.architecture().n_inputs
    }

    /// Components of an action.
    #[must_use]
    pub fn n_action(&self) -> usize {
        self.network.architecture().n_outputs
    }

    /// The action for an observation. `&mut` is for the memory it works in; it learns nothing.
    ///
    /// # Errors
    ///
    /// When a slice has another size than the policy, or a number is not finite.
    pub fn act_into(&mut self, observation: &[f32], action: &mut [f32]) -> Result<(), Td3Error> {
        check_size("observation", observation.len(), self.n_observation())?;
        check_size("action", action.len(), self.n_action())?;
        check_observation(observation)?;
        self.network
            .evaluate_into(observation, &mut self.pass, action);
        Ok(())
    }
}
