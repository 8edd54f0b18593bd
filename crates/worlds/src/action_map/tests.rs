use std::path::PathBuf;

use factotum_geometry::frames::{wrap_angle, yaw_facing};
use nalgebra::Point2;

use super::*;

fn text() -> String {
    r#"{"scene": "Room2", "grid": 0.25,
        "reachable": [[1.0, 0.9, 2.0], [1.25, 0.9, 2.0], [1.25, 0.9, 2.25], [3.0, 0.9, 2.0]],
        "actions": {"Mug|+02.25|+00.90|+02.25": {"PickupObject": [[1.25, 0.9, 2.25, 90.0], [1.0, 0.9, 2.0, 90.0]]},
                    "Mug|+00.00|+00.90|+00.00": {"PickupObject": []}}}"#
        .to_owned()
}

fn read(text: &str) -> Result<ActionMap, ActionMapError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.json");
    std::fs::write(&file, text).unwrap();
    ActionMap::read(&file)
}

fn place_at(map: &ActionMap, x: f64, y: f64, yaw: f64) -> StandingPlace {
    let is_there = |place: &StandingPlace| {
        let pose = map.world_from_base(*place);
        (pose.translation.vector - Vector2::new(x, y)).norm() < 1e-9
            && wrap_angle(pose.rotation.angle() - yaw).abs() < 1e-9
    };
    map.places().find(is_there).unwrap()
}

/// Unity's x to the right is our -y, its z our x, and a turn to the right is negative.
#[test]
fn left_handed_axes_become_ours() {
    let map = read(&text()).unwrap();
    assert_eq!((map.scene(), map.cell_m()), ("Room2", 0.25));
    let mug = map.object_for("PickupObject", "Mug").unwrap();
    assert_eq!(mug.id, "Mug|+02.25|+00.90|+02.25");
    let at = mug.world_from_object.translation.vector;
    assert!((at - Vector2::new(2.25, -2.25)).norm() < 1e-12, "{at}");
    let feasible = &mug.feasible["PickupObject"];
    let straight = place_at(&map, 2.25, -1.25, -FRAC_PI_2);
    assert!(feasible.contains(&straight));
    assert!(feasible.contains(&place_at(&map, 2.0, -1.0, -FRAC_PI_2)));
    assert_eq!(feasible.len(), 2);
    // From there the robot looks at the mug.
    let base = map.world_from_base(straight);
    let facing = yaw_facing(&base.translation.vector.into(), &Point2::from(at));
    assert!(wrap_angle(facing - base.rotation.angle()).abs() < 1e-9);
    assert!(map.object_for("PickupObject", "Apple").is_none());
    assert!(map.object_for("OpenObject", "Mug").is_none());
}

#[test]
fn ways_follow_the_cells() {
    let map = read(&text()).unwrap();
    let travel_m = map.travel_m(place_at(&map, 2.0, -1.0, 0.0));
    let to = |x, y| {
        let place = place_at(&map, x, y, FRAC_PI_2);
        let idx = map.places().position(|other| other == place).unwrap();
        travel_m[idx]
    };
    assert!(to(2.0, -1.0).abs() < 1e-12);
    assert!((to(2.25, -1.25) - 0.5).abs() < 1e-12);
    assert!(to(2.0, -3.0).is_infinite());
}

#[test]
fn what_is_wrong_in_a_file_is_named() {
    let check = |found: &str, put: &str, wanted: &[&str]| {
        assert!(text().contains(found), "{found}");
        let error = read(&text().replacen(found, put, 1)).unwrap_err();
        let message = error.to_string();
        for word in wanted.iter().chain(&["map.json"]) {
            assert!(message.contains(word), "{message} lacks {word}");
        }
    };
    check(
        "[1.0, 0.9, 2.0, 90.0]",
        "[1.5, 0.9, 2.0, 90.0]",
        &["PickupObject[1]", "(1.5, 2)", "4 cells"],
    );
    check(
        "2.0, 90.0]",
        "2.0, 45.0]",
        &["PickupObject[1]", "45", "270"],
    );
    check("\"grid\": 0.25", "\"grid\": 0", &["`grid`", "above 0"]);
    check("\"grid\"", "\"gird\"", &["gird", "grid"]);
    check(
        "[3.0, 0.9, 2.0]",
        "[3.1, 0.9, 2.0]",
        &["reachable[3]", "3.1"],
    );
    check("[3.0, 0.9, 2.0]", "[1.0, 0.9, 2.0]", &["reachable[3]"]);
    check(
        "Mug|+00.00|",
        "Mug|",
        &["`Mug|+00.90|+00.00`", "CLASS|x|y|z"],
    );
    check("[3.0, 0.9, 2.0]", "[3.0, 0.9]", &["expected", "3"]);
    check("}}}", "", &["EOF"]);
    let empty = r#"{"scene": "A", "grid": 0.25, "reachable": [], "actions": {}}"#;
    let message = read(empty).unwrap_err().to_string();
    assert!(message.contains("at least one cell"), "{message}");
}

#[test]
fn folders_are_read_in_the_order_of_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, scene: &str| {
        let text = text().replace("Room2", scene);
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    assert!(matches!(
        read_folder(folder.path()),
        Err(ActionMapError::NoMaps { .. })
    ));
    write("a.json", "Room10");
    write("b.json", "Room9");
    std::fs::write(folder.path().join("README.md"), "no map").unwrap();
    let scenes = |maps: Vec<ActionMap>| -> Vec<String> {
        maps.iter().map(|map| map.scene().to_owned()).collect()
    };
    let maps = read_folder(folder.path()).unwrap();
    assert_eq!(scenes(maps), ["Room9", "Room10"]);
    write("c.json", "Room9");
    let message = read_folder(folder.path()).unwrap_err().to_string();
    assert!(
        message.contains("b.json") && message.contains("c.json"),
        "{message}"
    );
    let missing = read_folder(&PathBuf::from("no/such/folder")).unwrap_err();
    assert!(matches!(missing, ActionMapError::Read { .. }));
}
