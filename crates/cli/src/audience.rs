//! Whoever follows a run: the page, the recording, the log of events, and the report that is written at its end.
//!
//! All of them are told the same, once, here. Nothing that goes wrong in telling stops the robot: a recording or a log
//! that cannot go on is given up, and [`Audience::take_troubles`] says so at the end.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use factotum_experiments::recording::Recording;
use factotum_experiments::report::Timing;
use factotum_experiments::run_folder::RunFolder;
use factotum_experiments::storage;
use factotum_experiments::utc::UtcTime;
use factotum_geometry::sensing::LaserScan;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_studio::StudioHandle;

/// Name of the log of events in a run folder: a JSON document a line.
const EVENTS_NAME: &str = "events.jsonl";
/// Robot seconds between two recorded states.
const RECORDED_STATE_SECS: f64 = 0.1;
/// Robot seconds between two recorded scans.
const RECORDED_SCAN_SECS: f64 = 0.5;
/// The way driven gets a new point after so many metres.
const WAY_STEP_M: f64 = 0.05;

/// The followers of a run; clones are the same followers.
#[derive(Clone)]
pub(crate) struct Audience {
    studio: Option<Arc<StudioHandle>>,
    inner: Arc<Mutex<Inner>>,
}

/// What has been told so far, as far as the report needs it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Told {
    /// The newest map.
    pub(crate) map: Option<wire::OccupancyMap>,
    /// The newest AOSM.
    pub(crate) aosm: wire::Aosm,
    /// The newest plan.
    pub(crate) plan: wire::Plan,
    /// Everything that happened.
    pub(crate) events: Vec<wire::Event>,
    /// Where the base was, in the world.
    pub(crate) way_driven: Vec<[f64; 2]>,
    /// Robot time by activity.
    pub(crate) timings: Vec<Timing>,
}

struct Inner {
    recording: Option<Recording>,
    events_file: Option<PathBuf>,
    troubles: Vec<anyhow::Error>,
    time_secs: f64,
    state_recorded_secs: f64,
    scan_recorded_secs: f64,
    status: wire::Status,
    activity_began_secs: f64,
    /// Plans made for this goal.
    n_plans: u32,
    /// Plans made anew in this job.
    n_replans: u32,
    told: Told,
}

impl Audience {
    /// Followers of a run that begins, with a page or without, or goes on after what was `told` before the robot's clock
    /// showed `time_secs`. A recording that cannot be begun is a trouble, not an error.
    pub(crate) fn new(
        studio: Option<Arc<StudioHandle>>,
        run_folder: Option<&RunFolder>,
        started: UtcTime,
        told: Told,
        time_secs: f64,
    ) -> Self {
        let mut troubles = Vec::new();
        let recording = run_folder.and_then(|folder| {
            Recording::create(&folder.next_recording(), started)
                .map_err(|error| troubles.push(error.into()))
                .ok()
        });
        let events_file = run_folder.map(|folder| folder.file(EVENTS_NAME));
        if let Some(Err(error)) = events_file.as_deref().map(storage::keep_whole_lines) {
            troubles.push(error.into());
        }
        let inner = Inner {
            recording,
            events_file,
            troubles,
            time_secs,
            state_recorded_secs: f64::NEG_INFINITY,
            scan_recorded_secs: f64::NEG_INFINITY,
            status: wire::Status {
                goal: String::new(),
                activity: wire::Activity::Starting,
                paused: false,
                takes_driving: false,
            },
            activity_began_secs: time_secs,
            n_plans: 0,
            n_replans: told.plan.replans,
            told,
        };
        Self {
            studio,
            inner: Arc::new(Mutex::new(inner)),
        }
    }

    /// The page, if there is one.
    pub(crate) fn studio(&self) -> Option<&StudioHandle> {
        self.studio.as_deref()
    }

    /// Tells everybody.
    pub(crate) fn tell(&self, message: ServerMessage) {
        self.lock().hear(&message);
        if let Some(studio) = &self.studio {
            studio.publish(message);
        }
    }

    /// Tells of something that neither robot nor home said.
    pub(crate) fn note(&self, text: String) {
        self.tell(ServerMessage::Event(wire::Event {
            level: wire::EventLevel::Info,
            text,
            time_secs: self.time_secs(),
        }));
    }

    /// Tells of a sweep of the lidar, which only the recording keeps.
    pub(crate) fn tell_scan(&self, time_secs: f64, scan: &LaserScan) {
        let mut inner = self.lock();
        if time_secs - inner.scan_recorded_secs >= RECORDED_SCAN_SECS {
            inner.scan_recorded_secs = time_secs;
            inner.record(|recording| recording.scan(time_secs, scan));
        }
    }

    /// Tells what the robot does things for now.
    pub(crate) fn set_goal(&self, goal: &str) {
        self.lock().n_plans = 0;
        let mut status = self.status();
        goal.clone_into(&mut status.goal);
        self.tell_status(status);
    }

    /// Tells what the robot is at now.
    pub(crate) fn set_activity(&self, activity: wire::Activity) {
        self.tell_status(wire::Status {
            activity,
            ..self.status()
        });
    }

    /// Tells whether the job waits.
    pub(crate) fn set_paused(&self, paused: bool) {
        self.tell_status(wire::Status {
            paused,
            ..self.status()
        });
    }

