//! Scene files: the household is sound, and nonsense is refused by name.

use std::path::Path;

use factotum_control::{Command, GripperGoal, Robot as _};
use factotum_descriptions::RobotDescription;
use factotum_worlds::{HomeScene, SimRobot, WorldConfig};

use crate::fixture::{assets, config, must};

#[test]
fn seeds_draw_different_homes_that_load() {
    let mut places = Vec::new();
    for seed in 0..4 {
        let robot = SimRobot::new(config(seed)).unwrap();
        let bottle = robot.world_from_object("bottle_1").unwrap();
        // On the table, upright, after coming to rest.
        assert!(
            (bottle.translation.z - 0.75).abs() < 2e-3,
            "seed {seed}: {bottle}"
        );
        assert!((bottle.rotation * nalgebra::Vector3::z()).z > 0.999);
        places.push(bottle.translation.vector);
    }
    for (i, a) in places.iter().enumerate() {
        assert!(places[..i].iter().all(|b| (a - b).norm() > 1e-3));
    }
}

/// Reads the household's file with one change, from a folder with nothing else in it.
fn changed(from: &str, to: &str) -> Result<HomeScene, String> {
    let dir = tempfile::tempdir().unwrap();
    let absolute = |path: &str| std::path::absolute(assets().join(path)).unwrap();
    let text = std::fs::read_to_string(assets().join("scenes/household/scene.toml")).unwrap();
    assert!(text.contains(from), "the household has no `{from}`");
    let text = format!(
        "objects_dir = {:?}\n{}",
        absolute("objects"),
        text.replacen(from, to, 1).replace(
            "\"structure.xml\"",
            &format!("{:?}", absolute("scenes/household/structure.xml"))
        )
    );
    let path = dir.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    HomeScene::load(dir.path()).map_err(|error| {
        let error = error.to_string();
        error.replace(&path.display().to_string(), "scene.toml")
    })
}

fn error_of(from: &str, to: &str) -> String {
    changed(from, to).unwrap_err()
}

/// Its chores stay, its classes are known; the judge says that they cannot be achieved.
#[test]
fn a_home_may_lack_what_its_chores_need() {
    let text = std::fs::read_to_string(assets().join("scenes/household/scene.toml")).unwrap();
    let objects = text
        .split("\n\n")
        .filter(|part| part.starts_with("[[objects]]"));
    for (class, chore) in [
        ("bin", "throw-away-bottle"),
        ("bottle", "throw-away-bottle"),
        ("faucet", "close-faucet"),
    ] {
        let object = objects
            .clone()
            .find(|part| part.contains(&format!("class = \"{class}\"")))
            .unwrap();
        let scene = changed(object, "").unwrap();
        assert!(scene.classes().contains_key(class));
        let robot = SimRobot::new(WorldConfig { scene, ..config(1) }).unwrap();
        let verdict = robot.judge().achieved(chore).unwrap();
        assert!(!verdict.achieved);
        assert_eq!(verdict.measured, format!("this home has no `{class}_1`"));
    }
}

#[test]
fn errors_name_file_field_found_and_wanted() {
    assert_eq!(
        error_of(
            "class = \"bottle\"\naction = \"throw_away\"",
            "class = \"bottel\"\naction = \"throw_away\""
        ),
        "`scene.toml`: `chores.throw-away-bottle.class` is `bottel`, expected one of `bin`, `bottle`, `door`, \
         `drawer`, `faucet`, `light_switch`, `microwave`; did you mean `bottle`?"
    );
    let error = error_of("spread_yaw = 3.1415927", "spread_jaw = 3.1415927");
    assert!(
        error.contains("unknown key `spread_jaw`; did you mean `spread_yaw`?"),
        "{error}"
    );
    let error = error_of("container = \"bin_1\"", "container = \"bin_2\"");
    assert!(
        error.contains("`chores.throw-away-bottle.judge.container` is `bin_2`"),
        "{error}"
    );
    let error = error_of("x = [3.0, 3.7]", "x = [3.7, 3.0]");
    assert!(
        error.contains("`robot_start.x` is [3.7, 3], expected two numbers, the smaller first"),
        "{error}"
    );
    let error = error_of("toggle = [0.40, 0.40]", "togle = [0.40, 0.40]");
    assert!(error.contains("did you mean `toggle`?"), "{error}");
}

#[test]
fn a_missing_scene_is_named() {
    let error = HomeScene::load(Path::new("no/such/home"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("no/such/home"), "{error}");
}

#[test]
fn every_robot_of_the_assets_stands_in_the_household() {
    let robots = std::fs::read_dir(assets().join("robots")).unwrap();
    let mut names: Vec<_> = robots.map(|entry| entry.unwrap().path()).collect();
    names.retain(|dir| dir.join("robot.toml").is_file());
    names.sort();
    assert!(names.len() >= 2);
    for dir in names {
        let description = RobotDescription::load(&dir).unwrap();
        let mut robot = SimRobot::new(WorldConfig {
            robot: description,
            ..config(1)
        })
        .unwrap();
        let before = robot.state().unwrap();
        robot.wait(1.0).unwrap();
        let after = robot.state().unwrap();
        for (a, b) in before.arm_positions.iter().zip(&after.arm_positions) {
            assert!((a - b).abs() < 5e-3, "{}: from {a} to {b}", dir.display());
        }
        assert!(after.gripper_opening > 0.9, "{}: {after:?}", dir.display());
        let close = Command::Gripper(GripperGoal {
            opening: 0.0,
            force_n: 10.0,
        });
        must(&mut robot, close);
        let closed = robot.state().unwrap().gripper_opening;
        assert!(closed < 0.06, "{}: {closed}", dir.display());
    }
}
