//! The true occupancy of a home at the height of the lidar, for measuring how good a map is. Nothing that decides may
//! read it.

use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, CellIndex, OccupancyGrid};
use factotum_physics::{GeomId, GeomShape, State};
use nalgebra::{Point2, Point3};

use crate::WorldError;
use crate::assembly::Assembly;
use crate::scene::Bounds;

/// Cells whose centre is inside a solid at `height_m` are occupied, those that the robot's start can be reached from
/// without crossing one are free, all others unknown. The robot and what can be carried away are left out.
pub(crate) fn true_grid(
    assembly: &Assembly,
    state: &State,
    bounds: &Bounds,
    start: Point2<f64>,
    height_m: f64,
    resolution_m: f64,
) -> Result<OccupancyGrid, WorldError> {
    let cells_along = |axis: usize| {
        let length = bounds.max[axis] - bounds.min[axis];
        (length / resolution_m).ceil().max(1.0) as usize
    };
    let origin = Pose2::translation(bounds.min[0], bounds.min[1]);
    let mut grid = OccupancyGrid::filled(
        cells_along(0),
        cells_along(1),
        resolution_m,
        origin,
        Cell::UNKNOWN,
    )?;
    let solids = solids(assembly, state);
    let indices: Vec<CellIndex> = grid.indices().collect();
    for index in indices {
        let centre = grid.center_of(index);
        let point = Point3::new(centre.x, centre.y, height_m);
        if solids.iter().any(|solid| solid.contains(&point)) {
            grid.set_cell(index, Cell::OCCUPIED);
        }
    }
    if let Some(index) = grid.index_at(&start) {
        flood(&mut grid, index);
    }
    Ok(grid)
}

fn flood(grid: &mut OccupancyGrid, start: CellIndex) {
    let mut open = vec![start];
    while let Some(index) = open.pop() {
        if !grid.cell(index).is_unknown() {
            continue;
        }
        grid.set_cell(index, Cell::FREE);
        open.extend(grid.edge_neighbours(index));
    }
}

struct Solid {
    world_from_solid: factotum_geometry::Pose,
    shape: GeomShape,
}

fn solids(assembly: &Assembly, state: &State) -> Vec<Solid> {
    let model = &assembly.model;
    let left_out: Vec<GeomId> = assembly
        .robot
        .geoms
        .iter()
        .chain(
            assembly
                .objects
                .iter()
                .filter(|object| object.movable)
                .flat_map(|object| &object.geoms),
        )
        .copied()
        .collect();
    model
        .geoms()
        .filter(|geom| model.geom_collides(*geom) && !left_out.contains(geom))
        .map(|geom| Solid {
            world_from_solid: state.world_from_geom(geom),
            shape: model.geom_shape(geom),
        })
        .collect()
}

impl Solid {
    fn contains(&self, point_in_world: &Point3<f64>) -> bool {
        let p = self
            .world_from_solid
            .inverse_transform_point(point_in_world);
        let radial = p.x.hypot(p.y);
        match &self.shape {
            GeomShape::Box { half } => (0..3).all(|i| p[i].abs() <= half[i]),
            GeomShape::Sphere { r } => p.coords.norm() <= *r,
            GeomShape::Cylinder { r, half } => radial <= *r && p.z.abs() <= *half,
            GeomShape::Capsule { r, half } => radial.hypot((p.z.abs() - half).max(0.0)) <= *r,
            GeomShape::Ellipsoid { radii } => {
                (0..3).map(|i| (p[i] / radii[i]).powi(2)).sum::<f64>() <= 1.0
            }
            GeomShape::Plane => p.z <= 0.0,
            // Homes are made of primitives; a mesh counts as the box around it.
            GeomShape::Mesh { vertices, .. } => (0..3).all(|i| {
                let values = vertices.iter().map(|vertex| f64::from(vertex[i]));
                let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(v), h.max(v))
                });
                (low..=high).contains(&p[i])
            }),
            GeomShape::HeightField => false,
        }
    }
}
