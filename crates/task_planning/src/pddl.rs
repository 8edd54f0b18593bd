//! Reading and writing PDDL and PPDDL, and turning PPDDL into PDDL.
//!
//! Understood: STRIPS, typing, equality, negative, disjunctive and quantified preconditions,
//! conditional and universal effects, constants, action costs (McDermott et al., PDDL 1.2, 1998; Fox
//! & Long, JAIR 20, 2003; the 2008 competition's `total-cost`), and PPDDL's probabilistic effects
//! and rewards (Younes & Littman, CMU-CS-04-167, 2004). Not understood, and said so with the place:
//! `either` types, numeric conditions, durative actions, derived predicates, preferences.
//!
//! `(decrease (reward) c)` is read as a cost of c and written as `(increase (total-cost) c)`.
//! Names keep the spelling of their declaration; references may differ by case.

mod determinise;
mod error;
mod read_condition;
mod read_domain;
mod read_effect;
mod read_problem;
mod read_typed_list;
mod s_expression;
#[cfg(test)]
mod tests;
mod write;

pub use determinise::{DeterminiseOptions, Determinised, Origin, determinise};
pub use error::{PddlError, Position};
pub use read_domain::parse_domain;
pub use read_problem::{ParsedTask, UndeclaredTypes, parse_problem, parse_task};
pub use write::{write_domain, write_problem};
