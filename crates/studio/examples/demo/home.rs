//! The drawn home: two rooms, their furniture, and the grid a perfect lidar would make of it.

use factotum_protocol::{
    Body, CELL_OCCUPIED, CELL_UNKNOWN, Geometry, Pose, Scene, SceneSource, Shape,
};

/// Corner of the grid, which the home lies in, and its size in cells.
pub(crate) const ORIGIN: [f64; 2] = [-0.5, -0.5];
pub(crate) const RESOLUTION_M: f64 = 0.05;
pub(crate) const WIDTH: u32 = 180;
pub(crate) const HEIGHT: u32 = 140;

/// Where things are that the robot acts on.
pub(crate) const BOTTLE: [f64; 3] = [1.75, 4.15, 0.72];
pub(crate) const BIN: [f64; 3] = [7.55, 0.55, 0.0];
pub(crate) const SWITCH: [f64; 3] = [4.53, 3.85, 1.15];
pub(crate) const FAUCET: [f64; 3] = [7.62, 2.6, 1.04];

const WALL: [f32; 4] = [0.93, 0.91, 0.87, 1.0];
const WOOD: [f32; 4] = [0.72, 0.55, 0.38, 1.0];
const WOOD_DARK: [f32; 4] = [0.45, 0.33, 0.24, 1.0];
const WHITE: [f32; 4] = [0.95, 0.95, 0.94, 1.0];
const STEEL: [f32; 4] = [0.72, 0.75, 0.78, 1.0];
const STONE: [f32; 4] = [0.36, 0.39, 0.42, 1.0];
const FABRIC: [f32; 4] = [0.36, 0.47, 0.55, 1.0];
const FABRIC_LIGHT: [f32; 4] = [0.47, 0.58, 0.66, 1.0];
const RUG: [f32; 4] = [0.80, 0.72, 0.62, 1.0];
const FLOOR_WOOD: [f32; 4] = [0.80, 0.68, 0.54, 1.0];
const FLOOR_TILE: [f32; 4] = [0.84, 0.85, 0.85, 1.0];
const LEAF: [f32; 4] = [0.30, 0.52, 0.33, 1.0];
const CLAY: [f32; 4] = [0.74, 0.43, 0.31, 1.0];

/// A box by its lowest and highest corner.
fn cuboid(low: [f64; 3], high: [f64; 3], rgba: [f32; 4]) -> Shape {
    let half = |axis: usize| (high[axis] - low[axis]) / 2.0;
    Shape {
        geometry: Geometry::Box {
            half_extents_m: [half(0), half(1), half(2)],
        },
        pose: at([low[0] + half(0), low[1] + half(1), low[2] + half(2)]),
        rgba,
    }
}

/// An upright cylinder by the middle of its foot.
pub(crate) fn post(foot: [f64; 3], radius_m: f64, height: f64, rgba: [f32; 4]) -> Shape {
    Shape {
        geometry: Geometry::Cylinder {
            radius_m,
            half_length_m: height / 2.0,
        },
        pose: at([foot[0], foot[1], foot[2] + height / 2.0]),
        rgba,
    }
}

pub(crate) fn ball(centre: [f64; 3], radius_m: f64, rgba: [f32; 4]) -> Shape {
    Shape {
        geometry: Geometry::Sphere { radius_m },
        pose: at(centre),
        rgba,
    }
}

pub(crate) fn at(position: [f64; 3]) -> Pose {
    Pose::from_position_yaw(position, 0.0)
}

fn body(name: &str, shapes: Vec<Shape>) -> Body {
    Body {
        name: name.to_owned(),
        pose: Pose::IDENTITY,
        shapes,
    }
}

fn walls() -> Vec<Shape> {
    let wall = |low: [f64; 2], high: [f64; 2], bottom: f64| {
        cuboid([low[0], low[1], bottom], [high[0], high[1], 2.5], WALL)
    };
    vec![
        wall([-0.1, -0.1], [8.1, 0.0], 0.0),
        wall([-0.1, 6.0], [8.1, 6.1], 0.0),
        wall([-0.1, 0.0], [0.0, 6.0], 0.0),
        wall([8.0, 0.0], [8.1, 6.0], 0.0),
        wall([4.55, 0.0], [4.65, 2.3], 0.0),
        wall([4.55, 3.3], [4.65, 6.0], 0.0),
        wall([4.55, 2.3], [4.65, 3.3], 2.1),
    ]
}

fn table(x: [f64; 2], y: [f64; 2], height: f64) -> Vec<Shape> {
    let mut shapes = vec![cuboid(
        [x[0], y[0], height - 0.04],
        [x[1], y[1], height],
        WOOD,
    )];
    for leg_x in [x[0] + 0.04, x[1] - 0.1] {
        for leg_y in [y[0] + 0.04, y[1] - 0.1] {
            let high = [leg_x + 0.06, leg_y + 0.06, height - 0.04];
            shapes.push(cuboid([leg_x, leg_y, 0.0], high, WOOD_DARK));
        }
    }
    shapes
}

