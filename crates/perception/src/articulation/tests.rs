use super::*;
use crate::test_scene::{Scene, Shape, Solid, at, camera};
use factotum_descriptions::JointKind;

fn joint(kind: JointKind, axis: [f64; 3], origin: [f64; 3], range: [f64; 2]) -> ObjectJoint {
    ObjectJoint {
        name: "hinge".to_owned(),
        kind,
        axis,
        origin,
        range,
        link: "link".to_owned(),
    }
}

/// A cupboard with a door 40 cm wide, hinged at its left front edge, that opens towards +x.
fn cupboard() -> (ObjectJoint, Solid, Solid) {
    let hinge = joint(
        JointKind::Revolute,
        [0.0, 0.0, 1.0],
        [0.21, 0.2, 0.0],
        [0.0, 1.8],
    );
    let body = Solid(vec![(
        at([0.0, 0.0, 0.3], [0.0; 3]),
        Shape::Box([0.2, 0.2, 0.3]),
    )]);
    let door = Solid(vec![
        (at([0.21, 0.0, 0.3], [0.0; 3]), Shape::Box([0.01, 0.2, 0.3])),
        (
            at([0.24, -0.15, 0.3], [0.0; 3]),
            Shape::Box([0.02, 0.01, 0.06]),
        ),
    ]);
    (hinge, body, door)
}

/// What the camera sees of an object with its joint at `position`, and where its root is.
fn look(
    joint: &ObjectJoint,
    fixed: &Solid,
    moving: &Solid,
    position: f64,
) -> (Vec<Point3<f64>>, Pose) {
    let root = at([1.3, 0.0, 0.4], [0.0, 0.0, 2.9]);
    let moved = moving.moved(&joint.motion(0.0, position));
    let scene = Scene {
        things: vec![(fixed.clone(), root, "it"), (moved, root, "it")],
        sigma_m: 0.002,
    };
    let frame = scene.look(&camera(0.4), 1);
    (
        frame.cloud_in_base(|label| label > 0).points().to_vec(),
        root,
    )
}

fn model(joint: &ObjectJoint, fixed: &Solid, moving: &Solid) -> ArticulatedModel {
    ArticulatedModel::new(joint.clone(), &fixed.surface(0.01), &moving.surface(0.01)).unwrap()
}

#[test]
fn a_door_is_read_within_two_degrees() {
    let (hinge, body, door) = cupboard();
    let model = model(&hinge, &body, &door);
    for truth in [0.0, 0.15, 0.7, 1.2, 1.75] {
        let (points, root) = look(&hinge, &body, &door, truth);
        let found = model
            .joint_state_from_cloud(&points, &root, &ArticulationParams::default())
            .unwrap();
        assert!((found.position - truth).abs() < 0.035, "{truth}: {found:?}");
        assert!(
            found.rms_m < 0.01 && found.n_moving_points > 50,
            "{found:?}"
        );
    }
}

#[test]
fn a_drawer_is_read_within_a_centimetre() {
    let slide = joint(JointKind::Prismatic, [1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.3]);
    let body = Solid(vec![(
        at([0.0, 0.0, 0.2], [0.0; 3]),
        Shape::Box([0.2, 0.2, 0.2]),
    )]);
    let drawer = Solid(vec![(
        at([0.01, 0.0, 0.3], [0.0; 3]),
        Shape::Box([0.2, 0.18, 0.06]),
    )]);
    let model = model(&slide, &body, &drawer);
    for truth in [0.02, 0.1, 0.28] {
        let (points, root) = look(&slide, &body, &drawer, truth);
        let found = model
            .joint_state_from_cloud(&points, &root, &ArticulationParams::default())
            .unwrap();
        assert!((found.position - truth).abs() < 0.01, "{truth}: {found:?}");
    }
}

#[test]
fn a_small_pose_error_of_the_root_shifts_the_reading_little() {
    let (hinge, body, door) = cupboard();
    let model = model(&hinge, &body, &door);
    let (points, root) = look(&hinge, &body, &door, 0.9);
    let off = root * at([0.006, -0.006, 0.004], [0.0, 0.0, 0.01]);
    let found = model
        .joint_state_from_cloud(&points, &off, &ArticulationParams::default())
        .unwrap();
    assert!((found.position - 0.9).abs() < 0.08, "{found:?}");
}

#[test]
fn a_round_knob_does_not_tell_its_turn() {
    let knob = joint(JointKind::Revolute, [0.0, 0.0, 1.0], [0.0; 3], [0.0, 3.0]);
    let plate = Solid(vec![(
        at([0.0, 0.0, -0.01], [0.0; 3]),
        Shape::Box([0.1, 0.1, 0.01]),
    )]);
    let grip = Solid(vec![(
        at([0.0, 0.0, 0.03], [0.0; 3]),
        Shape::Cylinder(0.04, 0.03),
    )]);
    let (points, root) = look(&knob, &plate, &grip, 1.0);
    let error = model(&knob, &plate, &grip)
        .joint_state_from_cloud(&points, &root, &ArticulationParams::default())
        .unwrap_err();
    assert!(
        matches!(&error, ArticulationError::NotObservable { joint, .. } if joint == "hinge"),
        "{error}"
    );
}

#[test]
fn bad_input_is_refused_by_name() {
    let (hinge, body, door) = cupboard();
    let whole = model(&hinge, &body, &door);
    let error = whole
        .joint_state_from_cloud(
            &[Point3::origin(); 3],
            &Pose::identity(),
            &ArticulationParams::default(),
        )
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "3 points seen of the object with joint `hinge`, expected at least 10"
    );
    let nan = vec![Point3::new(f64::NAN, 0.0, 0.0); 30];
    assert!(
        whole
            .joint_state_from_cloud(&nan, &Pose::identity(), &ArticulationParams::default())
            .is_err()
    );
    let surface = door.surface(0.02);
    let refused = |joint: ObjectJoint| {
        ArticulatedModel::new(joint, &surface, &surface)
            .unwrap_err()
            .to_string()
    };
    assert!(
        refused(ObjectJoint {
            range: [1.0, 0.0],
            ..hinge.clone()
        })
        .starts_with("joint `hinge` has range [1.0, 0.0]")
    );
    assert!(
        refused(ObjectJoint {
            axis: [0.0; 3],
            ..hinge.clone()
        })
        .contains("axis with a length")
    );
    let empty = ArticulatedModel::new(hinge, &surface, &PointCloud::default()).unwrap_err();
    assert_eq!(
        empty.to_string(),
        "joint `hinge` moves a link without surface points"
    );
}
