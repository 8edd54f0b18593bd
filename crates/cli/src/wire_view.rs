//! Beliefs, plans and bodies as the wire's plain data. Everything is given in the world: the page, the recording and the
//! report draw what is believed over what is so.

use factotum_agent::{StepKind, StepState, StepView};
use factotum_descriptions::Provenance;
use factotum_geometry::frames::{pose_from_planar, xyzw_from_quat};
use factotum_geometry::{Pose, Pose2};
use factotum_physics::GeomShape;
use factotum_protocol as wire;
use factotum_semantic_map::{Aosm, Location, ObjectSource, TopologicalGraph};
use factotum_worlds::{BodyGroup, VisualBody};

/// A plan as it stands.
pub(crate) fn plan_of(steps: &[StepView], replans: u32) -> wire::Plan {
    let step = |(index, step): (usize, &StepView)| wire::PlanStep {
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
    wire::Plan {
        replans,
        steps: steps.iter().enumerate().map(step).collect(),
    }
}

/// The occupancy grid, in the world.
pub(crate) fn map_of(
    aosm: &Aosm,
    world_from_map: &Pose2,
) -> Result<wire::OccupancyMap, wire::MapError> {
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

/// Classes, objects, regions and edges, in the world.
pub(crate) fn aosm_of(aosm: &Aosm, graph: &TopologicalGraph, world_from_map: &Pose2) -> wire::Aosm {
    let lift = pose_from_planar(world_from_map, 0.0);
    let name = |index: usize| graph.nodes[index].option.to_string();
    wire::Aosm {
        classes: aosm
            .classes
            .values()
            .map(|class| wire::ObjectClass {
                name: class.name.clone(),
                actions: class
                    .actions
                    .iter()
                    .map(|action| action.name.clone())
                    .collect(),
                provenance: provenance_of(class.provenance),
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
                    (
                        Location::Loose,
                        ObjectSource::Given | ObjectSource::Seen | ObjectSource::Taught,
                    ) => aosm.states_of(object).join(", "),
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
pub(crate) fn scene_of(
    bodies: &[VisualBody],
    poses: &[Pose],
    source: wire::SceneSource,
) -> wire::Scene {
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

/// A shape; nothing for a height field, which the page cannot draw.
pub(crate) fn geometry_of(shape: &GeomShape) -> Option<wire::Geometry> {
    Some(match shape {
        GeomShape::Box { half } => wire::Geometry::Box {
            half_extents_m: *half,
        },
        GeomShape::Sphere { r } => wire::Geometry::Sphere { radius_m: *r },
        GeomShape::Capsule { r, half } => wire::Geometry::Capsule {
            radius_m: *r,
            half_length_m: *half,
        },
        GeomShape::Cylinder { r, half } => wire::Geometry::Cylinder {
            radius_m: *r,
            half_length_m: *half,
        },
        GeomShape::Ellipsoid { radii } => wire::Geometry::Ellipsoid { radii_m: *radii },
        GeomShape::Plane => wire::Geometry::Plane {
            half_extents_m: [0.0, 0.0],
        },
        GeomShape::Mesh { vertices, faces } => wire::Geometry::Mesh {
            vertices: vertices.iter().flatten().copied().collect(),
            triangles: faces.iter().flatten().copied().collect(),
        },
        GeomShape::HeightField => return None,
    })
}

/// Where a description comes from.
pub(crate) fn provenance_of(provenance: Provenance) -> wire::Provenance {
    match provenance {
        Provenance::Given => wire::Provenance::Given,
        Provenance::Taught => wire::Provenance::Taught,
        Provenance::Learned => wire::Provenance::Learned,
    }
}

/// A pose.
pub(crate) fn pose_of(pose: &Pose) -> wire::Pose {
    wire::Pose {
        position: pose.translation.vector.into(),
        orientation_xyzw: xyzw_from_quat(&pose.rotation),
    }
}

/// A pose on the floor.
pub(crate) fn planar(pose: &Pose2) -> wire::PosePlanar {
    wire::PosePlanar {
        x: pose.translation.x,
        y: pose.translation.y,
        yaw: pose.rotation.angle(),
    }
}
