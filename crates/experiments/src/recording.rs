//! Recordings of a run as MCAP, to open in [Foxglove](https://foxglove.dev).
//!
//! A recording takes the messages that a page is shown and writes them under Foxglove's well-known schemas, as JSON:
//!
//! | topic | schema | from |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransforms` | [`State`]: one frame per body, and `base_link`, all under `map` |
//! | `/scene` | `foxglove.SceneUpdate` | [`Scene`]: the bodies' shapes, each fixed to its body's frame |
//! | `/map` | `foxglove.Grid` | [`OccupancyMap`] |
//! | `/aosm` | `foxglove.SceneUpdate` | [`Aosm`]: names of objects, poses of navigation regions |
//! | `/path` | `foxglove.SceneUpdate` | [`BasePath`] |
//! | `/scan` | `foxglove.LaserScan` | [`LaserScan`], by [`Recording::scan`] |
//! | `/log` | `foxglove.Log` | [`Event`] |
//! | `/plan`, `/status`, `/done` | ours | [`Plan`], [`Status`], [`Done`] as they are on the wire |
//!
//! A state names the bodies that moved since the last, and once in a chunk all of them.
//!
//! Messages are gathered in chunks, and a chunk goes to the disk whole, at least once in a second of the robot's time.
//! A recording cut short by a crash or a full disk is therefore readable up to its last chunk; `mcap recover` gives it
//! an index again.
//!
//! Frame `map` is the world of the wire (z up, metres), and times are those of the robot's clock after
//! [`Recording::create`]'s start.

mod base64;
mod foxglove;
mod schemas;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use factotum_geometry::frames::pose_from_planar;
use factotum_geometry::sensing::LaserScan;
use factotum_protocol::{
    Aosm, BasePath, Done, Event, EventLevel, OccupancyMap, Plan, Scene, SceneSource, ServerMessage,
    State, Status,
};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;
use thiserror::Error;

use crate::storage::StorageError;
use crate::utc::UtcTime;

const NANOS_PER_SEC: f64 = 1e9;

/// A chunk is written once it spans this much of the robot's time: the most that a crash can lose.
const CHUNK_NANOS_MAX: u64 = 1_000_000_000;

/// Name of the frame that all others hang from.
pub const ROOT_FRAME: &str = "map";

/// A recording that cannot go on.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// Its file could not be written.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The format did not take a message.
    #[error("cannot record into `{}`", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// Why.
        source: McapError,
    },
    /// A message could not be put into JSON.
    #[error("cannot put a message for `{topic}` into JSON")]
    Json {
        /// The topic it was for.
        topic: &'static str,
        /// Why.
        source: serde_json::Error,
    },
    /// The map's runs do not fill it.
    #[error("cannot record the map")]
    Map(#[from] factotum_protocol::MapError),
}

/// A recording under way. Call [`Recording::finish`] at its end, for the index that makes it quick to open.
pub struct Recording {
    file: PathBuf,
    writer: Writer<NoSeek<BufWriter<File>>>,
    channels: Vec<(Topic, u16)>,
    start_nanos: u64,
    frames: foxglove::Frames,
    bodies_shown: BTreeMap<SceneSource, Vec<String>>,
    /// Whether the next state is to name every frame: once a chunk, for whoever begins to read there.
    is_all_due: bool,
    chunk_begun_nanos: Option<u64>,
    n_messages: u32,
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recording")
            .field("file", &self.file)
            .field("n_messages", &self.n_messages)
            .finish()
    }
}

/// What a recording holds, by topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    Tf,
    Scene,
    Map,
    Aosm,
    Path,
    Scan,
    Log,
    Plan,
    Status,
    Done,
}

impl Topic {
    const ALL: [Self; 10] = [
        Self::Tf,
        Self::Scene,
        Self::Map,
        Self::Aosm,
        Self::Path,
        Self::Scan,
        Self::Log,
        Self::Plan,
        Self::Status,
        Self::Done,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Tf => "/tf",
            Self::Scene => "/scene",
            Self::Map => "/map",
            Self::Aosm => "/aosm",
            Self::Path => "/path",
            Self::Scan => "/scan",
            Self::Log => "/log",
            Self::Plan => "/plan",
            Self::Status => "/status",
            Self::Done => "/done",
        }
    }

    fn schema_name(self) -> &'static str {
        match self {
            Self::Tf => "foxglove.FrameTransforms",
            Self::Scene | Self::Aosm | Self::Path => "foxglove.SceneUpdate",
            Self::Map => "foxglove.Grid",
            Self::Scan => "foxglove.LaserScan",
            Self::Log => "foxglove.Log",
            Self::Plan => "factotum.Plan",
            Self::Status => "factotum.Status",
            Self::Done => "factotum.Done",
        }
    }
}

