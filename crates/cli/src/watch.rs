//! Between the run and whoever watches: the page gets poses, map and plan; its pause and stop, and Ctrl-C, get back.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use factotum_agent::{Event, LogLevel, Observer, StepKind, StepState, Wish};
use factotum_geometry::Pose;
use factotum_geometry::frames::xyzw_from_quat;
use factotum_physics::GeomShape;
use factotum_protocol as wire;
use factotum_protocol::ServerMessage;
use factotum_semantic_map::{Aosm, Location, ObjectSource, TopologicalGraph};
use factotum_studio::StudioHandle;
use factotum_worlds::{BodyGroup, SimRobot, VisualBody, WorldView};

use crate::console::Console;

/// A wish to stop, from the page or from Ctrl-C.
#[derive(Debug, Clone, Default)]
pub(crate) struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    pub(crate) fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    pub(crate) fn is_raised(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// How often the page gets new poses, in robot seconds.
pub(crate) const FRAME_SECS: f64 = 1.0 / 30.0;

/// Tells the page where everything is and keeps pace with the clock.
pub(crate) struct Pacer {
    studio: Option<Arc<StudioHandle>>,
    stop: StopFlag,
    names: Vec<String>,
    joints: Vec<String>,
    /// Robot seconds per second; 0 for as fast as possible.
    speed: f64,
    before: Option<(Instant, f64)>,
}

impl Pacer {
    pub(crate) fn new(studio: Option<Arc<StudioHandle>>, stop: StopFlag, robot: &SimRobot, speed: f64) -> Self {
        use factotum_control::Robot as _;
        Self {
            studio,
            stop,
            names: robot.visual_bodies().iter().map(|body| body.name.clone()).collect(),
            joints: robot.description().arm.joints.clone(),
            speed,
            before: None,
        }
    }

    /// Called by the simulation between steps; returning late slows it down, which is how a pause works.
    pub(crate) fn frame(&mut self, view: &WorldView<'_>) {
        self.keep_pace(view.time_secs);
        let Some(studio) = self.studio.clone() else { return };
        let sim_speed = self.measured_speed(view.time_secs);
        studio.publish(ServerMessage::State(self.state_of(view, sim_speed)));
        let commands = studio.commands();
        while let Some(command) = commands.try_next() {
            match command {
                wire::ClientMessage::Stop => self.stop.raise(),
                wire::ClientMessage::Resume => {}
                wire::ClientMessage::Pause => {
                    studio.publish(ServerMessage::State(self.state_of(view, 0.0)));
                    while !self.stop.is_raised() {
                        match commands.next_within(Duration::from_millis(200)) {
                            Some(wire::ClientMessage::Resume) => break,
                            Some(wire::ClientMessage::Stop) => self.stop.raise(),
                            Some(wire::ClientMessage::Pause) | None => {}
                        }
                    }
                    self.before = None;
                }
            }
        }
    }

    fn keep_pace(&self, time_secs: f64) {
        if let Some((instant, before_secs)) = self.before
            && self.speed > 0.0
        {
            let due = Duration::from_secs_f64(((time_secs - before_secs) / self.speed).max(0.0));
            std::thread::sleep(due.saturating_sub(instant.elapsed()));
        }
    }

    fn measured_speed(&mut self, time_secs: f64) -> f64 {
        let now = Instant::now();
        let speed = self.before.map_or(0.0, |(instant, before_secs)| {
            (time_secs - before_secs) / now.duration_since(instant).as_secs_f64().max(1e-6)
        });
        self.before = Some((now, time_secs));
        speed
    }

    fn state_of(&self, view: &WorldView<'_>, sim_speed: f64) -> wire::State {
        let odom = view.state.odom_from_base;
        wire::State {
            time_secs: view.time_secs,
            sim_speed,
            base: planar(&odom),
            body_poses: self
                .names
                .iter()
                .zip(view.world_from_body)
                .map(|(name, pose)| wire::BodyPose { name: name.clone(), pose: pose_of(pose) })
                .collect(),
            joints: self
                .joints
                .iter()
                .zip(&view.state.arm_positions)
                .map(|(name, position)| wire::JointPosition { name: name.clone(), position: *position })
                .collect(),
        }
    }
}

/// Tells the page and the terminal what the executive does.
pub(crate) struct Reporter<'a> {
    pub(crate) studio: Option<Arc<StudioHandle>>,
    pub(crate) stop: StopFlag,
    pub(crate) console: &'a Console,
    /// World in map: where the page must draw what is believed.
    pub(crate) world_from_map: factotum_geometry::Pose2,
    pub(crate) n_plans: u32,
}

