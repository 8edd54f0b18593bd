//! A snapshot of a run as bytes: what the robot's mind and its watchers need, as JSON, then the surfaces seen, to a
//! tenth of a millimetre or so, then the world, exactly.
//!
//! The map is not in it: the journal of the home has it, and the snapshot names the entry. Lengths are written before
//! the parts, as little-endian `u64`.

use factotum_agent::{Checkpoint, ExecutedStep, RunReport, Stage};
use factotum_experiments::report::Timing;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::frames::quat_from_xyzw;
use factotum_geometry::{Pose, Pose2};
use factotum_protocol as wire;
use factotum_task_planning::operator::GroundAction;
use nalgebra::{Point2, Point3, Translation3, Vector2};
use serde::{Deserialize, Serialize};

use crate::audience::Told;
use crate::wire_view::{planar, pose_of};

/// Format of the JSON.
const FORMAT: u32 = 1;

/// How far a run has come.
#[derive(Debug, Clone, Default)]
pub(crate) struct Progress {
    /// Reports of the chores that are over.
    pub(crate) reports: Vec<RunReport>,
    /// When exploring ended, in robot seconds; nothing while it lasts.
    pub(crate) explore_secs: Option<f64>,
    /// Time it has taken so far, seconds.
    pub(crate) wall_secs: f64,
}

/// Everything a run needs to go on.
#[derive(Debug, Clone)]
pub(crate) struct Snapshot {
    pub(crate) progress: Progress,
    /// Entry of the home's journal after which the home holds the map.
    pub(crate) home_entry: i64,
    pub(crate) world_from_map: Pose2,
    pub(crate) checkpoint: Checkpoint,
    pub(crate) told: Told,
    /// The world, as `worlds` writes it.
    pub(crate) world: Vec<u8>,
}

impl Snapshot {
    /// The snapshot as bytes.
    ///
    /// # Errors
    /// [`serde_json::Error`] for numbers that JSON cannot write.
    pub(crate) fn to_bytes(&self) -> serde_json::Result<Vec<u8>> {
        let mind = serde_json::to_vec(&Mind::of(self))?;
        let seen = self.checkpoint.seen.points();
        let mut bytes = (mind.len() as u64).to_le_bytes().to_vec();
        bytes.extend(mind);
        bytes.extend((seen.len() as u64).to_le_bytes());
        let coordinates = seen.iter().flat_map(|point| [point.x, point.y, point.z]);
        bytes.extend(coordinates.flat_map(|coordinate| (coordinate as f32).to_le_bytes()));
        bytes.extend(&self.world);
        Ok(bytes)
    }

    /// Reads what [`Snapshot::to_bytes`] wrote, or says what is wrong with it.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (mind, rest) = part(bytes, 1, "of JSON")?;
        let (seen, world) = part(rest, 3 * size_of::<f32>(), "of surfaces seen")?;
        let mind: Mind = serde_json::from_slice(mind).map_err(|error| error.to_string())?;
        if mind.format != FORMAT {
            return Err(format!("format {}, expected {FORMAT}", mind.format));
        }
        let (coordinates, _) = seen.as_chunks();
        let coordinates: Vec<f64> = coordinates
            .iter()
            .map(|bytes| f64::from(f32::from_le_bytes(*bytes)))
            .collect();
        let (points, _) = coordinates.as_chunks::<3>();
        let seen = PointCloud::new(points.iter().copied().map(Point3::from).collect());
        mind.into_snapshot(seen, world.to_vec())
    }
}

