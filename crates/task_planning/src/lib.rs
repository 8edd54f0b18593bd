//! Symbolic task planning: operators with provenance, (P)PDDL, planners, and the judge of plans.
//!
//! - [`operator`]: domains, problems and plans as checked values;
//! - [`pddl`]: reading and writing them, and determinising PPDDL;
//! - [`planner`]: one trait over embedded and external planners;
//! - [`validate`]: independent plan validation, and a plan's probability.
//!
//! Floor 0: this crate knows nothing of geometry or robots. It touches files and starts processes
//! only to talk to an external planner, and reads neither the environment nor the wall clock
//! (a monotonic timer serves to end a planner's process).

mod names;
pub mod operator;
pub mod pddl;
pub mod planner;
pub mod validate;