impl Recording {
    /// Begins a recording at `start`, which is zero on the robot's clock.
    ///
    /// # Errors
    /// [`RecordingError`] when the file cannot be made.
    pub fn create(file: &Path, start: UtcTime) -> Result<Self, RecordingError> {
        let opened = File::create(file).map_err(|error| StorageError::writing(file, error))?;
        // Without seeking, a chunk is put together in memory and written whole.
        let options = WriteOptions::new()
            .compression(None)
            .profile("")
            .library("factotum")
            .disable_seeking(true);
        let mut writer = options
            .create(NoSeek::new(BufWriter::new(opened)))
            .map_err(|error| failed(file, error))?;
        let mut channels = Vec::with_capacity(Topic::ALL.len());
        for topic in Topic::ALL {
            let name = topic.schema_name();
            let schema = schemas::of(name).to_string();
            let channel = writer
                .add_schema(name, "jsonschema", schema.as_bytes())
                .and_then(|schema| {
                    writer.add_channel(schema, topic.name(), "json", &BTreeMap::new())
                })
                .map_err(|error| failed(file, error))?;
            channels.push((topic, channel));
        }
        let mut this = Self {
            file: file.to_path_buf(),
            writer,
            channels,
            start_nanos: start.unix_secs().saturating_mul(1_000_000_000),
            frames: foxglove::Frames::default(),
            bodies_shown: BTreeMap::new(),
            is_all_due: true,
            chunk_begun_nanos: None,
            n_messages: 0,
        };
        this.flush()?;
        Ok(this)
    }

    /// Records a message as it goes to the page, at a time of the robot's clock in seconds.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be written.
    pub fn record(
        &mut self,
        time_secs: f64,
        message: &ServerMessage,
    ) -> Result<(), RecordingError> {
        match message {
            // The page's greeting, whose commands count, what is learned elsewhere, and what is taught when no robot runs,
            // say nothing of the run.
            ServerMessage::Hello(_)
            | ServerMessage::Control(_)
            | ServerMessage::Trainings(_)
            | ServerMessage::Teaching(_)
            | ServerMessage::EditAnswer(_) => Ok(()),
            ServerMessage::Scene(scene) => self.scene(time_secs, scene),
            ServerMessage::State(state) => self.state(state),
            ServerMessage::Map(map) => self.map(time_secs, map),
            ServerMessage::Aosm(aosm) => self.aosm(time_secs, aosm),
            ServerMessage::Plan(plan) => self.plan(time_secs, plan),
            ServerMessage::BasePath(path) => self.base_path(time_secs, path),
            ServerMessage::Status(status) => self.status(time_secs, status),
            ServerMessage::Event(event) => self.event(event),
            ServerMessage::Done(done) => self.done(time_secs, done),
        }
    }

    /// Records a sweep of the lidar. A ray without a return has range 0, since JSON knows no infinity.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be written.
    pub fn scan(&mut self, time_secs: f64, scan: &LaserScan) -> Result<(), RecordingError> {
        let time = self.time(time_secs);
        let base_from_lidar = pose_from_planar(&scan.base_from_lidar, 0.0);
        self.write(
            Topic::Scan,
            time,
            &foxglove::LaserScan::new(time.into(), &base_from_lidar, scan),
        )
    }

