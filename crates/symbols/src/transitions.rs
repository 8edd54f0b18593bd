//! Transitions: what a robot recorded while it tried its options, as checked values.
//!
//! One transition (s, o, s') says that option o was run in state s and left the world in s'. With it
//! come the *mask* (the variables that o changed), which options could have run in s, the episode,
//! and perhaps a reward and whether the goal was reached in s'. That is the input of James, Rosman
//! and Konidaris ("Learning portable representations for high-level planning", ICML 2020) and of
//! dissertation 5.4.

mod error;
mod read;
#[cfg(test)]
mod tests;

pub use error::{ReadError, TransitionError};
pub use read::read_csv;

use crate::samples::Samples;

/// One transition, to be added to [`Transitions`].
#[derive(Debug, Clone, Copy)]
pub struct Transition<'a> {
    /// The state before.
    pub state: &'a [f64],
    /// Which option ran, as its index.
    pub option: usize,
    /// The state after.
    pub next_state: &'a [f64],
    /// The variables the option changed; without it, those whose values differ.
    pub mask: Option<&'a [usize]>,
    /// For each option, whether it could have run in `state`.
    pub executable: &'a [bool],
    /// The episode, a run of transitions from a start state.
    pub episode: u64,
    /// What the step paid (negative: what it cost), if recorded.
    pub reward: Option<f64>,
    /// Whether `next_state` fulfils the goal.
    pub goal_achieved: bool,
}

/// Recorded transitions of one robot in one state space.
#[derive(Debug, Clone, PartialEq)]
pub struct Transitions {
    variables: Vec<String>,
    options: Vec<String>,
    states: Samples,
    next_states: Samples,
    steps: Vec<Step>,
    executable: Vec<bool>,
}

#[derive(Debug, Clone, PartialEq)]
struct Step {
    option: usize,
    mask: Vec<usize>,
    episode: u64,
    reward: Option<f64>,
    goal_achieved: bool,
}

impl Transitions {
    /// None yet, over named variables and options.
    pub fn new(variables: Vec<String>, options: Vec<String>) -> Self {
        Self {
            states: Samples::new(variables.len()),
            next_states: Samples::new(variables.len()),
            variables,
            options,
            steps: Vec::new(),
            executable: Vec::new(),
        }
    }

    /// Adds a transition.
    ///
    /// # Errors
    /// [`TransitionError`]: another number of values or options, a value that is not finite, or an
    /// option or a mask that does not exist.
    pub fn push(&mut self, transition: &Transition<'_>) -> Result<(), TransitionError> {
        self.check_values("state", transition.state)?;
        self.check_values("next state", transition.next_state)?;
        if transition.executable.len() != self.options.len() {
            return Err(TransitionError::Executable {
                found: transition.executable.len(),
                wanted: self.options.len(),
            });
        }
        if transition.option >= self.options.len() {
            return Err(TransitionError::Option {
                found: transition.option,
                n_options: self.options.len(),
            });
        }
        if let Some(found) = transition.reward.filter(|r| !r.is_finite()) {
            return Err(TransitionError::Reward { found });
        }
        let mask = match transition.mask {
            Some(mask) => self.checked_mask(mask)?,
            None => differing(transition.state, transition.next_state),
        };
        self.states.push(transition.state);
        self.next_states.push(transition.next_state);
        self.executable.extend_from_slice(transition.executable);
        self.steps.push(Step {
            option: transition.option,
            mask,
            episode: transition.episode,
            reward: transition.reward,
            goal_achieved: transition.goal_achieved,
        });
        Ok(())
    }

    fn check_values(&self, which: &'static str, values: &[f64]) -> Result<(), TransitionError> {
        if values.len() != self.variables.len() {
            return Err(TransitionError::Length {
                which,
                found: values.len(),
                wanted: self.variables.len(),
            });
        }
        match values.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            Some(i) => Err(TransitionError::NotFinite {
                which,
                variable: self.variables[i].clone(),
                found: values[i],
            }),
        }
    }

    /// The mask in ascending order.
    fn checked_mask(&self, mask: &[usize]) -> Result<Vec<usize>, TransitionError> {
        let n_variables = self.variables.len();
        if let Some(&found) = mask.iter().find(|&&v| v >= n_variables) {
            return Err(TransitionError::Mask { found, n_variables });
        }
        let mut mask = mask.to_vec();
        mask.sort_unstable();
        mask.dedup();
        Ok(mask)
    }

    /// How many transitions.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The names of the state variables.
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// The names of the options.
    pub fn options(&self) -> &[String] {
        &self.options
    }

    /// The states before.
    pub fn states(&self) -> &Samples {
        &self.states
    }

    /// The states after.
    pub fn next_states(&self) -> &Samples {
        &self.next_states
    }

    /// Which option ran in transition `i`.
    pub fn option(&self, i: usize) -> usize {
        self.steps[i].option
    }

    /// The variables that changed in transition `i`, ascending.
    pub fn mask(&self, i: usize) -> &[usize] {
        &self.steps[i].mask
    }

    /// What transition `i` paid, if recorded.
    pub fn reward(&self, i: usize) -> Option<f64> {
        self.steps[i].reward
    }

    /// Whether transition `i` ended where the goal is fulfilled.
    pub fn goal_achieved(&self, i: usize) -> bool {
        self.steps[i].goal_achieved
    }

    /// Whether an option could have run before transition `i`.
    pub fn is_executable(&self, i: usize, option: usize) -> bool {
        self.executable[i * self.options.len() + option]
    }

    /// The first transition of each episode, in order.
    pub fn starts(&self) -> Vec<usize> {
        (0..self.len())
            .filter(|&i| i == 0 || self.steps[i].episode != self.steps[i - 1].episode)
            .collect()
    }

    /// The same transitions seen through some of the variables, given in ascending order: the others are
    /// projected out of states and masks.
    pub fn project(&self, variables: &[usize]) -> Self {
        let project = |step: &Step| {
            let place = |v: &usize| variables.binary_search(v).ok();
            Step {
                mask: step.mask.iter().filter_map(place).collect(),
                ..step.clone()
            }
        };
        Self {
            variables: (variables.iter())
                .map(|&v| self.variables[v].clone())
                .collect(),
            options: self.options.clone(),
            states: self.states.project(variables),
            next_states: self.next_states.project(variables),
            steps: self.steps.iter().map(project).collect(),
            executable: self.executable.clone(),
        }
    }

    /// The first `n` transitions, or all there are.
    pub fn first(&self, n: usize) -> Self {
        let n = n.min(self.len());
        let rows: Vec<usize> = (0..n).collect();
        Self {
            variables: self.variables.clone(),
            options: self.options.clone(),
            states: self.states.select(&rows),
            next_states: self.next_states.select(&rows),
            steps: self.steps[..n].to_vec(),
            executable: self.executable[..n * self.options.len()].to_vec(),
        }
    }
}

/// The variables whose values differ.
fn differing(state: &[f64], next_state: &[f64]) -> Vec<usize> {
    (0..state.len())
        .filter(|&v| state[v].total_cmp(&next_state[v]).is_ne())
        .collect()
}
