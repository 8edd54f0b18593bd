//! What another executive needs, besides the map and the robot's own state, to go on where this one is.
//!
//! A checkpoint is taken between motions: after each stop of an exploration and each executed step of a plan. Of what the
//! senses have gathered it has the surfaces seen; the rest is in the map (grid and objects), from which they begin again.

use factotum_geometry::cloud::PointCloud;
use factotum_geometry::{Pose, Pose2};
use nalgebra::Point2;

use crate::viewed::Viewed;
use crate::{AgentError, Event, Executive, RunReport};

/// Where an executive is in its work.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// Where the odometry frame lies in the map.
    pub map_from_odom: Pose2,
    /// How the gripper holds the object that the map says is held.
    pub tcp_from_held: Option<Pose>,
    /// Surfaces seen by the camera, in the map.
    pub seen: PointCloud,
    /// Middles of the squares of the map that the camera has had in view.
    pub viewed: Vec<Point2<f64>>,
    /// How far the random stream has been used, in words.
    pub rng_word_pos: u128,
    /// How far the chore has come.
    pub stage: Stage,
    /// What was done for the chore so far.
    pub report: RunReport,
}

/// How far a chore has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stage {
    /// None is under way.
    #[default]
    Between,
    /// One is under way, and needs a plan.
    Planning,
    /// So many steps of the report's plan are done.
    Acting {
        /// Steps done.
        n_steps_done: usize,
    },
}

impl Executive<'_> {
    /// Tells the observer what it takes to go on from here. The robot is to be at rest.
    ///
    /// # Errors
    /// [`AgentError`] if the robot does not answer, and [`AgentError::Stopped`] when the observer wished to stop.
    pub fn checkpoint(&mut self) -> Result<(), AgentError> {
        let secs = self.robot.state()?.time_secs - self.chore_began_secs;
        let checkpoint = Checkpoint {
            map_from_odom: self.senses.map_from_odom(),
            tcp_from_held: self.tcp_from_held,
            seen: self.senses.seen(),
            viewed: self.viewed.middles(),
            rng_word_pos: self.rng.get_word_pos(),
            stage: self.stage,
            report: RunReport {
                robot_secs: secs,
                ..self.report.clone()
            },
        };
        let wish = self.observer.observe(&Event::Checkpoint {
            aosm: &self.aosm,
            checkpoint: &checkpoint,
        });
        self.heed(wish)
    }

    /// Goes on from a checkpoint, after [`Executive::new`] with its map and `map_from_odom`. If a chore was under way,
    /// the next [`Executive::do_chore`] goes on with it.
    pub fn restore(&mut self, checkpoint: &Checkpoint) {
        self.tcp_from_held = checkpoint.tcp_from_held;
        self.senses.remember(&checkpoint.seen);
        self.viewed = Viewed::of_points(&checkpoint.viewed);
        self.rng.set_word_pos(checkpoint.rng_word_pos);
        self.stage = checkpoint.stage;
        self.report.clone_from(&checkpoint.report);
    }
}
