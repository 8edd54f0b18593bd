//! What there is to draw: bodies made of shapes.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

use crate::Pose;

/// The bodies of one source; a later scene of the same source replaces it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Where these bodies come from.
    pub source: SceneSource,
    /// The bodies. Names are unique over the scenes of all sources.
    pub bodies: Vec<Body>,
}

/// Where a scene comes from, which decides how it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum SceneSource {
    /// The robot's own links.
    Robot,
    /// The home as it really is; only a simulator can send it.
    Home,
    /// Objects where the robot believes them to be; drawn see-through.
    Belief,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name by which [`State`](crate::State) moves it.
    pub name: String,
    /// World from body, until a state says otherwise.
    pub pose: Pose,
    /// Its shapes.
    pub shapes: Vec<Shape>,
}

/// A geometry fixed to a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// What it is.
    pub geometry: Geometry,
    /// Body from shape.
    pub pose: Pose,
    /// Red, green, blue (sRGB) and opacity, each 0 to 1.
    pub rgba: [f32; 4],
}

/// A geometry, centred on its own origin. Long axes lie along z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, TS)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Geometry {
    /// A cuboid.
    Box {
        /// Half its edges along x, y and z.
        half_extents_m: [f64; 3],
    },
    /// A sphere.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A cylinder capped by half spheres.
    Capsule {
        /// Radius of cylinder and caps.
        radius_m: f64,
        /// Half the length of the cylinder, caps not counted.
        half_length_m: f64,
    },
    /// A cylinder.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Half its length.
        half_length_m: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Radii along x, y and z.
        radii_m: [f64; 3],
    },
    /// A rectangle facing z.
    Plane {
        /// Half its edges along x and y; 0 means without end.
        half_extents_m: [f64; 2],
    },
    /// A triangle mesh.
    Mesh {
        /// Vertices, three coordinates each.
        vertices: Vec<f32>,
        /// Triangles, three vertex numbers each, counter-clockwise seen from outside.
        triangles: Vec<u32>,
    },
}
