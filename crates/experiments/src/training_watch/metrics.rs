//! Metrics that are read while another process appends to them.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use factotum_skills::cip::training::EvaluationRecord;

use crate::skill_folder::MetricsLine;
use crate::storage::StorageError;

/// A file longer than this, in bytes, is not read: some 500,000 episodes.
const LENGTH_MAX: u64 = 64 << 20;

/// Episodes that the recent success rate is of.
const N_RECENT: usize = 20;

/// Metrics that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// The file.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// A line is no line of metrics.
    #[error("line {line} of `{file}` is neither of an episode nor of an evaluation", file = file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// A line goes back.
    #[error("line {line} of `{file}` is of episode {found}, expected one from {expected} on", file = file.display())]
    Order {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// Its episode.
        found: u64,
        /// The lowest that it could be of.
        expected: u64,
    },
    /// There is more than anybody reads.
    #[error("`{file}` has {found} bytes, expected at most {LENGTH_MAX}", file = file.display())]
    Length {
        /// The file.
        file: PathBuf,
        /// Its length in bytes.
        found: u64,
    },
}

/// What the whole lines of a metrics file say, as far as they are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Metrics {
    /// Bytes that are read: the end of a line.
    offset: u64,
    n_lines: usize,
    pub(super) n_episodes: u64,
    pub(super) n_env_steps: u64,
    pub(super) n_violations: u64,
    recent: VecDeque<bool>,
    pub(super) evaluations: Vec<EvaluationRecord>,
}

impl Metrics {
    /// Reads the lines that are new, and everything anew where the file does not continue what was read: a run that is
    /// resumed drops the lines beyond its checkpoint. Half a line at the end is left for later. No file is no lines.
    ///
    /// # Errors
    /// [`MetricsError`]; the next call begins anew.
    pub(super) fn follow(&mut self, file: &Path) -> Result<(), MetricsError> {
        let has_begun = self.offset > 0;
        let mut read = self.read_on(file);
        if has_begun && read.is_err() {
            *self = Self::default();
            read = self.read_on(file);
        }
        if read.is_err() {
            *self = Self::default();
        }
        read
    }

    /// Share of successes in the last episodes.
    pub(super) fn recent_success_rate(&self) -> Option<f64> {
        let n_successes = self.recent.iter().filter(|success| **success).count();
        (!self.recent.is_empty()).then(|| n_successes as f64 / self.recent.len() as f64)
    }