/// Everything that never moves, in the order: floors, walls, furniture.
fn still() -> Vec<Body> {
    let sofa = vec![
        cuboid([0.15, 1.0, 0.08], [1.0, 3.0, 0.42], FABRIC),
        cuboid([0.15, 1.0, 0.42], [0.38, 3.0, 0.85], FABRIC),
        cuboid([0.15, 0.82, 0.08], [1.0, 1.0, 0.62], FABRIC),
        cuboid([0.15, 3.0, 0.08], [1.0, 3.18, 0.62], FABRIC),
        cuboid([0.4, 1.05, 0.42], [0.98, 1.98, 0.52], FABRIC_LIGHT),
        cuboid([0.4, 2.02, 0.42], [0.98, 2.95, 0.52], FABRIC_LIGHT),
    ];
    let mut shelf = vec![cuboid([2.2, 0.02, 0.0], [3.6, 0.05, 1.4], WOOD_DARK)];
    for x in [2.2, 2.88, 3.56] {
        shelf.push(cuboid([x, 0.05, 0.0], [x + 0.04, 0.36, 1.4], WOOD));
    }
    for z in [0.0, 0.45, 0.9, 1.36] {
        shelf.push(cuboid([2.2, 0.05, z], [3.6, 0.36, z + 0.04], WOOD));
    }
    let spines = [CLAY, FABRIC, RUG, STONE, LEAF, WOOD_DARK];
    for (index, x) in (0_u32..18).map(|index| (index, 2.26 + 0.07 * f64::from(index))) {
        if (2.8..2.92).contains(&x) {
            continue;
        }
        let height = 0.24 + 0.03 * f64::from((index * 7) % 4);
        let rgba = spines[(index as usize * 5) % spines.len()];
        shelf.push(cuboid(
            [x, 0.1, 0.94],
            [x + 0.05, 0.32, 0.94 + height],
            rgba,
        ));
    }
    let counter = vec![
        cuboid([7.4, 1.0, 0.1], [8.0, 4.6, 0.86], WHITE),
        cuboid([7.45, 1.0, 0.0], [8.0, 4.6, 0.1], STONE),
        cuboid([7.37, 0.98, 0.86], [8.0, 2.3, 0.9], STONE),
        cuboid([7.37, 2.9, 0.86], [8.0, 4.62, 0.9], STONE),
        cuboid([7.37, 2.3, 0.86], [7.45, 2.9, 0.9], STONE),
        cuboid([7.85, 2.3, 0.86], [8.0, 2.9, 0.9], STONE),
        cuboid([7.45, 2.3, 0.72], [7.85, 2.9, 0.74], STEEL),
        cuboid([7.66, 1.0, 1.5], [8.0, 2.1, 2.2], WHITE),
        cuboid([7.66, 3.2, 1.5], [8.0, 4.6, 2.2], WHITE),
    ];
    let microwave = vec![
        cuboid([7.5, 3.5, 0.9], [7.95, 4.05, 1.2], STEEL),
        cuboid([7.49, 3.52, 0.93], [7.5, 3.88, 1.17], STONE),
    ];
    let fridge = vec![
        cuboid([7.3, 4.9, 0.03], [8.0, 5.7, 1.25], STEEL),
        cuboid([7.3, 4.9, 1.27], [8.0, 5.7, 1.85], STEEL),
        cuboid([7.26, 5.0, 0.5], [7.29, 5.03, 1.15], STONE),
        cuboid([7.26, 5.0, 1.35], [7.29, 5.03, 1.7], STONE),
    ];
    let plant = vec![
        post([0.5, 5.5, 0.0], 0.18, 0.35, CLAY),
        ball([0.5, 5.5, 0.72], 0.32, LEAF),
        ball([0.38, 5.38, 1.0], 0.22, LEAF),
    ];
    vec![
        body(
            "floor living room",
            vec![cuboid([0.0, 0.0, -0.05], [4.6, 6.0, 0.0], FLOOR_WOOD)],
        ),
        body(
            "floor kitchen",
            vec![cuboid([4.6, 0.0, -0.05], [8.0, 6.0, 0.0], FLOOR_TILE)],
        ),
        body("rug", vec![cuboid([1.15, 1.0, 0.0], [3.0, 3.0, 0.01], RUG)]),
        body("walls", walls()),
        body("sofa", sofa),
        body("side table", table([1.3, 2.6], [3.7, 4.6], 0.72)),
        body("shelf", shelf),
        body("counter", counter),
        body("microwave", microwave),
        body("fridge", fridge),
        body("dining table", table([5.3, 6.3], [4.5, 5.6], 0.74)),
        body("plant", plant),
    ]
}