    /// Writes what has been gathered to the disk.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.chunk_begun_nanos = None;
        self.is_all_due = true;
        self.writer
            .flush()
            .map_err(|error| failed(&self.file, error))
    }

    /// Writes the rest and the index.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be written; what was flushed before is kept.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.writer
            .finish()
            .map_err(|error| failed(&self.file, error))?;
        let written = self
            .writer
            .into_inner()
            .into_inner()
            .into_inner()
            .map_err(std::io::IntoInnerError::into_error);
        let synced = written.and_then(|file| file.sync_all());
        synced.map_err(|error| StorageError::writing(&self.file, error).into())
    }

    fn scene(&mut self, time_secs: f64, scene: &Scene) -> Result<(), RecordingError> {
        let time = self.time(time_secs);
        for body in &scene.bodies {
            self.frames.place(time.into(), &body.name, &body.pose);
        }
        let transforms = self.frames.all(time.into());
        self.write(Topic::Tf, time, &foxglove::FrameTransforms { transforms })?;
        let names = scene.bodies.iter().map(|body| body.name.clone()).collect();
        let shown = self
            .bodies_shown
            .insert(scene.source, names)
            .unwrap_or_default();
        let update = foxglove::SceneUpdate::of_scene(time.into(), scene, &shown);
        self.write(Topic::Scene, time, &update)
    }

    fn state(&mut self, state: &State) -> Result<(), RecordingError> {
        let time = self.time(state.time_secs);
        let moved = self.frames.advance(time.into(), state);
        let transforms = if std::mem::take(&mut self.is_all_due) {
            self.frames.all(time.into())
        } else {
            moved
        };
        self.write(Topic::Tf, time, &foxglove::FrameTransforms { transforms })
    }

    fn map(&mut self, time_secs: f64, map: &OccupancyMap) -> Result<(), RecordingError> {
        let time = self.time(time_secs);
        self.write(
            Topic::Map,
            time,
            &foxglove::Grid::new(time.into(), map, &map.cells()?),
        )
    }

    fn aosm(&mut self, time_secs: f64, aosm: &Aosm) -> Result<(), RecordingError> {
        let time = self.time(time_secs);
        self.write(
            Topic::Aosm,
            time,
            &foxglove::SceneUpdate::of_aosm(time.into(), aosm),
        )
    }

    fn base_path(&mut self, time_secs: f64, path: &BasePath) -> Result<(), RecordingError> {
        let time = self.time(time_secs);
        self.write(
            Topic::Path,
            time,
            &foxglove::SceneUpdate::of_path(time.into(), path),
        )
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordingError> {
        let time = self.time(event.time_secs);
        let level = match event.level {
            EventLevel::Info => foxglove::LogLevel::Info,
            EventLevel::Warning => foxglove::LogLevel::Warning,
            EventLevel::Error => foxglove::LogLevel::Error,
        };
        self.write(
            Topic::Log,
            time,
            &foxglove::Log::new(time.into(), level, &event.text),
        )
    }

    fn plan(&mut self, time_secs: f64, plan: &Plan) -> Result<(), RecordingError> {
        self.write(Topic::Plan, self.time(time_secs), plan)
    }

    fn status(&mut self, time_secs: f64, status: &Status) -> Result<(), RecordingError> {
        self.write(Topic::Status, self.time(time_secs), status)
    }

    fn done(&mut self, time_secs: f64, done: &Done) -> Result<(), RecordingError> {
        self.write(Topic::Done, self.time(time_secs), done)
    }

    fn time(&self, time_secs: f64) -> Time {
        // A negative or undefined time becomes the start (`as` saturates).
        Time {
            unix_nanos: self
                .start_nanos
                .saturating_add((time_secs * NANOS_PER_SEC).round() as u64),
        }
    }

    fn write(
        &mut self,
        topic: Topic,
        time: Time,
        message: &impl Serialize,
    ) -> Result<(), RecordingError> {
        let data = serde_json::to_vec(message).map_err(|source| RecordingError::Json {
            topic: topic.name(),
            source,
        })?;
        // Every topic has its channel from the start.
        let Some(&(_, channel_id)) = self.channels.iter().find(|(other, _)| *other == topic) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id,
            sequence: self.n_messages,
            log_time: time.unix_nanos,
            publish_time: time.unix_nanos,
        };
        self.writer
            .write_to_known_channel(&header, &data)
            .map_err(|error| failed(&self.file, error))?;
        self.n_messages = self.n_messages.wrapping_add(1);
        let begun = *self.chunk_begun_nanos.get_or_insert(time.unix_nanos);
        if time.unix_nanos.saturating_sub(begun) >= CHUNK_NANOS_MAX {
            self.flush()?;
        }
        Ok(())
    }
}

/// An instant of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Time {
    unix_nanos: u64,
}

impl From<Time> for foxglove::Timestamp {
    fn from(time: Time) -> Self {
        Self {
            sec: time.unix_nanos / 1_000_000_000,
            nsec: (time.unix_nanos % 1_000_000_000) as u32,
        }
    }
}

fn failed(file: &Path, error: McapError) -> RecordingError {
    match error {
        McapError::Io(error) => StorageError::writing(file, error).into(),
        source => RecordingError::Format {
            file: file.to_path_buf(),
            source,
        },
    }
}

#[cfg(test)]
mod tests;
