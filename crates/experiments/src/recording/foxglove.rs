//! Foxglove's well-known messages, as far as a recording uses them, made from ours.

use std::collections::BTreeMap;

use factotum_geometry::Pose;
use factotum_geometry::frames::xyzw_from_quat;
use factotum_geometry::sensing;
use factotum_protocol as wire;
use serde::Serialize;

use super::base64;

const ROBOT_FRAME: &str = "base_link";
const WHITE: Color = Color {
    r: 1.0,
    g: 1.0,
    b: 1.0,
    a: 1.0,
};
const PATH_COLOR: Color = Color {
    r: 0.0,
    g: 0.45,
    b: 0.7,
    a: 1.0,
};

/// Colours of navigation regions: the palette of M. Okabe and K. Ito, which colour-blind people can tell apart.
const REGION_COLORS: [Color; 6] = [
    Color {
        r: 0.90,
        g: 0.62,
        b: 0.0,
        a: 0.9,
    },
    Color {
        r: 0.34,
        g: 0.71,
        b: 0.91,
        a: 0.9,
    },
    Color {
        r: 0.0,
        g: 0.62,
        b: 0.45,
        a: 0.9,
    },
    Color {
        r: 0.94,
        g: 0.89,
        b: 0.26,
        a: 0.9,
    },
    Color {
        r: 0.84,
        g: 0.37,
        b: 0.0,
        a: 0.9,
    },
    Color {
        r: 0.80,
        g: 0.47,
        b: 0.65,
        a: 0.9,
    },
];

#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Timestamp {
    pub(super) sec: u64,
    pub(super) nsec: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}

