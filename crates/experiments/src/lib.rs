//! What is kept of a run, and runs in number: run folders, recordings, reports and sweeps over seeds.
//!
//! A run leaves a [`run_folder::RunFolder`] with its manifest, a [`recording::Recording`] that opens in Foxglove, and a
//! [`report::Report`] to read or print. All three take the plain data of `factotum-protocol`, the same messages that a
//! page is shown, so that whoever drives a run feeds page, recording and report from one place. A
//! [`sweep::SeedSweep`] runs a command over many seeds in child processes and says how often it succeeded.
//!
//! Skills are trained into a [`skill_folder::SkillFolder`] by [`skill_training`]. A [`grid::Grid`] trains one for each
//! task, setting and seed, and draws what came of it as a [`figure::Figure`]. A [`training_watch::TrainingWatch`] sees
//! trainings of other processes go on.
//!
//! [`motor`] learns motor skills from the robot's own plans. [`nav_symbols`] learns where the base must be.
//! [`composition`] does skills that were learned apart one after the other.
//!
//! Nothing here reads the clock: times come as [`utc::UtcTime`] or as seconds of the robot's clock.

pub mod composition;
pub mod figure;
pub mod film;
pub mod grid;
pub mod motor;
pub mod nav_symbols;
pub mod recording;
pub mod report;
pub mod run_folder;
pub mod skill_folder;
pub mod skill_training;
pub mod storage;
pub mod sweep;
pub mod training_watch;
pub mod utc;
