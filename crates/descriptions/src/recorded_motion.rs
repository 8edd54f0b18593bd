//! A motion of an arm at an object, as it was recorded: a demonstration for motor skills.
//!
//! The file is JSON Lines. The first line says what it is, each later one is a sample, `step_secs` apart:
//!
//! ```text
//! {"format":1,"task":"t-ball","robot":"iiwa7_bat","joints":["joint_1","joint_2"],"step_secs":0.05,"made_by":"keyboard","success":true}
//! {"secs":0.0,"positions":[-0.9,-0.3],"object":0.0}
//! {"secs":0.05,"positions":[-0.88,-0.3],"object":0.0}
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `task`, `robot` | names of the task and of the robot |
//! | `joints` | the arm's joints, in the order of `positions` |
//! | `step_secs` | distance of the samples, s; two may be up to one and a half of it apart |
//! | `made_by` | how it was made, in words |
//! | `success` | whether the object ended where the task wants it |
//! | `secs` | time of a sample, s |
//! | `positions` | positions of the joints, rad or m |
//! | `object` | position of the object's joint, rad or m |

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Version of the format.
const FORMAT: u32 = 1;

/// Samples of the shortest motion.
const N_SAMPLES_MIN: usize = 3;

/// Two samples farther apart than so many steps have a gap between them.
const GAP_STEPS: f64 = 1.5;

/// What is said of a motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionHead {
    /// Version of the format.
    pub format: u32,
    /// Name of the task.
    pub task: String,
    /// Name of the robot.
    pub robot: String,
    /// The arm's joints.
    pub joints: Vec<String>,
    /// Distance of the samples, seconds.
    pub step_secs: f64,
    /// How it was made, in words.
    pub made_by: String,
    /// Whether the object ended where the task wants it.
    pub success: bool,
}

impl MotionHead {
    /// Of this version.
    pub fn new(task: &str, robot: &str, joints: &[String], step_secs: f64, made_by: &str) -> Self {
        Self {
            format: FORMAT,
            task: task.to_owned(),
            robot: robot.to_owned(),
            joints: joints.to_vec(),
            step_secs,
            made_by: made_by.to_owned(),
            success: false,
        }
    }
}

/// A moment of a motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionSample {
    /// Time, seconds.
    pub secs: f64,
    /// Positions of the joints, rad or m.
    pub positions: Vec<f64>,
    /// Position of the object's joint, rad or m.
    pub object: f64,
}

/// A motion whose samples go together.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedMotion {
    head: MotionHead,
    samples: Vec<MotionSample>,
}

/// Why something is no recorded motion.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MotionFileError {
    /// The file cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// What it says is wrong.
    #[error("`{}`: {problem}", path.display())]
    Bad {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: MotionProblem,
    },
}

/// What can be wrong with a motion. Lines count from 1, the head's.
#[derive(Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionProblem {
    /// A line is not JSON of the wanted form; what is not a number, such as NaN, ends here, too.
    #[error("line {line}: {message}")]
    Syntax {
        /// The line.
        line: usize,
        /// What was found and wanted.
        message: String,
    },
    /// A later program wrote it.
    #[error("format {found}, expected {FORMAT}")]
    Format {
        /// Its format.
        found: u32,
    },
    /// The step is no time.
    #[error("`step_secs` is {found}, expected a finite number above 0")]
    Step {
        /// The step.
        found: f64,
    },
    /// Too few samples.
    #[error("{found} samples, expected at least {N_SAMPLES_MIN}")]
    TooShort {
        /// Those found.
        found: usize,
    },
    /// A sample of another number of joints.
    #[error("line {line}: {found} positions, expected {wanted}, one for each of `joints`")]
    Joints {
        /// The line.
        line: usize,
        /// Those found.
        found: usize,
        /// Joints of the head.
        wanted: usize,
    },
    /// A number is not finite.
    #[error("line {line}: a number is not finite")]
    NotFinite {
        /// The line.
        line: usize,
    },
    /// A stamp that is not after the one before.
    #[error("line {line}: {secs} s comes after {before} s; stamps must rise")]
    Stamp {
        /// The line.
        line: usize,
        /// Its stamp, seconds.
        secs: f64,
        /// The stamp before, seconds.
        before: f64,
    },
    /// Samples are missing.
    #[error(
        "line {line}: a gap from {before} s to {secs} s, where samples are {step_secs} s apart"
    )]
    Gap {
        /// The line.
        line: usize,
        /// The stamp before, seconds.
        before: f64,
        /// Its stamp, seconds.
        secs: f64,
        /// What the head says, seconds.
        step_secs: f64,
    },
}

