//! Shapes of geoms, for those who draw them or plan around them.

/// The shape of a geom, in the geom's own frame; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub enum GeomShape {
    /// A box.
    Box {
        /// Half extents.
        half: [f64; 3],
    },
    /// A sphere.
    Sphere {
        /// Radius.
        r: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius.
        r: f64,
        /// Half the length of its cylindrical part.
        half: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        r: f64,
        /// Half its length.
        half: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Radii.
        radii: [f64; 3],
    },
    /// The plane z = 0, solid below.
    Plane,
    /// Triangles; contacts use their convex hull.
    Mesh {
        /// Vertices.
        vertices: Vec<[f32; 3]>,
        /// Triangles, as indices of vertices, counterclockwise from outside.
        faces: Vec<[u32; 3]>,
    },
    /// A height field; its heights are not copied.
    HeightField,
}
