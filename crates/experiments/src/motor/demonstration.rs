//! Recorded motions as demonstrations: made by hand, played back, and chosen to begin with.

use std::path::{Path, PathBuf};

use factotum_descriptions::{MotionHead, MotionProblem, MotionSample, RecordedMotion};
use factotum_skills::bootstrap::JointDemo;
use factotum_skills::cip::rig::{Reading, Rig as _};
use factotum_worlds::TaskRig;
use nalgebra::DVector;

use super::primitive::CATCH_UP_PER_SEC;
use super::rig::Controller;
use super::{MotorError, MotorRig, MotorRollout};

/// A demonstration may begin this far from where the task does, rad.
const START_OFF_MAX_RAD: f64 = 0.2;

/// Why a recorded motion is no demonstration to begin with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DemoError {
    /// Of another task.
    #[error("`{}` is of task `{found}`, expected `{wanted}`", file.display())]
    Task {
        /// The file.
        file: PathBuf,
        /// Its task.
        found: String,
        /// The task to be learned.
        wanted: String,
    },
    /// Of another arm.
    #[error("`{}` has joints {found:?}, expected {wanted:?}", file.display())]
    Joints {
        /// The file.
        file: PathBuf,
        /// Its joints.
        found: Vec<String>,
        /// The arm's.
        wanted: Vec<String>,
    },
    /// Begun elsewhere.
    #[error(
        "`{}` begins with joint `{joint}` at {found:.3} rad, expected {wanted:.3} rad, where the task begins",
        file.display()
    )]
    Start {
        /// The file.
        file: PathBuf,
        /// The joint.
        joint: String,
        /// Where it is, rad.
        found: f64,
        /// Where it should be, rad.
        wanted: f64,
    },
    /// None does the task.
    #[error(
        "none of {n} demonstrations does the task; `--failed-demos` begins with one all the same"
    )]
    AllFailed {
        /// Those there are.
        n: usize,
    },
}

impl MotorRig {
    /// Whether a recorded motion, read from a file, is one of this task and arm.
    ///
    /// # Errors
    /// [`DemoError`] if it is of another task or arm, or begins elsewhere.
    pub fn check_demo(&self, file: &Path, motion: &RecordedMotion) -> Result<(), DemoError> {
        let head = motion.head();
        let task = self.rig().task();
        if head.task != task.name {
            return Err(DemoError::Task {
                file: file.to_owned(),
                found: head.task.clone(),
                wanted: task.name.clone(),
            });
        }
        let joints = self.joints();
        if head.joints != joints {
            return Err(DemoError::Joints {
                file: file.to_owned(),
                found: head.joints.clone(),
                wanted: joints,
            });
        }
        let first = motion.at(0.0).positions;
        let starts = first.iter().zip(&self.rig().reading().arm_positions);
        for ((found, wanted), joint) in starts.zip(joints) {
            if (found - wanted).abs() > START_OFF_MAX_RAD {
                return Err(DemoError::Start {
                    file: file.to_owned(),
                    joint,
                    found: *found,
                    wanted: *wanted,
                });
            }
        }
        Ok(())
    }

    fn joints(&self) -> Vec<String> {
        let robot = self.rig().anatomy().robot.description();
        robot.arm.joints.clone()
    }

    /// Records what `jog` does with the arm, from the start of the task until it says that it is done. It is given what
    /// there is to see and the joint velocities to set, rad/s, at every step; `made_by` says in words who it is.
    ///
    /// # Errors
    /// [`MotorError`] when the physics breaks down; [`MotorError::Motion`] if it ends at once.
    pub fn record(
        &mut self,
        made_by: &str,
        jog: &mut dyn FnMut(&TaskRig, &mut [f64]) -> bool,
    ) -> Result<RecordedMotion, MotorError> {
        self.begin()?;
        let step_secs = self.step_secs();
        let (task, joints) = (self.rig().task().clone(), self.joints());
        let robot = &self.rig().anatomy().robot.description().name;
        let mut head = MotionHead::new(&task.name, robot, &joints, step_secs, made_by);
        let mut samples = vec![self.sample(0.0)];
        let mut action = vec![0.0; self.n_joints()];
        while jog(self.rig(), &mut action) {
            self.drive(&action)?;
            samples.push(self.sample(step_secs * samples.len() as f64));
            action.fill(0.0);
        }
        head.success = self.is_done();
        Ok(RecordedMotion::new(head, samples)?)
    }

    fn sample(&self, secs: f64) -> MotionSample {
        let reading = self.rig().reading();
        MotionSample {
            secs,
            positions: reading.arm_positions.clone(),
            object: reading.object_joint,
        }
    }

    /// Plays a recorded motion as it was made, for as long as it took; `watch` sees the rig after every step.
    ///
    /// # Errors
    /// [`MotorError`] when the physics breaks down.
    pub fn replay(
        &mut self,
        motion: &RecordedMotion,
        watch: &mut dyn FnMut(&TaskRig),
    ) -> Result<MotorRollout, MotorError> {
        let step_secs = self.step_secs();
        let n_steps = (motion.duration_secs() / step_secs).round().max(1.0) as usize;
        let mut following = Following {
            motion,
            step_secs,
            n_steps: 0,
        };
        self.roll_out_for(n_steps, &mut following, watch)
    }
}