impl RecordedMotion {
    /// Checks and keeps a motion.
    ///
    /// # Errors
    /// [`MotionProblem`]: too few samples, another number of joints, a number that is not finite, a stamp that does not rise,
    /// a gap.
    pub fn new(head: MotionHead, samples: Vec<MotionSample>) -> Result<Self, MotionProblem> {
        if head.format != FORMAT {
            return Err(MotionProblem::Format { found: head.format });
        }
        if !(head.step_secs > 0.0 && head.step_secs.is_finite()) {
            return Err(MotionProblem::Step {
                found: head.step_secs,
            });
        }
        if samples.len() < N_SAMPLES_MIN {
            return Err(MotionProblem::TooShort {
                found: samples.len(),
            });
        }
        let mut last = None;
        for (i, sample) in samples.iter().enumerate() {
            let line = i + 2;
            let (found, wanted) = (sample.positions.len(), head.joints.len());
            if found != wanted {
                return Err(MotionProblem::Joints {
                    line,
                    found,
                    wanted,
                });
            }
            let MotionSample { secs, object, .. } = *sample;
            let mut numbers = sample.positions.iter().chain([&secs, &object]);
            if !numbers.all(|number| number.is_finite()) {
                return Err(MotionProblem::NotFinite { line });
            }
            if let Some(before) = last.replace(secs) {
                if secs <= before {
                    return Err(MotionProblem::Stamp { line, secs, before });
                }
                if secs - before > GAP_STEPS * head.step_secs {
                    return Err(MotionProblem::Gap {
                        line,
                        before,
                        secs,
                        step_secs: head.step_secs,
                    });
                }
            }
        }
        Ok(Self { head, samples })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`MotionProblem`] as in [`Self::new`], or for a line that is not as it should be.
    pub fn parse(text: &str) -> Result<Self, MotionProblem> {
        fn read<T: serde::de::DeserializeOwned>(i: usize, line: &str) -> Result<T, MotionProblem> {
            serde_json::from_str(line).map_err(|error| MotionProblem::Syntax {
                line: i + 1,
                message: error.to_string(),
            })
        }
        let mut lines = text.lines().enumerate();
        let (i, head) = lines.next().unwrap_or((0, ""));
        let head = read(i, head)?;
        let samples = lines
            .map(|(i, line)| read(i, line))
            .collect::<Result<_, _>>()?;
        Self::new(head, samples)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`MotionFileError`] if it cannot be read, or is no motion.
    pub fn load(file: &Path) -> Result<Self, MotionFileError> {
        let text = std::fs::read_to_string(file).map_err(|source| MotionFileError::Io {
            path: file.to_owned(),
            source,
        })?;
        Self::parse(&text).map_err(|problem| MotionFileError::Bad {
            path: file.to_owned(),
            problem,
        })
    }

    /// The text of its file.
    pub fn to_text(&self) -> String {
        let head = serde_json::to_string(&self.head);
        let samples = self.samples.iter().map(serde_json::to_string);
        let mut text = String::new();
        // Finite numbers and text are always JSON.
        for line in std::iter::once(head).chain(samples).flatten() {
            text.push_str(&line);
            text.push('\n');
        }
        text
    }

    /// What is said of it.
    pub fn head(&self) -> &MotionHead {
        &self.head
    }

    /// Its samples, at least three.
    pub fn samples(&self) -> &[MotionSample] {
        &self.samples
    }

