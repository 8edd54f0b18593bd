//! Discrete Dynamic Movement Primitives: a motion shown once, run again to other goals in other times.
//!
//! A primitive is a critically damped spring that pulls to the goal, and a learned force that shapes the way there
//! and fades out with a phase, so that the goal is reached whatever was learned:
//!
//! ```text
//! tau x' = -alpha_x x                                          phase, from 1 towards 0
//! tau z' = alpha_z (beta_z (g - y) - z) + s f(x),  tau y' = z  beta_z = alpha_z / 4
//! f(x)   = x (sum_i psi_i(x) w_i) / (sum_i psi_i(x)),  psi_i(x) = exp(-h_i (x - c_i)^2)
//! ```
//!
//! Sources: Ijspeert, Nakanishi, Hoffmann, Pastor & Schaal, "Dynamical Movement Primitives: Learning Attractor Models
//! for Motor Behaviors", Neural Computation 25 (2013), doi 10.1162/NECO_a_00393: the discrete system, and
//! locally weighted regression. Rotations: Ude, Nemec, Petric & Morimoto, "Orientation in Cartesian Space Dynamic
//! Movement Primitives", ICRA 2014, doi 10.1109/ICRA.2014.6907291: the form with unit quaternions.
//!
//! Where we differ: the force is learned in the demonstration's own size and multiplied at run time
//! ([`ShapeScaling`]), so that a dimension that ends where it began needs no division by `g - y0`; the phase is taken
//! from its closed form instead of being integrated, and so is the motion of a spring of positions, in which only the
//! learned force is integrated numerically.
//!
//! Weights, goal and speed of a run are one list of numbers for a search: [`PositionDmp::parameters`].
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | x | phase | 1 |
//! | y, g | position and goal | m or rad |
//! | z | velocity times duration | m or rad |
//! | tau | duration | s |
//! | alpha_z | [`DmpParams::damping`] | 1 |
//! | alpha_x | [`DmpParams::phase_decay`] | 1 |
//! | w, c, h | weight, centre and width of a kernel | m or rad; 1; 1 |
//! | s | scale of the shape | 1 |

mod canonical;
mod demonstration;
mod error;
mod forcing;
mod orientation;
mod parameters;
mod params;
mod position;
mod spring;

pub use error::DmpError;
pub use forcing::ForcingTerms;
pub use orientation::{OrientationDmp, OrientationMotion, OrientationRollout, OrientationState};
pub use params::DmpParams;
pub use position::{PositionDmp, PositionMotion, PositionRollout, PositionState, ShapeScaling};

#[cfg(test)]
mod tests;
