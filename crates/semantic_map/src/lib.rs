//! The Action-Oriented Semantic Map (AOSM): what a robot knows of a home, in a form it can plan with.
//!
//! An AOSM is ⟨C, O, M, A⟩ (thesis 6.2.1): object classes with their local frames Λ, models τ and attributes; objects
//! with their poses Γ in the map; the occupancy grid M; and the actions of the classes. Grounding the actions'
//! navigation symbols at the objects gives the nodes of the topological graph (V, E) of thesis 5.3, whose edges say
//! that the base can drive from one region to the other.
//!
//! On disk a home is a folder of text files ([`home_folder`]) with a journal of all that was changed and done;
//! [`Home`] keeps the two and the AOSM in step, through crashes too.
//!
//! Frames: `map` is the frame of the grid (REP-105). `map_from_object` is Γ.

mod aosm;
mod edit;
mod error;
mod goal;
mod graph;
mod home;
mod journal;
mod option;
mod vocabulary;

pub mod home_folder;

pub use aosm::{Aosm, Location, MapObject, ObjectSource};
pub use edit::{Edit, Thing};
pub use error::MapError;
pub use goal::{ChoreGoal, Wanted};
pub use graph::{GraphEdge, GraphNode, TopologicalGraph};
pub use home::{Home, HomeCheck};
pub use journal::{By, Change, Entry, EntryKind, Execution, Remembered, Request};
pub use option::{DEFAULT_APPROACH, NavigationAnchor, OptionKind, OptionSpec};
pub use vocabulary::{HAND_EMPTY, HOLDING, IN, LOOSE, PICK};