    /// From the first sample to the last, seconds.
    pub fn duration_secs(&self) -> f64 {
        let secs = |sample: Option<&MotionSample>| sample.map_or(0.0, |sample| sample.secs);
        secs(self.samples.last()) - secs(self.samples.first())
    }

    /// The moment at a time after the first sample, on the line between its neighbours; held beyond the ends.
    pub fn at(&self, secs: f64) -> MotionSample {
        let time = self.samples.first().map_or(0.0, |first| first.secs) + secs;
        let after = self
            .samples
            .partition_point(|sample| sample.secs <= time)
            .clamp(1, self.samples.len() - 1);
        let (a, b) = (&self.samples[after - 1], &self.samples[after]);
        let share = ((time - a.secs) / (b.secs - a.secs)).clamp(0.0, 1.0);
        let between = |a: f64, b: f64| a + (b - a) * share;
        MotionSample {
            secs: time,
            positions: a
                .positions
                .iter()
                .zip(&b.positions)
                .map(|(a, b)| between(*a, *b))
                .collect(),
            object: between(a.object, b.object),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion() -> RecordedMotion {
        let joints = ["a", "b"].map(str::to_owned);
        let head = MotionHead::new("door", "arm", &joints, 0.1, "a test");
        let sample = |k: usize| MotionSample {
            secs: 2.0 + 0.1 * k as f64,
            positions: vec![0.1 / 3.0 * k as f64, -1.0],
            object: k as f64,
        };
        RecordedMotion::new(head, (0..4).map(sample).collect()).unwrap()
    }

    #[test]
    fn what_is_written_is_read_and_between_samples_there_is_a_line() {
        let motion = motion();
        assert_eq!(RecordedMotion::parse(&motion.to_text()).unwrap(), motion);
        assert!((motion.duration_secs() - 0.3).abs() < 1e-12);
        let moment = motion.at(0.15);
        assert!((moment.positions[0] - 0.05).abs() < 1e-12, "{moment:?}");
        assert!((moment.object - 1.5).abs() < 1e-9);
        assert_eq!(motion.at(-1.0).object, 0.0);
        assert_eq!(motion.at(9.0).object, 3.0);
    }

    /// One line replaced, and what is said of it.
    #[track_caller]
    fn check(line: usize, from: &str, to: &str, wanted: &str) {
        let text = motion().to_text();
        let lines = text.lines().enumerate().map(|(i, text)| {
            let replaced = text.replace(from, to);
            if i + 1 == line {
                replaced
            } else {
                text.to_owned()
            }
        });
        let text: Vec<String> = lines.collect();
        let error = RecordedMotion::parse(&text.join("\n"))
            .unwrap_err()
            .to_string();
        assert!(error.contains(wanted), "{error}");
    }

    #[test]
    fn what_is_wrong_is_said_by_its_line() {
        check(3, "-1.0", "NaN", "line 3: ");
        check(3, "-1.0", "null", "line 3: ");
        check(3, "-1.0", "1e999", "line 3: ");
        check(3, "-1.0", "-1.0,2.0", "line 3: 3 positions, expected 2");
        check(3, "2.1", "2.0", "line 3: 2 s comes after 2 s");
        check(3, "2.1", "1.9", "line 3: 1.9 s comes after 2 s");
        check(5, "2.3", "3.3", "line 5: a gap from 2.2 s to 3.3 s");
        check(1, "\"format\":1", "\"format\":7", "format 7, expected 1");
        check(1, "0.1", "0.0", "`step_secs` is 0");
        check(1, "made_by", "maker", "line 1: ");
        let two: Vec<String> = motion()
            .to_text()
            .lines()
            .take(3)
            .map(str::to_owned)
            .collect();
        let error = RecordedMotion::parse(&two.join("\n")).unwrap_err();
        assert_eq!(error, MotionProblem::TooShort { found: 2 });
        assert!(RecordedMotion::parse("").is_err());
        let mut samples = motion().samples().to_vec();
        samples[2].object = f64::NAN;
        let error = RecordedMotion::new(motion().head().clone(), samples).unwrap_err();
        assert_eq!(error, MotionProblem::NotFinite { line: 4 });
    }
}
