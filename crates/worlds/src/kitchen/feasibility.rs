//! From where the skills can run, by physics.
//!
//! The robot is a stand-in of a mobile manipulator with a round base: a cylinder on the floor, a column, a camera that
//! turns, and an arm that reaches forward from its shoulder. It can stand where base and column touch nothing, and a skill
//! can run on a point where
//!
//! - the arm is long enough, and the point is not behind the shoulder;
//! - the ray from the camera to it meets the object first;
//! - so do rays along the arm, as thick as it is.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::f64::consts::FRAC_PI_2;

use factotum_geometry::{Pose, Pose2};
use factotum_physics::{
    BodyId, GeomId, Model, Motion, PhysicsError, Primitive, RayFilter, Shape, State,
};
use nalgebra::{Point2, Point3, Unit, Vector2, Vector3};

use super::layout::{Layout, Target, ahead};
use crate::WorldError;
use crate::action_map::{ActionMap, Cells, MapObject};

const CELL_M: f64 = 0.25;
/// Radius and half height of the base.
const BASE_M: [f64; 2] = [0.27, 0.15];
/// Radius and half height of the column.
const COLUMN_M: [f64; 2] = [0.12, 0.55];
/// What the robot keeps off everything.
const CLEARANCE_M: f64 = 0.02;
const CAMERA_HEIGHT_M: f64 = 1.3;
/// Ahead of the base's middle, and above the floor.
const SHOULDER_M: [f64; 2] = [0.15, 1.0];
/// From the shoulder to the middle of the hand.
const REACH_M: f64 = 0.9;
const ARM_RADIUS_M: f64 = 0.05;
/// The hand goes around the last of it.
const HAND_M: f64 = 0.1;
/// How far from the wanted point a ray may meet the object.
const POINT_TOLERANCE_M: f64 = 0.05;

const BASE: &str = "robot base";
const COLUMN: &str = "robot column";

/// The robot in the kitchen.
struct Probe {
    state: State,
    bodies: [BodyId; 2],
    geoms: [GeomId; 2],
    /// Everything else.
    obstacles: Vec<GeomId>,
    filter: RayFilter,
}

impl Probe {
    fn new(layout: &Layout) -> Result<Self, PhysicsError> {
        let mut builder = layout.scene();
        for (name, [r, half]) in [(BASE, BASE_M), (COLUMN, COLUMN_M)] {
            builder.add_shape(Shape {
                name: name.to_owned(),
                primitive: Primitive::Cylinder { r, half },
                world_from_shape: Pose::identity(),
                rgba: [0.2, 0.2, 0.2, 1.0],
                collides: true,
                motion: Motion::Mocap,
            });
        }
        let model: Model = builder.compile()?;
        let bodies = [model.body(BASE)?, model.body(COLUMN)?];
        let geoms = [model.geom(BASE)?, model.geom(COLUMN)?];
        Ok(Self {
            state: State::new(&model)?,
            obstacles: model.geoms().filter(|geom| !geoms.contains(geom)).collect(),
            filter: RayFilter::excluding(&bodies),
            bodies,
            geoms,
        })
    }