/// A part of `bytes`, so many times `size` as is written before it, and what follows it.
fn part<'b>(bytes: &'b [u8], size: usize, what: &str) -> Result<(&'b [u8], &'b [u8]), String> {
    let (n, rest) = bytes
        .split_first_chunk()
        .ok_or_else(|| format!("{} bytes, expected at least 8", bytes.len()))?;
    let n = u64::from_le_bytes(*n);
    usize::try_from(n)
        .ok()
        .and_then(|n| rest.split_at_checked(n.checked_mul(size)?))
        .ok_or_else(|| format!("{} bytes {what}, expected {n} times {size}", rest.len()))
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mind {
    format: u32,
    home_entry: i64,
    wall_secs: f64,
    explore_secs: Option<f64>,
    reports: Vec<ReportEntry>,
    world_from_map: wire::PosePlanar,
    map_from_odom: wire::PosePlanar,
    tcp_from_held: Option<wire::Pose>,
    viewed: Vec<[f64; 2]>,
    /// High and low half.
    rng_word_pos: [u64; 2],
    stage: StageEntry,
    report: ReportEntry,
    way_driven: Vec<[f64; 2]>,
    timings: Vec<(String, f64)>,
    plan: wire::Plan,
    events: Vec<wire::Event>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum StageEntry {
    Between,
    Planning,
    Acting { n_steps_done: usize },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReportEntry {
    /// Action, then arguments.
    plan: Vec<(String, Vec<String>)>,
    executed: Vec<ExecutedEntry>,
    n_replans: usize,
    is_believed_done: bool,
    reason: Option<String>,
    robot_secs: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExecutedEntry {
    action: String,
    args: Vec<String>,
    #[serde(default)]
    learned: Option<String>,
    outcome: String,
    is_done: bool,
    attempts: usize,
    robot_secs: f64,
}

impl Mind {
    fn of(snapshot: &Snapshot) -> Self {
        let Snapshot {
            progress,
            checkpoint,
            told,
            ..
        } = snapshot;
        let word_pos = checkpoint.rng_word_pos;
        Self {
            format: FORMAT,
            home_entry: snapshot.home_entry,
            wall_secs: progress.wall_secs,
            explore_secs: progress.explore_secs,
            reports: progress.reports.iter().map(ReportEntry::of).collect(),
            world_from_map: planar(&snapshot.world_from_map),
            map_from_odom: planar(&checkpoint.map_from_odom),
            tcp_from_held: checkpoint.tcp_from_held.as_ref().map(pose_of),
            viewed: checkpoint
                .viewed
                .iter()
                .map(|place| [place.x, place.y])
                .collect(),
            rng_word_pos: [(word_pos >> 64) as u64, word_pos as u64],
            stage: match checkpoint.stage {
                Stage::Between => StageEntry::Between,
                Stage::Planning => StageEntry::Planning,
                Stage::Acting { n_steps_done } => StageEntry::Acting { n_steps_done },
            },
            report: ReportEntry::of(&checkpoint.report),
            way_driven: told.way_driven.clone(),
            timings: told
                .timings
                .iter()
                .map(|timing| (timing.name.clone(), timing.secs))
                .collect(),
            plan: told.plan.clone(),
            events: told.events.clone(),
        }
    }

    fn into_snapshot(self, seen: PointCloud, world: Vec<u8>) -> Result<Snapshot, String> {
        let [high, low] = self.rng_word_pos;
        let timing = |(name, secs)| Timing { name, secs };
        Ok(Snapshot {
            progress: Progress {
                reports: self
                    .reports
                    .into_iter()
                    .map(ReportEntry::into_report)
                    .collect(),
                explore_secs: self.explore_secs,
                wall_secs: self.wall_secs,
            },
            home_entry: self.home_entry,
            world_from_map: pose2(self.world_from_map),
            checkpoint: Checkpoint {
                map_from_odom: pose2(self.map_from_odom),
                tcp_from_held: self.tcp_from_held.map(pose).transpose()?,
                seen,
                viewed: self.viewed.into_iter().map(Point2::from).collect(),
                rng_word_pos: (u128::from(high) << 64) | u128::from(low),
                stage: match self.stage {
                    StageEntry::Between => Stage::Between,
                    StageEntry::Planning => Stage::Planning,
                    StageEntry::Acting { n_steps_done } => Stage::Acting { n_steps_done },
                },
                report: self.report.into_report(),
            },
            told: Told {
                way_driven: self.way_driven,
                timings: self.timings.into_iter().map(timing).collect(),
                plan: self.plan,
                events: self.events,
                ..Told::default()
            },
            world,
        })
    }
}

fn pose(pose: wire::Pose) -> Result<Pose, String> {
    let rotation = quat_from_xyzw(pose.orientation_xyzw).map_err(|error| error.to_string())?;
    Ok(Pose::from_parts(
        Translation3::from(pose.position),
        rotation,
    ))
}

fn pose2(pose: wire::PosePlanar) -> Pose2 {
    Pose2::new(Vector2::new(pose.x, pose.y), pose.yaw)
}

impl ReportEntry {
    fn of(report: &RunReport) -> Self {
        let executed = report.executed.iter().map(|step| ExecutedEntry {
            action: step.action.clone(),
            args: step.args.clone(),
            learned: step.learned.clone(),
            outcome: step.outcome.clone(),
            is_done: step.is_done,
            attempts: step.attempts,
            robot_secs: step.robot_secs,
        });
        Self {
            plan: report
                .plan
                .iter()
                .map(|step| (step.name.clone(), step.args.clone()))
                .collect(),
            executed: executed.collect(),
            n_replans: report.n_replans,
            is_believed_done: report.is_believed_done,
            reason: report.reason.clone(),
            robot_secs: report.robot_secs,
        }
    }

    fn into_report(self) -> RunReport {
        let executed = self.executed.into_iter().map(|step| ExecutedStep {
            action: step.action,
            args: step.args,
            learned: step.learned,
            outcome: step.outcome,
            is_done: step.is_done,
            attempts: step.attempts,
            robot_secs: step.robot_secs,
        });
        RunReport {
            plan: self
                .plan
                .into_iter()
                .map(|(action, args)| GroundAction::new(action, args))
                .collect(),
            executed: executed.collect(),
            n_replans: self.n_replans,
            is_believed_done: self.is_believed_done,
            reason: self.reason,
            robot_secs: self.robot_secs,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(n_replans: usize) -> RunReport {
        RunReport {
            plan: vec![
                GroundAction::new("pick", ["bottle_1"]),
                GroundAction::new("throw_away", ["bottle_1", "bin_1"]),
            ],
            executed: vec![ExecutedStep {
                action: "pick".to_owned(),
                args: vec!["bottle_1".to_owned()],
                learned: Some("take".to_owned()),
                outcome: "`bottle_1` slipped".to_owned(),
                is_done: false,
                attempts: 2,
                robot_secs: 12.3,
            }],
            n_replans,
            is_believed_done: false,
            reason: Some("no plan".to_owned()),
            robot_secs: 45.6,
        }
    }

    fn snapshot() -> Snapshot {
        Snapshot {
            progress: Progress {
                reports: vec![report(1), RunReport::default()],
                explore_secs: Some(231.5),
                wall_secs: 12.0,
            },
            home_entry: 17,
            world_from_map: Pose2::new(Vector2::new(3.1, 1.2), -0.7),
            checkpoint: Checkpoint {
                map_from_odom: Pose2::new(Vector2::new(0.1, -0.2), 0.05),
                tcp_from_held: Some(Pose::translation(0.0, 0.01, -0.09)),
                seen: PointCloud::new(vec![Point3::new(0.5, 0.25, 1.0)]),
                viewed: vec![Point2::new(1.0, 2.0)],
                rng_word_pos: (7_u128 << 64) | 9,
                stage: Stage::Acting { n_steps_done: 1 },
                report: report(0),
            },
            told: Told {
                way_driven: vec![[0.0, 0.5], [1.0, 0.5]],
                timings: vec![Timing {
                    name: "exploring".to_owned(),
                    secs: 231.5,
                }],
                events: vec![wire::Event {
                    level: wire::EventLevel::Info,
                    text: "exploring".to_owned(),
                    time_secs: 0.0,
                }],
                ..Told::default()
            },
            world: b"the world".to_vec(),
        }
    }

    #[test]
    fn a_snapshot_comes_back_from_its_bytes() {
        let bytes = snapshot().to_bytes().unwrap();
        let again = Snapshot::from_bytes(&bytes).unwrap();
        assert_eq!(again.checkpoint.seen, snapshot().checkpoint.seen);
        assert_eq!(again.checkpoint.report, snapshot().checkpoint.report);
        assert_eq!(again.checkpoint.stage, snapshot().checkpoint.stage);
        assert_eq!(
            again.checkpoint.rng_word_pos,
            snapshot().checkpoint.rng_word_pos
        );
        assert_eq!(again.progress.reports, snapshot().progress.reports);
        assert_eq!(again.world, b"the world");
        assert_eq!(again.to_bytes().unwrap(), bytes);
    }

    #[test]
    fn bytes_that_are_no_snapshot_are_refused() {
        let bytes = snapshot().to_bytes().unwrap();
        let reason = |bytes: &[u8]| Snapshot::from_bytes(bytes).unwrap_err();
        assert_eq!(reason(&bytes[..5]), "5 bytes, expected at least 8");
        assert!(reason(&bytes[..100]).starts_with("92 bytes of JSON, expected "));
        let cut = bytes.len() - snapshot().world.len() - 1;
        assert_eq!(
            reason(&bytes[..cut]),
            "11 bytes of surfaces seen, expected 1 times 12"
        );
        let mut newer = bytes.clone();
        let place = bytes
            .windows(10)
            .position(|text| text.starts_with(b"\"format\":"))
            .unwrap();
        newer[place + 9] = b'2';
        assert_eq!(reason(&newer), "format 2, expected 1");
    }
}