impl Vector3 {
    const ZERO: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };

    fn new([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Quaternion {
    const IDENTITY: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    };

    fn new([x, y, z, w]: [f64; 4]) -> Self {
        Self { x, y, z, w }
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
struct PoseInFrame {
    position: Vector3,
    orientation: Quaternion,
}

impl PoseInFrame {
    const IDENTITY: Self = Self {
        position: Vector3::ZERO,
        orientation: Quaternion::IDENTITY,
    };

    /// A pose moved along its own z axis.
    fn moved_along_z(self, distance: f64) -> Self {
        let Quaternion { x, y, z, w } = self.orientation;
        // Third column of the rotation matrix.
        let axis = [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ];
        let Vector3 { x, y, z } = self.position;
        let position = Vector3::new([
            x + distance * axis[0],
            y + distance * axis[1],
            z + distance * axis[2],
        ]);
        Self { position, ..self }
    }
}

impl From<&wire::Pose> for PoseInFrame {
    fn from(pose: &wire::Pose) -> Self {
        Self {
            position: Vector3::new(pose.position),
            orientation: Quaternion::new(pose.orientation_xyzw),
        }
    }
}

impl From<wire::PosePlanar> for PoseInFrame {
    fn from(pose: wire::PosePlanar) -> Self {
        Self::from(&wire::Pose::from_position_yaw(
            [pose.x, pose.y, 0.0],
            pose.yaw,
        ))
    }
}

impl From<&Pose> for PoseInFrame {
    fn from(pose: &Pose) -> Self {
        Self {
            position: Vector3::new(pose.translation.vector.into()),
            orientation: Quaternion::new(xyzw_from_quat(&pose.rotation)),
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Color {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

impl From<[f32; 4]> for Color {
    fn from([r, g, b, a]: [f32; 4]) -> Self {
        Self {
            r: r.into(),
            g: g.into(),
            b: b.into(),
            a: a.into(),
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct FrameTransforms {
    pub(super) transforms: Vec<FrameTransform>,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct FrameTransform {
    timestamp: Timestamp,
    parent_frame_id: &'static str,
    child_frame_id: String,
    translation: Vector3,
    rotation: Quaternion,
}

/// Where every frame is, so that only those that moved need to be written.
#[derive(Debug, Default)]
pub(super) struct Frames {
    transforms: BTreeMap<String, FrameTransform>,
}

impl Frames {
    /// Takes where a body is now and returns its transform if it is another than before.
    pub(super) fn place(
        &mut self,
        timestamp: Timestamp,
        name: &str,
        world_from_body: &wire::Pose,
    ) -> Option<FrameTransform> {
        let transform = FrameTransform {
            timestamp,
            parent_frame_id: super::ROOT_FRAME,
            child_frame_id: name.to_owned(),
            translation: Vector3::new(world_from_body.position.map(rounded)),
            rotation: Quaternion::new(world_from_body.orientation_xyzw.map(rounded)),
        };
        let before = self.transforms.insert(name.to_owned(), transform.clone());
        let is_same = before.is_some_and(|before| {
            before.translation == transform.translation && before.rotation == transform.rotation
        });
        (!is_same).then_some(transform)
    }

    /// Takes a state and returns the transforms of what moved.
    pub(super) fn advance(
        &mut self,
        timestamp: Timestamp,
        state: &wire::State,
    ) -> Vec<FrameTransform> {
        let base = wire::Pose::from_position_yaw([state.base.x, state.base.y, 0.0], state.base.yaw);
        let bodies = state
            .body_poses
            .iter()
            .map(|body| (body.name.as_str(), &body.pose))
            .filter(|(name, _)| *name != ROBOT_FRAME);
        bodies
            .chain([(ROBOT_FRAME, &base)])
            .filter_map(|(name, pose)| self.place(timestamp, name, pose))
            .collect()
    }

    /// All transforms as they are now.
    pub(super) fn all(&self, timestamp: Timestamp) -> Vec<FrameTransform> {
        let now = |transform: &FrameTransform| FrameTransform {
            timestamp,
            ..transform.clone()
        };
        self.transforms.values().map(now).collect()
    }
}

/// A coordinate to a micrometre, or to a millionth: finer than anyone sees, and short as text.
fn rounded(coordinate: f64) -> f64 {
    (coordinate * 1e6).round() / 1e6
}

/// Foxglove's `NumericType`.
#[derive(Debug, Clone, Copy)]
enum NumericType {
    Uint8 = 1,
    Int8 = 2,
}

#[derive(Debug, Serialize)]
struct PackedElementField {
    name: &'static str,
    offset: u32,
    #[serde(rename = "type")]
    numeric_type: u8,
}

impl PackedElementField {
    fn new(name: &'static str, offset: u32, numeric_type: NumericType) -> Self {
        Self {
            name,
            offset,
            numeric_type: numeric_type as u8,
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
struct Vector2 {
    x: f64,
    y: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Grid {
    timestamp: Timestamp,
    frame_id: &'static str,
    pose: PoseInFrame,
    column_count: u32,
    cell_size: Vector2,
    row_stride: u32,
    cell_stride: u32,
    fields: Vec<PackedElementField>,
    data: String,
}

impl Grid {
    /// Bytes of a cell: four of colour, shown without any setting, and the occupancy in percent.
    const CELL_STRIDE: u32 = 5;

    pub(super) fn new(timestamp: Timestamp, map: &wire::OccupancyMap, cells: &[i8]) -> Self {
        let data: Vec<u8> = cells
            .iter()
            .flat_map(|&cell| Self::cell_bytes(cell))
            .collect();
        Self {
            timestamp,
            frame_id: super::ROOT_FRAME,
            pose: map.origin.into(),
            column_count: map.width,
            cell_size: Vector2 {
                x: map.resolution_m,
                y: map.resolution_m,
            },
            row_stride: map.width.saturating_mul(Self::CELL_STRIDE),
            cell_stride: Self::CELL_STRIDE,
            fields: vec![
                PackedElementField::new("red", 0, NumericType::Uint8),
                PackedElementField::new("green", 1, NumericType::Uint8),
                PackedElementField::new("blue", 2, NumericType::Uint8),
                PackedElementField::new("alpha", 3, NumericType::Uint8),
                PackedElementField::new("occupancy", 4, NumericType::Int8),
            ],
            data: base64::encode(&data),
        }
    }

    fn cell_bytes(cell: i8) -> [u8; 5] {
        let occupancy = cell.to_le_bytes()[0];
        if cell == wire::CELL_UNKNOWN {
            return [128, 128, 128, 64, occupancy];
        }
        // Free is white, occupied is black.
        let grey = 255 - (u16::from(cell.unsigned_abs()).min(100) * 255 / 100) as u8;
        [grey, grey, grey, 255, occupancy]
    }
}

#[derive(Debug, Serialize)]
pub(super) struct LaserScan {
    timestamp: Timestamp,
    frame_id: &'static str,
    pose: PoseInFrame,
    start_angle: f64,
    end_angle: f64,
    ranges: Vec<f64>,
    intensities: Vec<f64>,
}

impl LaserScan {
    pub(super) fn new(
        timestamp: Timestamp,
        base_from_lidar: &Pose,
        scan: &sensing::LaserScan,
    ) -> Self {
        let n_steps = scan.ranges_m.len().saturating_sub(1);
        let range = |&range_m: &f64| {
            if range_m < scan.range_max_m {
                range_m.max(0.0)
            } else {
                0.0
            }
        };
        Self {
            timestamp,
            frame_id: ROBOT_FRAME,
            pose: base_from_lidar.into(),
            start_angle: scan.angle_min_rad,
            end_angle: scan.angle_min_rad + n_steps as f64 * scan.angle_step_rad,
            ranges: scan.ranges_m.iter().map(range).collect(),
            intensities: Vec::new(),
        }
    }
}

/// Foxglove's `LogLevel`.
#[derive(Debug, Clone, Copy)]
pub(super) enum LogLevel {
    Info = 2,
    Warning = 3,
    Error = 4,
}

#[derive(Debug, Serialize)]
pub(super) struct Log<'a> {
    timestamp: Timestamp,
    level: u8,
    message: &'a str,
    name: &'static str,
    file: &'static str,
    line: u32,
}

impl<'a> Log<'a> {
    pub(super) fn new(timestamp: Timestamp, level: LogLevel, message: &'a str) -> Self {
        Self {
            timestamp,
            level: level as u8,
            message,
            name: "factotum",
            file: "",
            line: 0,
        }
    }
}

#[derive(Debug, Serialize)]
pub(super) struct SceneUpdate {
    deletions: Vec<SceneEntityDeletion>,
    entities: Vec<SceneEntity>,
}

#[derive(Debug, Serialize)]
struct SceneEntityDeletion {
    timestamp: Timestamp,
    /// 0: the one with this id; 1: all entities of the topic.
    #[serde(rename = "type")]
    deletion_type: u8,
    id: String,
}

#[derive(Debug, Serialize)]
struct SceneEntity {
    timestamp: Timestamp,
    frame_id: String,
    id: String,
    lifetime: Timestamp,
    frame_locked: bool,
    metadata: Vec<KeyValuePair>,
    arrows: Vec<Arrow>,
    cubes: Vec<Solid>,
    spheres: Vec<Solid>,
    cylinders: Vec<Cylinder>,
    lines: Vec<Line>,
    triangles: Vec<TriangleList>,
    texts: Vec<Text>,
    models: [(); 0],
}

#[derive(Debug, Serialize)]
struct KeyValuePair {
    key: &'static str,
    value: String,
}

#[derive(Debug, Serialize)]
struct Arrow {
    pose: PoseInFrame,
    shaft_length: f64,
    shaft_diameter: f64,
    head_length: f64,
    head_diameter: f64,
    color: Color,
}

/// A cube or an ellipsoid, by its whole edges or diameters.
#[derive(Debug, Serialize)]
struct Solid {
    pose: PoseInFrame,
    size: Vector3,
    color: Color,
}

#[derive(Debug, Serialize)]
struct Cylinder {
    pose: PoseInFrame,
    size: Vector3,
    bottom_scale: f64,
    top_scale: f64,
    color: Color,
}

#[derive(Debug, Serialize)]
struct Line {
    /// 0: a strip through all points.
    #[serde(rename = "type")]
    line_type: u8,
    pose: PoseInFrame,
    thickness: f64,
    scale_invariant: bool,
    points: Vec<Vector3>,
    color: Color,
    colors: [(); 0],
    indices: [(); 0],
}

#[derive(Debug, Serialize)]
struct TriangleList {
    pose: PoseInFrame,
    points: Vec<Vector3>,
    color: Color,
    colors: [(); 0],
    indices: Vec<u32>,
}

#[derive(Debug, Serialize)]
struct Text {
    pose: PoseInFrame,
    billboard: bool,
    font_size: f64,
    scale_invariant: bool,
    color: Color,
    text: String,
}

impl SceneUpdate {
    /// The bodies of a scene, each fixed to its frame, in place of the bodies that its source showed before.
    pub(super) fn of_scene(timestamp: Timestamp, scene: &wire::Scene, shown: &[String]) -> Self {
        let is_gone = |name: &&String| !scene.bodies.iter().any(|body| body.name == **name);
        let deletions = shown
            .iter()
            .filter(is_gone)
            .map(|name| SceneEntityDeletion {
                timestamp,
                deletion_type: 0,
                id: name.clone(),
            });
        let entities = scene.bodies.iter().map(|body| {
            let mut entity = SceneEntity::empty(timestamp, &body.name, &body.name);
            entity.frame_locked = true;
            let is_belief = scene.source == wire::SceneSource::Belief;
            for shape in &body.shapes {
                let mut color = Color::from(shape.rgba);
                color.a *= if is_belief { 0.4 } else { 1.0 };
                entity.add(&shape.geometry, (&shape.pose).into(), color);
            }
            entity
        });
        Self {
            deletions: deletions.collect(),
            entities: entities.collect(),
        }
    }

    /// Objects by name, and an arrow for each pose of a navigation region; replaces what was shown before.
    pub(super) fn of_aosm(timestamp: Timestamp, aosm: &wire::Aosm) -> Self {
        let objects = aosm.objects.iter().map(|object| {
            let mut entity = SceneEntity::empty(
                timestamp,
                super::ROOT_FRAME,
                &format!("object/{}", object.name),
            );
            let [x, y, z] = object.pose.position;
            let above = wire::Pose {
                position: [x, y, z + 0.2],
                ..object.pose
            };
            entity.texts.push(Text {
                pose: (&above).into(),
                billboard: true,
                font_size: 0.12,
                scale_invariant: false,
                color: WHITE,
                text: object.name.clone(),
            });
            entity.metadata.push(KeyValuePair {
                key: "class",
                value: object.class.clone(),
            });
            entity.metadata.push(KeyValuePair {
                key: "state",
                value: object.state.clone(),
            });
            entity
        });
        let regions = aosm.regions.iter().map(|region| {
            let mut entity = SceneEntity::empty(
                timestamp,
                super::ROOT_FRAME,
                &format!("region/{}", region.name),
            );
            let color = REGION_COLORS[region.colour_index as usize % REGION_COLORS.len()];
            entity.arrows.extend(region.base_poses().map(|pose| Arrow {
                pose: pose.into(),
                shaft_length: 0.12,
                shaft_diameter: 0.03,
                head_length: 0.06,
                head_diameter: 0.06,
                color,
            }));
            entity.metadata.push(KeyValuePair {
                key: "option",
                value: region.option.clone(),
            });
            entity.metadata.push(KeyValuePair {
                key: "object",
                value: region.object.clone(),
            });
            entity
        });
        let everything = SceneEntityDeletion {
            timestamp,
            deletion_type: 1,
            id: String::new(),
        };
        Self {
            deletions: vec![everything],
            entities: objects.chain(regions).collect(),
        }
    }

    /// The way of the base, as a line just above the floor.
    pub(super) fn of_path(timestamp: Timestamp, path: &wire::BasePath) -> Self {
        let mut entity = SceneEntity::empty(timestamp, super::ROOT_FRAME, "path");
        entity.lines.push(Line {
            line_type: 0,
            pose: PoseInFrame::IDENTITY,
            thickness: 0.04,
            scale_invariant: false,
            points: path
                .points
                .iter()
                .map(|&[x, y]| Vector3 { x, y, z: 0.02 })
                .collect(),
            color: PATH_COLOR,
            colors: [],
            indices: [],
        });
        Self {
            deletions: Vec::new(),
            entities: vec![entity],
        }
    }
}

impl SceneEntity {
    fn empty(timestamp: Timestamp, frame: &str, id: &str) -> Self {
        Self {
            timestamp,
            frame_id: frame.to_owned(),
            id: id.to_owned(),
            lifetime: Timestamp { sec: 0, nsec: 0 },
            frame_locked: false,
            metadata: Vec::new(),
            arrows: Vec::new(),
            cubes: Vec::new(),
            spheres: Vec::new(),
            cylinders: Vec::new(),
            lines: Vec::new(),
            triangles: Vec::new(),
            texts: Vec::new(),
            models: [],
        }
    }

    fn add(&mut self, geometry: &wire::Geometry, pose: PoseInFrame, color: Color) {
        let solid = |half: [f64; 3]| Solid {
            pose,
            size: Vector3::new(half.map(|edge| 2.0 * edge)),
            color,
        };
        let ball_at = |pose, radius: f64| Solid {
            pose,
            size: Vector3::new([2.0 * radius; 3]),
            color,
        };
        let cylinder = |radius: f64, half_length: f64| Cylinder {
            pose,
            size: Vector3::new([2.0 * radius, 2.0 * radius, 2.0 * half_length]),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        };
        match geometry {
            wire::Geometry::Box { half_extents_m } => self.cubes.push(solid(*half_extents_m)),
            wire::Geometry::Sphere { radius_m } => self.spheres.push(ball_at(pose, *radius_m)),
            wire::Geometry::Ellipsoid { radii_m } => self.spheres.push(solid(*radii_m)),
            wire::Geometry::Cylinder {
                radius_m,
                half_length_m,
            } => {
                self.cylinders.push(cylinder(*radius_m, *half_length_m));
            }
            wire::Geometry::Capsule {
                radius_m,
                half_length_m,
            } => {
                self.cylinders.push(cylinder(*radius_m, *half_length_m));
                self.spheres
                    .push(ball_at(pose.moved_along_z(*half_length_m), *radius_m));
                self.spheres
                    .push(ball_at(pose.moved_along_z(-half_length_m), *radius_m));
            }
            wire::Geometry::Plane {
                half_extents_m: [x, y],
            } => {
                // A plane without end becomes one as large as a house.
                let half = |edge: f64| if edge > 0.0 { edge } else { 20.0 };
                self.cubes.push(solid([half(*x), half(*y), 5e-4]));
            }
            wire::Geometry::Mesh {
                vertices,
                triangles,
            } => self.triangles.push(TriangleList {
                pose,
                points: vertices
                    .chunks_exact(3)
                    .map(|v| Vector3 {
                        x: v[0].into(),
                        y: v[1].into(),
                        z: v[2].into(),
                    })
                    .collect(),
                color,
                colors: [],
                indices: triangles.clone(),
            }),
        }
    }
}