    fn read_on(&mut self, file: &Path) -> Result<(), MetricsError> {
        let failed = |error| StorageError::reading(file, error);
        let mut opened = match File::open(file) {
            Ok(opened) => opened,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                *self = Self::default();
                return Ok(());
            }
            Err(error) => return Err(failed(error).into()),
        };
        let length = opened.metadata().map_err(failed)?.len();
        if length > LENGTH_MAX {
            return Err(MetricsError::Length {
                file: file.to_path_buf(),
                found: length,
            });
        }
        if length < self.offset {
            *self = Self::default();
        }
        opened.seek(SeekFrom::Start(self.offset)).map_err(failed)?;
        let mut bytes = Vec::new();
        opened
            .take(length - self.offset)
            .read_to_end(&mut bytes)
            .map_err(failed)?;
        for line in bytes.split_inclusive(|&byte| byte == b'\n') {
            if line.ends_with(b"\n") {
                self.add(line, file)?;
            }
        }
        Ok(())
    }

    fn add(&mut self, line: &[u8], file: &Path) -> Result<(), MetricsError> {
        self.offset += line.len() as u64;
        self.n_lines += 1;
        let parsed = serde_json::from_slice(line).map_err(|source| MetricsError::Line {
            file: file.to_path_buf(),
            line: self.n_lines,
            source,
        })?;
        let (found, expected) = match &parsed {
            MetricsLine::Episode(episode) => (episode.episode, self.n_episodes + 1),
            MetricsLine::Evaluation(evaluation) => (evaluation.episode, self.n_episodes),
        };
        if found < expected {
            return Err(MetricsError::Order {
                file: file.to_path_buf(),
                line: self.n_lines,
                found,
                expected,
            });
        }
        match parsed {
            MetricsLine::Evaluation(evaluation) => self.evaluations.push(evaluation),
            MetricsLine::Episode(episode) => {
                self.n_episodes = episode.episode;
                self.n_env_steps = episode.env_steps;
                self.n_violations += u64::from(episode.violation);
                self.recent.push_back(episode.success);
                if self.recent.len() > N_RECENT {
                    self.recent.pop_front();
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write as _;

    use super::super::tests::{episode, evaluation};
    use super::*;

    /// A file of metrics, and what was read of it so far.
    struct Followed {
        _dir: tempfile::TempDir,
        file: PathBuf,
        metrics: Metrics,
    }

    impl Followed {
        fn new() -> Self {
            let dir = tempfile::tempdir().unwrap();
            Self {
                file: dir.path().join("metrics.jsonl"),
                _dir: dir,
                metrics: Metrics::default(),
            }
        }

        fn append(&self, text: &str) {
            let mut file = fs::OpenOptions::new()
                .append(true)
                .create(true)
                .open(&self.file)
                .unwrap();
            file.write_all(text.as_bytes()).unwrap();
        }

        fn follow(&mut self) -> &Metrics {
            self.metrics.follow(&self.file).unwrap();
            &self.metrics
        }

        /// What a reader sees that has seen nothing before.
        fn read_at_once(&self) -> Metrics {
            let mut metrics = Metrics::default();
            metrics.follow(&self.file).unwrap();
            metrics
        }
    }

    #[test]
    fn lines_are_read_as_they_come_and_half_a_line_waits() {
        let mut followed = Followed::new();
        assert_eq!(*followed.follow(), Metrics::default(), "no file yet");
        let line = episode(1, true);
        let (half, rest) = line.split_at(30);
        followed.append(half);
        assert_eq!(followed.follow().n_episodes, 0);
        followed.append(rest);
        assert_eq!(followed.follow().n_episodes, 1);
        followed.append(&(episode(2, false) + &evaluation(2, 0.5)));
        let metrics = followed.follow().clone();
        assert_eq!((metrics.n_episodes, metrics.n_env_steps), (2, 40));
        assert_eq!(metrics.n_violations, 1, "episode 2 has one");
        assert_eq!(metrics.recent_success_rate(), Some(0.5));
        assert_eq!(metrics.evaluations.len(), 1);
        assert_eq!(metrics, followed.read_at_once());
    }

    #[test]
    fn only_what_is_new_is_read() {
        let mut followed = Followed::new();
        followed.append(&(episode(1, true) + &episode(2, true)));
        followed.follow();
        // What was read before is not looked at again: it may be anything of the same length.
        let n_bytes = fs::metadata(&followed.file).unwrap().len() as usize;
        fs::write(&followed.file, vec![b'\n'; n_bytes]).unwrap();
        followed.append(&episode(3, true));
        assert_eq!(followed.follow().n_episodes, 3);
    }

    #[test]
    fn a_file_that_a_resumed_run_made_shorter_is_read_anew() {
        let mut followed = Followed::new();
        let kept = episode(1, false) + &evaluation(1, 0.0);
        followed.append(&(kept.clone() + &episode(2, true) + &episode(3, true)));
        assert_eq!(followed.follow().n_episodes, 3);
        fs::write(&followed.file, &kept).unwrap();
        assert_eq!(followed.follow().n_episodes, 1);
        assert_eq!(followed.metrics, followed.read_at_once());
        fs::remove_file(&followed.file).unwrap();
        assert_eq!(*followed.follow(), Metrics::default());
    }

    #[test]
    fn a_file_that_has_grown_again_since_it_was_cut_is_read_anew() {
        for goes_on in [
            // Goes on in the middle of a line.
            episode(2, false) + &evaluation(2, 1.0) + &episode(3, false) + &evaluation(3, 1.0),
            // Goes on at a line's beginning, with an episode that has been.
            episode(2, false) + &episode(3, false) + &episode(4, false),
        ] {
            let mut followed = Followed::new();
            let kept = episode(1, false);
            followed.append(&(kept.clone() + &episode(2, true) + &episode(3, true)));
            followed.follow();
            let anew = kept + &goes_on;
            fs::write(&followed.file, anew).unwrap();
            followed.follow();
            assert_eq!(followed.metrics, followed.read_at_once());
        }
    }

    #[test]
    fn the_recent_rate_is_of_the_last_twenty() {
        let mut followed = Followed::new();
        for number in 1..=30 {
            followed.append(&episode(number, number > 15));
        }
        assert_eq!(followed.follow().recent_success_rate(), Some(0.75));
    }

    #[test]
    fn what_is_no_metrics_is_named_by_file_and_line_and_may_be_mended() {
        let mut followed = Followed::new();
        for (line, text, said) in [
            (2, "{\"episode\":2}\n".to_owned(), "neither of an episode"),
            (2, "\u{0}\n".to_owned(), "neither of an episode"),
            (2, episode(1, true), "is of episode 1, expected one from 2"),
            (
                2,
                evaluation(0, 0.0),
                "is of episode 0, expected one from 1",
            ),
        ] {
            fs::write(&followed.file, episode(1, true) + &text).unwrap();
            let message = followed.metrics.follow(&followed.file).unwrap_err();
            let message = message.to_string();
            assert!(message.contains(&format!("line {line} of")), "{message}");
            assert!(
                message.contains("metrics.jsonl") && message.contains(said),
                "{message}"
            );
        }
        fs::write(&followed.file, episode(1, true)).unwrap();
        assert_eq!(followed.follow().n_episodes, 1);
    }

    #[test]
    fn a_file_that_is_too_long_is_not_read() {
        let followed = Followed::new();
        let file = File::create(&followed.file).unwrap();
        file.set_len(LENGTH_MAX + 1).unwrap();
        let error = Metrics::default().follow(&followed.file).unwrap_err();
        assert!(matches!(error, MetricsError::Length { .. }), "{error:?}");
    }
}
