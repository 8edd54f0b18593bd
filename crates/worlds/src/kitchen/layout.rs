//! What stands where in a kitchen.

use std::f64::consts::{FRAC_PI_2, PI};

use factotum_geometry::frames::pose_from_planar;
use factotum_geometry::{Pose, Pose2};
use factotum_physics::{Primitive, SceneBuilder, Shape};
use nalgebra::{Point3, Vector2, Vector3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

const WALL_HALF_M: f64 = 0.05;
const WALL_HEIGHT_M: f64 = 2.5;
const COUNTER_DEPTH_M: f64 = 0.6;
const COUNTER_HEIGHT_M: f64 = 0.9;
/// Width, depth and height.
const FRIDGE_M: [f64; 3] = [0.7, 0.7, 1.8];
/// Depth, from, and to.
const CABINET_M: [f64; 3] = [0.35, 1.4, 2.1];
/// Depth (along the way it faces), width and height.
const MACHINE_M: [f64; 3] = [0.30, 0.25, 0.35];
/// Radius and height.
const MUG_M: [f64; 2] = [0.04, 0.10];
/// What is left free between things on a counter, and to its edge.
const GAP_M: f64 = 0.02;
const N_DRAWS_MAX: usize = 50;

/// Something that skills act on.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// Its class, and the name of its shape.
    pub(super) class: &'static str,
    /// Where it stands, seen from above.
    pub(super) world_from_object: Pose2,
    /// What has to be reached and seen.
    pub(super) point_in_world: Point3<f64>,
    /// What can be done there.
    pub(super) actions: &'static [&'static str],
}

/// A surface to put things on: a rectangle from its corner, x along its back, y to its front edge.
#[derive(Debug, Clone)]
struct Surface {
    world_from_surface: Pose2,
    length_m: f64,
    depth_m: f64,
}

/// A kitchen.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// Along x and y.
    pub(super) room_m: [f64; 2],
    /// Walls, furniture and objects.
    pub(super) shapes: Vec<Shape>,
    pub(super) targets: Vec<Target>,
}

impl Layout {
    /// Draws one; `None` if not all of it finds a place.
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Option<Self> {
        let room_m = [rng.random_range(2.8..5.0), rng.random_range(2.6..4.5)];
        let mut layout = Self {
            room_m,
            shapes: Vec::new(),
            targets: Vec::new(),
        };
        layout.walls();
        let first_wall = rng.random_range(0..4);
        let n_walls = rng.random_range(1..=3);
        let mut surfaces = Vec::new();
        for i in 0..n_walls {
            layout.counter((first_wall + i) % 4, i == 0, &mut surfaces, rng);
        }
        if room_m.iter().all(|side| *side > 3.6) && rng.random_bool(0.6) {
            layout.island(&mut surfaces, rng);
        }
        layout.objects(&surfaces, rng)?;
        Some(layout)
    }

    /// The scene of it.
    pub(super) fn scene(&self) -> SceneBuilder {
        let mut builder = SceneBuilder::new();
        for shape in &self.shapes {
            builder.add_shape(shape.clone());
        }
        builder
    }

    fn add(&mut self, name: String, primitive: Primitive, world_from_shape: Pose) {
        self.shapes.push(Shape {
            name,
            primitive,
            world_from_shape,
            rgba: [0.7, 0.7, 0.7, 1.0],
            collides: true,
            motion: factotum_physics::Motion::Fixed,
        });
    }

    /// A box over a rectangle of a surface's plane, between two heights.
    fn add_block(
        &mut self,
        name: String,
        world_from_surface: &Pose2,
        [x, y]: [[f64; 2]; 2],
        z: [f64; 2],
    ) {
        let middle = |[from, to]: [f64; 2]| f64::midpoint(from, to);
        let half = |[from, to]: [f64; 2]| 0.5 * (to - from);
        let at = world_from_surface * Pose2::new(Vector2::new(middle(x), middle(y)), 0.0);
        let half = [half(x), half(y), half(z)];
        self.add(
            name,
            Primitive::Box { half },
            pose_from_planar(&at, middle(z)),
        );
    }

    /// Wall k, seen from inside: x along it, y into the room, counter-clockwise round the room.
    fn world_from_wall(&self, k: usize) -> (Pose2, f64) {
        let [width, depth] = self.room_m;
        let (corner, length_m) = match k {
            0 => ([0.0, 0.0], width),
            1 => ([width, 0.0], depth),
            2 => ([width, depth], width),
            _ => ([0.0, depth], depth),
        };
        let pose = Pose2::new(Vector2::from(corner), k as f64 * FRAC_PI_2);
        (pose, length_m)
    }

    fn walls(&mut self) {
        for k in 0..4 {
            let (pose, length_m) = self.world_from_wall(k);
            let y = [-2.0 * WALL_HALF_M, 0.0];
            self.add_block(
                format!("wall {k}"),
                &pose,
                [[0.0, length_m], y],
                [0.0, WALL_HEIGHT_M],
            );
        }
    }