    /// Tells whether the robot is driven from the page.
    pub(crate) fn set_takes_driving(&self, takes_driving: bool) {
        self.tell_status(wire::Status {
            takes_driving,
            ..self.status()
        });
    }

    /// Counts a new plan: each but the first of a goal was made anew.
    pub(crate) fn count_plan(&self) {
        let mut inner = self.lock();
        inner.n_replans += u32::from(inner.n_plans > 0);
        inner.n_plans += 1;
    }

    /// How often was planned anew.
    pub(crate) fn n_replans(&self) -> u32 {
        self.lock().n_replans
    }

    fn status(&self) -> wire::Status {
        self.lock().status.clone()
    }

    fn tell_status(&self, status: wire::Status) {
        if self.status() != status {
            self.tell(ServerMessage::Status(status));
        }
    }

    /// The robot's clock as last heard, seconds.
    pub(crate) fn time_secs(&self) -> f64 {
        self.lock().time_secs
    }

    /// What has been told so far, what the robot is at included.
    pub(crate) fn told(&self) -> Told {
        let inner = self.lock();
        let mut told = inner.told.clone();
        let secs = inner.time_secs - inner.activity_began_secs;
        told.spend(words_of(inner.status.activity), secs);
        told
    }

    /// Ends the recording.
    pub(crate) fn finish_recording(&self) {
        let mut inner = self.lock();
        if let Some(Err(error)) = inner.recording.take().map(Recording::finish) {
            inner.troubles.push(error.into());
        }
    }

    /// Something could not be kept; the run goes on. The same trouble over and over is told once.
    pub(crate) fn add_trouble(&self, trouble: anyhow::Error) {
        let troubles = &mut self.lock().troubles;
        let text = format!("{trouble:#}");
        if troubles.iter().all(|known| format!("{known:#}") != text) {
            troubles.push(trouble);
        }
    }

    /// What could not be kept, and why.
    pub(crate) fn take_troubles(&self) -> Vec<anyhow::Error> {
        std::mem::take(&mut self.lock().troubles)
    }

    /// A follower that panicked has told its own; what is kept stays whole.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn hear(&mut self, message: &ServerMessage) {
        let mut is_recorded = true;
        match message {
            ServerMessage::State(state) => {
                self.time_secs = state.time_secs;
                is_recorded = state.time_secs - self.state_recorded_secs >= RECORDED_STATE_SECS;
                if is_recorded {
                    self.state_recorded_secs = state.time_secs;
                }
                self.told.walk_to([state.base.x, state.base.y]);
            }
            ServerMessage::Map(map) => self.told.map = Some(map.clone()),
            ServerMessage::Aosm(aosm) => self.told.aosm.clone_from(aosm),
            ServerMessage::Plan(plan) => self.told.plan.clone_from(plan),
            ServerMessage::Event(event) => {
                self.told.events.push(event.clone());
                self.log(event);
            }
            ServerMessage::Status(status) => {
                if status.activity != self.status.activity {
                    let secs = self.time_secs - self.activity_began_secs;
                    self.told.spend(words_of(self.status.activity), secs);
                    self.activity_began_secs = self.time_secs;
                }
                self.status.clone_from(status);
            }
            ServerMessage::Hello(_)
            | ServerMessage::Control(_)
            | ServerMessage::Scene(_)
            | ServerMessage::BasePath(_)
            | ServerMessage::Done(_)
            | ServerMessage::Trainings(_)
            | ServerMessage::Teaching(_)
            | ServerMessage::EditAnswer(_) => {}
        }
        if is_recorded {
            let time_secs = self.time_secs;
            self.record(|recording| recording.record(time_secs, message));
        }
    }

    fn log(&mut self, event: &wire::Event) {
        let Some(file) = &self.events_file else {
            return;
        };
        let line = serde_json::to_string(event).map_err(anyhow::Error::from);
        if let Err(error) = line.and_then(|line| Ok(storage::append_line(file, &line)?)) {
            self.events_file = None;
            self.troubles.push(error);
        }
    }

    fn record<E: Into<anyhow::Error>>(
        &mut self,
        write: impl FnOnce(&mut Recording) -> Result<(), E>,
    ) {
        if let Some(recording) = &mut self.recording
            && let Err(error) = write(recording)
        {
            self.recording = None;
            self.troubles.push(error.into());
        }
    }
}

impl Told {
    fn walk_to(&mut self, [x, y]: [f64; 2]) {
        let is_far = self
            .way_driven
            .last()
            .is_none_or(|[x0, y0]| (x - x0).hypot(y - y0) >= WAY_STEP_M);
        if is_far {
            self.way_driven.push([x, y]);
        }
    }

    fn spend(&mut self, name: &str, secs: f64) {
        match self.timings.iter_mut().find(|timing| timing.name == name) {
            Some(timing) => timing.secs += secs,
            None if secs > 0.0 => self.timings.push(Timing {
                name: name.to_owned(),
                secs,
            }),
            None => {}
        }
    }
}

fn words_of(activity: wire::Activity) -> &'static str {
    match activity {
        wire::Activity::Starting => "starting",
        wire::Activity::Exploring => "exploring",
        wire::Activity::Planning => "planning",
        wire::Activity::Acting => "acting",
        wire::Activity::Stopped => "stopped",
        wire::Activity::Finished => "finished",
    }
}