impl Observer for Reporter<'_> {
    fn observe(&mut self, event: &Event<'_>) -> Wish {
        match event {
            Event::Log { time_secs, level, text } => {
                self.console.progress(text.clone());
                self.console.say(format_args!("[{time_secs:7.1} s] {text}"));
                let level = match level {
                    LogLevel::Info => wire::EventLevel::Info,
                    LogLevel::Warning => wire::EventLevel::Warning,
                    LogLevel::Error => wire::EventLevel::Error,
                };
                self.publish(|| {
                    ServerMessage::Event(wire::Event { level, text: text.clone(), time_secs: *time_secs })
                });
            }
            Event::Map { aosm, graph, .. } => {
                self.publish(|| ServerMessage::Aosm(aosm_of(aosm, graph, &self.world_from_map)));
                if let Some(studio) = &self.studio
                    && let Ok(map) = map_of(aosm, &self.world_from_map)
                {
                    studio.publish(ServerMessage::Map(map));
                }
            }
            Event::Plan { steps } => {
                let replans = self.n_plans;
                self.publish(|| ServerMessage::Plan(plan_of(steps, replans)));
            }
        }
        if self.stop.is_raised() { Wish::Stop } else { Wish::GoOn }
    }
}

impl Reporter<'_> {
    fn publish(&self, message: impl FnOnce() -> ServerMessage) {
        if let Some(studio) = &self.studio {
            studio.publish(message());
        }
    }
}

fn plan_of(steps: &[factotum_agent::StepView], replans: u32) -> wire::Plan {
    let step = |(index, step): (usize, &factotum_agent::StepView)| wire::PlanStep {
        index: index as u32,
        kind: match step.kind {
            StepKind::Navigate => wire::StepKind::Navigate,
            StepKind::Manipulate => wire::StepKind::Manipulate,
        },
        action: step.action.clone(),
        args: step.args.clone(),
        state: match step.state {
            StepState::Pending => wire::StepState::Pending,
            StepState::Running => wire::StepState::Running,
            StepState::Done => wire::StepState::Done,
            StepState::Failed => wire::StepState::Failed,
            StepState::Skipped => wire::StepState::Skipped,
        },
        attempts: step.attempts as u32,
        reason: step.reason.clone().unwrap_or_default(),
    };
    wire::Plan { replans, steps: steps.iter().enumerate().map(step).collect() }
}

fn map_of(aosm: &Aosm, world_from_map: &factotum_geometry::Pose2) -> Result<wire::OccupancyMap, wire::MapError> {
    let grid = &aosm.grid;
    let cells: Vec<i8> = grid.cells().iter().map(|cell| cell.to_ros()).collect();
    wire::OccupancyMap::from_cells(
        grid.width() as u32,
        grid.height() as u32,
        grid.resolution_m(),
        planar(&(world_from_map * grid.world_from_grid())),
        &cells,
    )
}

