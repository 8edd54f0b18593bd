//! A chore with things of which the robot knows only what a person has taught it, starting from nothing but a map.
//!
//! The edits are those that the page sends for its own defaults: a bottle and a bin made of shapes and put down where
//! they are, to a centimetre; a grasp from the side; "throw away" with the release 8 cm over the rim.

use factotum_descriptions::{ActionSpec, Form, Grasp, Provenance, parse_toml};
use factotum_geometry::{Pose, Pose2};
use factotum_semantic_map::{Aosm, Edit, Home, Location, MapObject, ObjectSource};
use factotum_worlds::SimRobot;
use nalgebra::{Translation3, Vector2};

use crate::known_home::{do_chore, household, true_map};

/// In the living room, not far from the table, facing it.
fn at_the_table() -> Pose2 {
    Pose2::new(Vector2::new(2.2, 3.2), std::f64::consts::FRAC_PI_2)
}

/// An object put down by a person, one centimetre beside where it is.
fn put_down(class: &str, world_from_object: Pose) -> Edit {
    Edit::AddObject(MapObject {
        name: format!("{class}_1"),
        class: class.to_owned(),
        map_from_object: Translation3::new(0.007, -0.007, 0.0) * world_from_object,
        joints: Default::default(),
        location: Location::Loose,
        source: ObjectSource::Taught,
        position_std_m: 0.02,
    })
}

fn side() -> Grasp {
    let half_pi = std::f64::consts::FRAC_PI_2;
    Grasp {
        name: "side".to_owned(),
        xyz: [0.0, 0.0, 0.09],
        rpy: [half_pi, 0.0, half_pi],
        aperture_m: 0.095,
        link: None,
        yaw_symmetric: true,
        provenance: Provenance::Taught,
    }
}

/// Straight down on the lid.
fn above() -> Grasp {
    Grasp {
        name: "above".to_owned(),
        xyz: [0.0, 0.0, 0.17],
        rpy: [std::f64::consts::PI, 0.0, 0.0],
        ..side()
    }
}

fn throw_away() -> ActionSpec {
    let text = r#"
        name = "throw_away"
        kind = "pick_place"
        target_class = "bin"
        place = { xyz = [0.0, 0.0, 0.41] }
        approach = { distance_m = [0.55, 0.85], bearing_rad = [-3.1415927, 3.1415927] }
        place_approach = { distance_m = [0.62, 0.88], bearing_rad = [-3.1415927, 3.1415927] }
        provenance = "taught"
    "#;
    parse_toml(text, "throw_away.toml".as_ref()).unwrap()
}

fn lesson(sim: &SimRobot) -> Vec<Edit> {
    let bin = Form::Box {
        size_m: [0.32, 0.32, 0.33],
    };
    let bottle = Form::Cylinder {
        diameter_m: 0.065,
        height_m: 0.2,
    };
    let make = |name: &str, form: Form, movable: bool| Edit::MakeClass {
        name: name.to_owned(),
        form,
        movable,
    };
    let at = |object: &str| sim.world_from_object(object).unwrap();
    let put_grasp = |grasp: Grasp| Edit::PutGrasp {
        class: "bottle".to_owned(),
        grasp,
    };
    vec![
        make("bin", bin, false),
        put_down("bin", at("bin_1")),
        make("bottle", bottle, true),
        put_down("bottle", at("bottle_1")),
        put_grasp(side()),
        put_grasp(above()),
        Edit::PutAction {
            class: "bottle".to_owned(),
            action: Box::new(throw_away()),
        },
    ]
}

#[test]
fn a_taught_bottle_is_thrown_away() {
    let mut sim = household(1, at_the_table());
    let map = Aosm::new([], true_map(&sim).grid);
    let dir = tempfile::tempdir().unwrap();
    let mut home = Home::create(dir.path(), "household", &map, 0.0).unwrap();
    for edit in lesson(&sim) {
        home.edit(&edit, "page", 1.0).unwrap();
    }
    let report = do_chore(
        &mut sim,
        home.aosm().clone(),
        at_the_table(),
        "bottle",
        "throw_away",
    );
    assert!(report.is_believed_done, "{report:?}");
    let verdict = sim.judge().achieved("throw-away-bottle").unwrap();
    assert!(verdict.achieved, "{}", verdict.measured);
}
