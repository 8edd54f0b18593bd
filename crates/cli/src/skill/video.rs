//! Rollouts of a skill to look at: a strip of pictures and a recording of each.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use factotum_experiments::film::{strip, write_png};
use factotum_experiments::recording::Recording;
use factotum_geometry::Pose;
use factotum_physics::{BodyId, Snapshot, State};
use factotum_protocol as wire;
use factotum_skills::cip::rig::Rig as _;
use factotum_worlds::{TaskRig, VisualBody};
use nalgebra::{Point3, Vector3};

use crate::console::{Console, now};
use crate::wire_view::{pose_of, scene_of};

/// Rollouts that are kept.
const TAKES_MAX: usize = 3;

/// Moments of a take until the policy begins: placed, and the fingers closed. A shorter one did not get so far.
const MOMENTS_BEFORE: usize = 12;

/// Pictures in a strip.
const N_PICTURES: usize = 6;

/// Looks on while a skill is judged.
struct Video {
    dir: PathBuf,
    takes: Vec<Take>,
    set: Option<Set>,
}

/// One rollout.
struct Take {
    world_from_optical: Pose,
    moments: Vec<Snapshot>,
}

/// What does not change from take to take.
struct Set {
    state: State,
    bodies: Vec<(BodyId, VisualBody)>,
}

/// Runs something that lets its rig be seen, keeps what is seen in a folder if one is given, and says which files it left.
pub(crate) fn filmed<T>(
    dir: Option<&Path>,
    console: &Console,
    run: impl FnOnce(&mut dyn FnMut(&TaskRig)) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    let mut video = dir.map(Video::new).transpose()?;
    let done = run(&mut |rig| {
        if let Some(video) = &mut video {
            video.see(rig);
        }
    })?;
    if let Some(video) = video {
        for file in video.finish()? {
            console.say(format_args!("`{}`", file.display()));
        }
    }
    Ok(done)
}

impl Video {
    /// Into a folder, which is made.
    fn new(dir: &Path) -> anyhow::Result<Self> {
        std::fs::create_dir_all(dir).with_context(|| format!("cannot make `{}`", dir.display()))?;
        Ok(Self {
            dir: dir.to_owned(),
            takes: Vec::new(),
            set: None,
        })
    }

    /// Sees a moment of the rig.
    fn see(&mut self, rig: &TaskRig) {
        let state = rig.state();
        if self.set.is_none()
            && let Ok(own) = State::new(state.model())
        {
            self.set = Some(Set {
                state: own,
                bodies: rig.visual_bodies(),
            });
        }
        if state.time_secs() <= 0.0 {
            // What was begun and did not come to the policy is begun again.
            self.takes
                .retain(|take| take.moments.len() > MOMENTS_BEFORE);
            self.takes.push(Take {
                world_from_optical: view_of(rig),
                moments: Vec::new(),
            });
        }
        if self.takes.len() <= TAKES_MAX
            && let Some(take) = self.takes.last_mut()
        {
            take.moments.push(state.snapshot());
        }
    }

    /// Writes all that was seen; the files.
    fn finish(mut self) -> anyhow::Result<Vec<PathBuf>> {
        self.takes
            .retain(|take| take.moments.len() > MOMENTS_BEFORE);
        let mut files = Vec::new();
        let Some(Set { state, bodies }) = &mut self.set else {
            return Ok(files);
        };
        for (i, take) in self.takes.iter().take(TAKES_MAX).enumerate() {
            let file = |extension: &str| self.dir.join(format!("rollout-{}.{extension}", i + 1));
            let pictures = strip(state, &take.moments, N_PICTURES, &take.world_from_optical)?;
            write_png(&file("png"), &pictures)?;
            record(&file("mcap"), state, bodies, &take.moments)?;
            files.extend([file("png"), file("mcap")]);
        }
        Ok(files)
    }
}

/// From the side, so that robot and object are in view.
fn view_of(rig: &TaskRig) -> Pose {
    const DISTANCE_M: f64 = 1.5;
    let region = rig.reading().region;
    let middle = Point3::from(0.7 * region.coords + Vector3::new(0.0, 0.0, 0.1));
    let ahead = Vector3::new(region.x, region.y, 0.0)
        .try_normalize(1e-6)
        .unwrap_or_else(Vector3::x);
    let aside = Vector3::z().cross(&ahead);
    let from_middle: Vector3<f64> = aside + 0.6 * ahead + 0.55 * Vector3::z();
    let eye = middle + from_middle.normalize() * DISTANCE_M;
    Pose::face_towards(&eye, &middle, &-Vector3::z())
}

fn record(
    file: &Path,
    state: &mut State,
    bodies: &[(BodyId, VisualBody)],
    moments: &[Snapshot],
) -> anyhow::Result<()> {
    let mut recording = Recording::create(file, now())?;
    let drawn: Vec<VisualBody> = bodies.iter().map(|(_, body)| body.clone()).collect();
    for (i, moment) in moments.iter().enumerate() {
        state.restore(moment)?;
        state.forward_kinematics()?;
        let time_secs = state.time_secs();
        let poses = bodies.iter().map(|(body, _)| state.world_from_body(*body));
        let poses: Vec<Pose> = poses.collect();
        if i == 0 {
            for source in [wire::SceneSource::Robot, wire::SceneSource::Home] {
                let scene = scene_of(&drawn, &poses, source);
                recording.record(time_secs, &wire::ServerMessage::Scene(scene))?;
            }
        }
        let moved = drawn.iter().zip(&poses).map(|(body, pose)| wire::BodyPose {
            name: body.name.clone(),
            pose: pose_of(pose),
        });
        let state = wire::State {
            time_secs,
            sim_speed: 1.0,
            base: wire::PosePlanar {
                x: 0.0,
                y: 0.0,
                yaw: 0.0,
            },
            body_poses: moved.collect(),
            joints: Vec::new(),
        };
        recording.record(time_secs, &wire::ServerMessage::State(state))?;
    }
    Ok(recording.finish()?)
}