fn aosm_of(aosm: &Aosm, graph: &TopologicalGraph, world_from_map: &factotum_geometry::Pose2) -> wire::Aosm {
    let lift = factotum_geometry::frames::pose_from_planar(world_from_map, 0.0);
    let name = |index: usize| graph.nodes[index].option.to_string();
    wire::Aosm {
        classes: aosm
            .classes
            .values()
            .map(|class| wire::ObjectClass {
                name: class.name.clone(),
                actions: class.actions.iter().map(|action| action.name.clone()).collect(),
                provenance: wire::Provenance::Given,
            })
            .collect(),
        objects: aosm
            .objects
            .values()
            .map(|object| wire::AosmObject {
                name: object.name.clone(),
                class: object.class.clone(),
                pose: pose_of(&(lift * object.map_from_object)),
                state: match (&object.location, object.source) {
                    (Location::Held, _) => "held".to_owned(),
                    (Location::In(container), _) => format!("in {container}"),
                    (Location::Loose, ObjectSource::Given | ObjectSource::Seen | ObjectSource::Taught) => {
                        aosm.states_of(object).join(", ")
                    }
                },
            })
            .collect(),
        regions: graph
            .nodes
            .iter()
            .enumerate()
            .map(|(index, node)| wire::NavigationRegion {
                name: name(index),
                option: node.option.name.clone(),
                object: node.option.args.first().cloned().unwrap_or_default(),
                colour_index: index as u32,
                poses: node
                    .map_from_base
                    .iter()
                    .map(|pose| {
                        let at = planar(&(world_from_map * pose));
                        [at.x, at.y, at.yaw]
                    })
                    .collect(),
            })
            .collect(),
        edges: graph
            .edges
            .iter()
            .map(|edge| wire::AosmEdge {
                from: name(edge.nodes[0]),
                to: name(edge.nodes[1]),
                length_m: edge.length_m,
            })
            .collect(),
    }
}

/// The bodies of a group as a scene of the page.
pub(crate) fn scene_of(bodies: &[VisualBody], poses: &[Pose], source: wire::SceneSource) -> wire::Scene {
    let is_robot = source == wire::SceneSource::Robot;
    wire::Scene {
        source,
        bodies: bodies
            .iter()
            .zip(poses)
            .filter(|(body, _)| (body.group == BodyGroup::Robot) == is_robot)
            .map(|(body, pose)| wire::Body {
                name: body.name.clone(),
                pose: pose_of(pose),
                shapes: body
                    .shapes
                    .iter()
                    .filter_map(|shape| {
                        Some(wire::Shape {
                            geometry: geometry_of(&shape.shape)?,
                            pose: pose_of(&shape.body_from_shape),
                            rgba: shape.rgba,
                        })
                    })
                    .collect(),
            })
            .collect(),
    }
}

fn geometry_of(shape: &GeomShape) -> Option<wire::Geometry> {
    Some(match shape {
        GeomShape::Box { half } => wire::Geometry::Box { half_extents_m: *half },
        GeomShape::Sphere { r } => wire::Geometry::Sphere { radius_m: *r },
        GeomShape::Capsule { r, half } => wire::Geometry::Capsule { radius_m: *r, half_length_m: *half },
        GeomShape::Cylinder { r, half } => wire::Geometry::Cylinder { radius_m: *r, half_length_m: *half },
        GeomShape::Ellipsoid { radii } => wire::Geometry::Ellipsoid { radii_m: *radii },
        GeomShape::Plane => wire::Geometry::Plane { half_extents_m: [0.0, 0.0] },
        GeomShape::Mesh { vertices, faces } => wire::Geometry::Mesh {
            vertices: vertices.iter().flatten().copied().collect(),
            triangles: faces.iter().flatten().copied().collect(),
        },
        GeomShape::HeightField => return None,
    })
}

fn pose_of(pose: &Pose) -> wire::Pose {
    wire::Pose {
        position: pose.translation.vector.into(),
        orientation_xyzw: xyzw_from_quat(&pose.rotation),
    }
}

fn planar(pose: &factotum_geometry::Pose2) -> wire::PosePlanar {
    wire::PosePlanar { x: pose.translation.x, y: pose.translation.y, yaw: pose.rotation.angle() }
}
