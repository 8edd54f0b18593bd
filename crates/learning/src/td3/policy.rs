//! What has been learned, apart from how.

use crate::mlp::{Mlp, Pass};

use super::Td3Error;
use super::error::check_observation;

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
        let sizes = [
            ("observation", observation.len(), self.n_observation()),
            ("action", action.len(), self.n_action()),
        ];
        if let Some((what, found, wanted)) =
            sizes.into_iter().find(|(_, found, wanted)| found != wanted)
        {
            return Err(Td3Error::Size {
                what,
                found,
                wanted,
            });
        }
        check_observation(observation)?;
        self.network
            .evaluate_into(observation, &mut self.pass, action);
        Ok(())
    }
}
