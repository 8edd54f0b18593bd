//! What the time of a training run is spent on.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use factotum_skills::cip::environment::{Phase, PhaseWatch};

/// Times the phases of a run.
#[derive(Debug, Clone)]
pub(super) struct Stopwatch {
    laps: Arc<Mutex<Laps>>,
}

#[derive(Debug)]
struct Laps {
    /// `None` before the first episode.
    phase: Option<Phase>,
    since: Instant,
    spent: BTreeMap<Option<Phase>, Duration>,
}

impl Laps {
    fn turn(&mut self, next: Option<Phase>, now: Instant) {
        *self.spent.entry(self.phase).or_default() += now - self.since;
        self.phase = next;
        self.since = now;
    }
}

fn now() -> Instant {
    Instant::now()
}

impl Stopwatch {
    pub(super) fn start() -> Self {
        Self {
            laps: Arc::new(Mutex::new(Laps {
                phase: None,
                since: now(),
                spent: BTreeMap::new(),
            })),
        }
    }

    /// To be told of every phase.
    pub(super) fn watch(&self) -> PhaseWatch {
        let laps = self.laps.clone();
        Box::new(move |phase| {
            laps.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .turn(Some(phase), now());
        })
    }

    /// Seconds by phase; the grasps are what came before the first episode.
    pub(super) fn split_secs(&self) -> BTreeMap<&'static str, f64> {
        let mut laps = self.laps.lock().unwrap_or_else(PoisonError::into_inner);
        let phase = laps.phase;
        laps.turn(phase, now());
        laps.spent
            .iter()
            .map(|(phase, spent)| {
                let name = match phase {
                    None => "grasps",
                    Some(Phase::Reset) => "resets",
                    Some(Phase::Steps) => "physics",
                    Some(Phase::Updates) => "updates",
                    Some(Phase::Evaluation) => "evaluation",
                };
                (name, spent.as_secs_f64())
            })
            .collect()
    }
}