    /// A counter along a wall, with cabinets above parts of it; the first ends at a fridge.
    fn counter(
        &mut self,
        wall: usize,
        has_fridge: bool,
        surfaces: &mut Vec<Surface>,
        rng: &mut ChaCha8Rng,
    ) {
        let (pose, length_m) = self.world_from_wall(wall);
        // A door may be at the end of the wall.
        let mut from = 0.0;
        let to = length_m - rng.random_range(0.0..1.0_f64);
        if has_fridge {
            let [width, depth, height] = FRIDGE_M;
            let block = [[0.0, width], [0.0, depth]];
            self.add_block(format!("fridge {wall}"), &pose, block, [0.0, height]);
            from = width;
        }
        let block = [[from, to], [0.0, COUNTER_DEPTH_M]];
        self.add_block(
            format!("counter {wall}"),
            &pose,
            block,
            [0.0, COUNTER_HEIGHT_M],
        );
        let mut x = from;
        for i in 0..8 {
            let width = rng.random_range(0.4..1.0);
            let [depth, bottom, top] = CABINET_M;
            if x + width > to {
                break;
            }
            if rng.random_bool(0.6) {
                let block = [[x, x + width], [0.0, depth]];
                self.add_block(format!("cabinet {wall} {i}"), &pose, block, [bottom, top]);
            }
            x += width;
        }
        // Corners belong to the counter of the next wall, or the one before.
        let corner = if has_fridge { from } else { COUNTER_DEPTH_M };
        let length_m = (to - COUNTER_DEPTH_M - corner).max(0.0);
        surfaces.push(Surface {
            world_from_surface: pose * Pose2::new(Vector2::new(corner, 0.0), 0.0),
            length_m,
            depth_m: COUNTER_DEPTH_M,
        });
    }

    fn island(&mut self, surfaces: &mut Vec<Surface>, rng: &mut ChaCha8Rng) {
        let [length_m, depth_m] = [rng.random_range(0.8..1.4), rng.random_range(0.6..0.9)];
        let middle = Vector2::from(self.room_m) * 0.5 - Vector2::new(length_m, depth_m) * 0.5;
        let pose = Pose2::new(middle, 0.0);
        let block = [[0.0, length_m], [0.0, depth_m]];
        self.add_block("island".to_owned(), &pose, block, [0.0, COUNTER_HEIGHT_M]);
        surfaces.push(Surface {
            world_from_surface: pose,
            length_m,
            depth_m,
        });
    }

    /// The coffee machine at the back of a counter, the mug, and other things anywhere.
    fn objects(&mut self, surfaces: &[Surface], rng: &mut ChaCha8Rng) -> Option<()> {
        let mut taken: Vec<(Vector2<f64>, f64)> = Vec::new();
        let [depth, width, height] = MACHINE_M;
        let back_m = 0.5 * depth + rng.random_range(0.03..0.15);
        let radius = 0.5 * depth.hypot(width);
        let machine = free_place(&surfaces[..1], radius, Some(back_m), &mut taken, rng)?;
        let half = [0.5 * depth, 0.5 * width, 0.5 * height];
        let middle_z = COUNTER_HEIGHT_M + 0.5 * height;
        let world_from_machine = pose_from_planar(&machine, middle_z);
        self.add(
            "CoffeeMachine".to_owned(),
            Primitive::Box { half },
            world_from_machine,
        );
        self.targets.push(Target {
            class: "CoffeeMachine",
            world_from_object: machine,
            point_in_world: world_from_machine * Point3::new(half[0], 0.0, 0.0),
            actions: &["ToggleObjectOn", "PutObject"],
        });
        let [r, height] = MUG_M;
        let mug = free_place(surfaces, r, None, &mut taken, rng)?;
        let world_from_mug = pose_from_planar(&mug, COUNTER_HEIGHT_M + 0.5 * height);
        let half = 0.5 * height;
        self.add(
            "Mug".to_owned(),
            Primitive::Cylinder { r, half },
            world_from_mug,
        );
        self.targets.push(Target {
            class: "Mug",
            world_from_object: mug,
            point_in_world: Point3::origin() + world_from_mug.translation.vector,
            actions: &["PickupObject"],
        });
        for i in 0..rng.random_range(4..14) {
            let r = rng.random_range(0.03..0.12);
            let half = rng.random_range(0.03..0.18);
            // A full counter takes no more.
            let Some(at) = free_place(surfaces, r, None, &mut taken, rng) else {
                break;
            };
            let pose = pose_from_planar(&at, COUNTER_HEIGHT_M + half);
            self.add(format!("thing {i}"), Primitive::Cylinder { r, half }, pose);
        }
        Some(())
    }
}

/// A place for something round on one of the surfaces, apart from what is there; its pose faces away from the back.
fn free_place(
    surfaces: &[Surface],
    radius: f64,
    from_back_m: Option<f64>,
    taken: &mut Vec<(Vector2<f64>, f64)>,
    rng: &mut ChaCha8Rng,
) -> Option<Pose2> {
    let edge = radius + GAP_M;
    for _ in 0..N_DRAWS_MAX {
        let surface = &surfaces[rng.random_range(0..surfaces.len())];
        if surface.length_m <= 2.0 * edge || surface.depth_m <= 2.0 * edge {
            continue;
        }
        let x = rng.random_range(edge..surface.length_m - edge);
        let y = match from_back_m {
            Some(y) => y,
            None => rng.random_range(edge..surface.depth_m - edge),
        };
        let facing = Pose2::new(Vector2::new(x, y), FRAC_PI_2);
        let pose = surface.world_from_surface * facing;
        let at = pose.translation.vector;
        let is_apart = |(other, r): &(Vector2<f64>, f64)| (at - other).norm() > radius + r + GAP_M;
        if taken.iter().all(is_apart) {
            taken.push((at, radius));
            return Some(pose);
        }
    }
    None
}

/// The direction a pose on the floor faces.
pub(super) fn ahead(pose: &Pose2) -> Vector3<f64> {
    let yaw = pose.rotation.angle();
    debug_assert!(yaw.abs() <= PI + 1e-9, "{yaw}");
    Vector3::new(yaw.cos(), yaw.sin(), 0.0)
}