    /// Whether the robot touches nothing there.
    fn can_stand(&mut self, at: &Point2<f64>) -> Result<bool, PhysicsError> {
        for (body, [_, half]) in self.bodies.into_iter().zip([BASE_M, COLUMN_M]) {
            let pose = Pose::translation(at.x, at.y, half + CLEARANCE_M);
            self.state.set_mocap(body, &pose)?;
        }
        self.state.forward_kinematics()?;
        for geom in self.geoms {
            for obstacle in &self.obstacles {
                let distance_m = self
                    .state
                    .geom_distance_m(geom, *obstacle, 2.0 * CLEARANCE_M)?;
                if distance_m < CLEARANCE_M {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Whether the skill can run on the target's point from a base pose.
    fn can_run(&self, world_from_base: &Pose2, target: &Target, geom: GeomId) -> bool {
        let ahead = ahead(world_from_base);
        let floor = world_from_base.translation.vector;
        let floor = Point3::new(floor.x, floor.y, 0.0);
        let shoulder = floor + SHOULDER_M[0] * ahead + SHOULDER_M[1] * Vector3::z();
        let way = target.point_in_world - shoulder;
        if way.norm() > REACH_M || way.dot(&ahead) < 0.0 {
            return false;
        }
        let camera = floor + CAMERA_HEIGHT_M * Vector3::z();
        if !self.meets(camera, target.point_in_world, geom) {
            return false;
        }
        let Some(along) = Unit::try_new(way, 1e-6) else {
            return false;
        };
        let side = along.cross(&Vector3::z());
        let side = Unit::try_new(side, 1e-6).unwrap_or_else(Vector3::x_axis);
        let up = side.cross(&along);
        let length_m = way.norm() - HAND_M;
        [Vector3::zeros(), *side, -*side, up, -up]
            .iter()
            .all(|off| {
                let from = shoulder + ARM_RADIUS_M * off;
                let hit = self.state.ray(from, *along, &self.filter);
                hit.is_none_or(|hit| hit.distance_m >= length_m || hit.geom == geom)
            })
    }

    /// Whether the first thing from there towards a point is this geom, near the point.
    fn meets(&self, from: Point3<f64>, to: Point3<f64>, geom: GeomId) -> bool {
        let Some(direction) = Unit::try_new(to - from, 1e-6) else {
            return false;
        };
        let hit = self.state.ray(from, *direction, &self.filter);
        hit.is_some_and(|hit| {
            let is_near = (hit.distance_m - (to - from).norm()).abs() <= POINT_TOLERANCE_M;
            hit.geom == geom && is_near
        })
    }
}

/// The action map of a kitchen.
pub(super) fn action_map(scene: &str, layout: &Layout) -> Result<ActionMap, WorldError> {
    build(scene, layout).map_err(WorldError::physics("looking where skills can run"))
}

fn build(scene: &str, layout: &Layout) -> Result<ActionMap, PhysicsError> {
    let mut probe = Probe::new(layout)?;
    let n = layout.room_m.map(|side| (side / CELL_M) as i64);
    let middle = |[i, j]: [i64; 2]| Point2::new(i as f64 + 0.5, j as f64 + 0.5) * CELL_M;
    let mut free = BTreeSet::new();
    for i in 0..n[0] {
        for j in 0..n[1] {
            if probe.can_stand(&middle([i, j]))? {
                free.insert([i, j]);
            }
        }
    }
    let mut cells = Cells::new(CELL_M);
    for key in largest_part(&free) {
        // Its cells are on the grid, and each once.
        cells.push(middle(key));
    }
    let mut objects = Vec::new();
    for target in &layout.targets {
        let geom = probe.state.model().geom(target.class)?;
        let mut places = BTreeSet::new();
        for key in &free {
            for quarters in 0..4 {
                let at = middle(*key);
                let yaw = f64::from(quarters) * FRAC_PI_2;
                let world_from_base = Pose2::new(Vector2::new(at.x, at.y), yaw);
                let place = cells.place(&at, quarters as usize);
                if let Some(place) = place
                    && probe.can_run(&world_from_base, target, geom)
                {
                    places.insert(place);
                }
            }
        }
        let feasible: BTreeMap<_, _> = target
            .actions
            .iter()
            .map(|action| ((*action).to_owned(), places.clone()))
            .collect();
        objects.push(MapObject {
            id: target.class.to_owned(),
            class: target.class.to_owned(),
            world_from_object: target.world_from_object,
            feasible,
        });
    }
    Ok(ActionMap::new(scene.to_owned(), cells, objects))
}

/// The largest part of the cells that hangs together; the first of equals.
fn largest_part(free: &BTreeSet<[i64; 2]>) -> Vec<[i64; 2]> {
    let mut left = free.clone();
    let mut largest = Vec::new();
    while let Some(start) = left.pop_first() {
        let mut part = vec![start];
        let mut open = VecDeque::from([start]);
        while let Some([x, y]) = open.pop_front() {
            for next in [[x + 1, y], [x - 1, y], [x, y + 1], [x, y - 1]] {
                if left.remove(&next) {
                    part.push(next);
                    open.push_back(next);
                }
            }
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest
}