/// Goes from sample to sample.
struct Following<'a> {
    motion: &'a RecordedMotion,
    step_secs: f64,
    n_steps: usize,
}

impl Controller for Following<'_> {
    fn act(&mut self, seen: &Reading, action: &mut [f64]) -> Result<(), MotorError> {
        let now = self.step_secs * self.n_steps as f64;
        let [here, next] = [now, now + self.step_secs].map(|secs| self.motion.at(secs).positions);
        self.n_steps += 1;
        for (i, action) in action.iter_mut().enumerate() {
            let lag = here[i] - seen.arm_positions[i];
            *action = (next[i] - here[i]) / self.step_secs + CATCH_UP_PER_SEC * lag;
        }
        Ok(())
    }
}

/// Those of some recorded motions to begin with: all that do the task, or all there are.
///
/// # Errors
/// [`DemoError::AllFailed`] if none is left.
pub fn demos_to_begin_with(
    motions: Vec<RecordedMotion>,
    failed_too: bool,
) -> Result<Vec<RecordedMotion>, DemoError> {
    let n = motions.len();
    let mut kept = motions;
    kept.retain(|motion| failed_too || motion.head().success);
    if kept.is_empty() {
        return Err(DemoError::AllFailed { n });
    }
    Ok(kept)
}

/// A recorded motion at equal steps of time, at least as many as a primitive needs.
pub(super) fn joint_demo(motion: &RecordedMotion) -> JointDemo {
    const N_STEPS_MIN: f64 = 64.0;
    let n_steps = (motion.duration_secs() / motion.head().step_secs)
        .round()
        .max(N_STEPS_MIN);
    let step_secs = motion.duration_secs() / n_steps;
    let moments = (0..=n_steps as usize).map(|k| motion.at(step_secs * k as f64));
    let (positions, object) = moments
        .map(|moment| (DVector::from_vec(moment.positions), moment.object))
        .unzip();
    JointDemo {
        positions,
        object,
        step_secs,
    }
}

impl From<MotionProblem> for MotorError {
    fn from(problem: MotionProblem) -> Self {
        Self::Recorded(problem)
    }
}

#[cfg(test)]
mod tests {
    use factotum_descriptions::TaskSpec;

    use super::*;

    fn rig(name: &str) -> MotorRig {
        let tasks = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/tasks");
        let task = TaskSpec::load(&tasks.join(format!("{name}.toml"))).unwrap();
        MotorRig::new(&task).unwrap()
    }

    /// The base turns for so many steps.
    fn turning(rig: &mut MotorRig, n_steps: usize) -> Result<RecordedMotion, MotorError> {
        let mut left = n_steps;
        rig.record("a test", &mut |_, action| {
            action[0] = 0.5;
            let goes_on = left > 0;
            left = left.saturating_sub(1);
            goes_on
        })
    }

    #[test]
    fn what_is_recorded_is_played_again() {
        let mut rig = rig("t-ball");
        let motion = turning(&mut rig, 20).unwrap();
        assert_eq!(motion.samples().len(), 21);
        assert!(!motion.head().success);
        let turned = motion.samples()[20].positions[0] - motion.samples()[0].positions[0];
        assert!((turned - 0.5).abs() < 0.05, "{turned}");
        let mut last = Vec::new();
        let mut n_seen = 0;
        rig.replay(&motion, &mut |rig| {
            last.clone_from(&rig.reading().arm_positions);
            n_seen += 1;
        })
        .unwrap();
        assert_eq!(n_seen, 21);
        for (a, b) in last.iter().zip(&motion.samples()[20].positions) {
            assert!((a - b).abs() < 0.02, "{a} {b}");
        }
        assert!(turning(&mut rig, 1).is_err(), "two samples are no motion");
    }

    #[test]
    fn what_is_of_something_else_or_failed_is_refused() {
        let mut ball = rig("t-ball");
        let motion = turning(&mut ball, 5).unwrap();
        let file = Path::new("a.jsonl");
        ball.begin().unwrap();
        ball.check_demo(file, &motion).unwrap();
        let error = rig("microwave").check_demo(file, &motion).unwrap_err();
        assert!(error.to_string().contains("`t-ball`"), "{error}");
        let mut head = motion.head().clone();
        head.joints[1] = "elbow".to_owned();
        let other = RecordedMotion::new(head, motion.samples().to_vec()).unwrap();
        let error = ball.check_demo(file, &other).unwrap_err();
        assert!(error.to_string().contains("elbow"), "{error}");
        let mut samples = motion.samples().to_vec();
        samples[0].positions[3] += 0.3;
        let elsewhere = RecordedMotion::new(motion.head().clone(), samples).unwrap();
        let error = ball.check_demo(file, &elsewhere).unwrap_err();
        assert!(error.to_string().contains("joint_4"), "{error}");

        let failed = vec![motion.clone()];
        assert_eq!(demos_to_begin_with(failed.clone(), true).unwrap(), failed);
        let error = demos_to_begin_with(failed, false).unwrap_err();
        assert!(error.to_string().contains("none of 1"), "{error}");
    }
}