fn moving() -> Vec<Body> {
    let glass = [0.20, 0.55, 0.42, 1.0];
    let bottle = vec![
        post([0.0, 0.0, 0.0], 0.035, 0.16, glass),
        post([0.0, 0.0, 0.16], 0.014, 0.08, glass),
    ];
    let bin = vec![
        post([0.0, 0.0, 0.0], 0.19, 0.58, [0.30, 0.33, 0.36, 1.0]),
        post([0.0, 0.0, 0.58], 0.20, 0.03, [0.20, 0.22, 0.24, 1.0]),
    ];
    let switch = vec![
        cuboid([0.0, -0.06, -0.06], [0.02, 0.06, 0.06], WHITE),
        cuboid(
            [-0.02, -0.02, -0.03],
            [0.0, 0.02, 0.03],
            [0.85, 0.68, 0.25, 1.0],
        ),
    ];
    let faucet = vec![
        post([0.25, 0.0, -0.14], 0.025, 0.3, STEEL),
        cuboid([0.02, -0.015, 0.14], [0.27, 0.015, 0.17], STEEL),
        ball([0.25, 0.1, 0.0], 0.03, [0.65, 0.2, 0.18, 1.0]),
    ];
    let placed = |name: &str, position: [f64; 3], shapes: Vec<Shape>| Body {
        name: name.to_owned(),
        pose: at(position),
        shapes,
    };
    vec![
        placed("bottle", BOTTLE, bottle),
        placed("bin", BIN, bin),
        placed("light switch", SWITCH, switch),
        placed("faucet", FAUCET, faucet),
    ]
}

pub(crate) fn scene() -> Scene {
    Scene {
        source: SceneSource::Home,
        bodies: still().into_iter().chain(moving()).collect(),
    }
}

/// The true grid, and what of it has been seen.
pub(crate) struct Grid {
    truth: Vec<i8>,
    seen: Vec<i8>,
}

impl Grid {
    /// Cells are occupied where a shape reaches into the height of the lidar.
    pub(crate) fn of_home() -> Self {
        const LIDAR_M: [f64; 2] = [0.15, 0.5];
        let n_cells = (WIDTH * HEIGHT) as usize;
        let mut truth = vec![0_i8; n_cells];
        let mut bodies = still();
        bodies.extend(moving().into_iter().filter(|body| body.name == "bin"));
        for body in bodies {
            for shape in &body.shapes {
                let [x, y, z] = std::array::from_fn(|axis| {
                    body.pose.position[axis] + shape.pose.position[axis]
                });
                let half = match shape.geometry {
                    Geometry::Box { half_extents_m } => half_extents_m,
                    Geometry::Cylinder {
                        radius_m,
                        half_length_m,
                    } => [radius_m, radius_m, half_length_m],
                    _ => continue,
                };
                if z + half[2] < LIDAR_M[0] || z - half[2] > LIDAR_M[1] {
                    continue;
                }
                for (index, cell) in truth.iter_mut().enumerate() {
                    let [cell_x, cell_y] = centre(index);
                    let reach = RESOLUTION_M / 2.0;
                    if (cell_x - x).abs() < half[0] + reach && (cell_y - y).abs() < half[1] + reach
                    {
                        *cell = CELL_OCCUPIED;
                    }
                }
            }
        }
        Self {
            truth,
            seen: vec![CELL_UNKNOWN; n_cells],
        }
    }

    pub(crate) fn seen(&self) -> &[i8] {
        &self.seen
    }

    /// Sees along rays from a point, as far as they reach.
    pub(crate) fn look_around(&mut self, from: [f64; 2]) {
        const N_RAYS: u32 = 720;
        const RANGE_M: f64 = 4.5;
        for ray in 0..N_RAYS {
            let angle = std::f64::consts::TAU * f64::from(ray) / f64::from(N_RAYS);
            let (sin, cos) = angle.sin_cos();
            let mut distance = 0.0;
            while distance < RANGE_M {
                distance += RESOLUTION_M / 2.0;
                let Some(index) = index([from[0] + distance * cos, from[1] + distance * sin])
                else {
                    break;
                };
                self.seen[index] = self.truth[index];
                if self.truth[index] == CELL_OCCUPIED {
                    break;
                }
            }
        }
    }

    /// Whether a robot of this radius can stand here.
    pub(crate) fn is_free(&self, point: [f64; 2], radius_m: f64) -> bool {
        (0..self.truth.len()).all(|index| {
            let [x, y] = centre(index);
            self.truth[index] != CELL_OCCUPIED || (x - point[0]).hypot(y - point[1]) > radius_m
        })
    }
}

fn centre(index: usize) -> [f64; 2] {
    let (row, column) = (index / WIDTH as usize, index % WIDTH as usize);
    [
        ORIGIN[0] + (column as f64 + 0.5) * RESOLUTION_M,
        ORIGIN[1] + (row as f64 + 0.5) * RESOLUTION_M,
    ]
}

fn index([x, y]: [f64; 2]) -> Option<usize> {
    let column = ((x - ORIGIN[0]) / RESOLUTION_M).floor();
    let row = ((y - ORIGIN[1]) / RESOLUTION_M).floor();
    let inside =
        (0.0..f64::from(WIDTH)).contains(&column) && (0.0..f64::from(HEIGHT)).contains(&row);
    inside.then(|| row as usize * WIDTH as usize + column as usize)
}
