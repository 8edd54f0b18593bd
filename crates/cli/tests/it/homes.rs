//! Home folders and maps.

use std::path::Path;

use crate::{assert_refused, factotum_in};

/// A map of 6 x 4 cells with every kind of cell, and a comment as some programs write it.
pub(crate) fn write_map(dir: &Path) {
    let mut image = b"P5\n# made by hand\n6 4\n255\n".to_vec();
    image.extend((0..24_u8).map(|index| [0, 254, 205][usize::from(index % 3)]));
    std::fs::write(dir.join("house.pgm"), image).unwrap();
    std::fs::write(
        dir.join("house.yaml"),
        "image: house.pgm\nresolution: 0.05\norigin: [-1.5, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )
    .unwrap();
}

fn pixels(file: &Path) -> Vec<u8> {
    let bytes = std::fs::read(file).unwrap();
    bytes[bytes.len() - 24..].to_vec()
}

#[test]
fn a_map_comes_out_as_it_went_in() {
    let dir = tempfile::tempdir().unwrap();
    write_map(dir.path());
    let said = factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home", "--json"],
    );
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    assert_eq!(
        said.json(),
        serde_json::json!({"home": "house", "width": 6, "height": 4})
    );
    std::fs::create_dir(dir.path().join("again")).unwrap();
    let said = factotum_in(
        dir.path(),
        &["map", "export", "home", "--out", "again/map.yaml"],
    );
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let metadata = std::fs::read_to_string(dir.path().join("again/map.yaml")).unwrap();
    assert!(metadata.contains("image: map.pgm"), "{metadata}");
    let exported = dir.path().join("again/map.pgm");
    assert_eq!(pixels(&dir.path().join("house.pgm")), pixels(&exported));
}

#[test]
fn an_export_overwrites_nothing() {
    let dir = tempfile::tempdir().unwrap();
    write_map(dir.path());
    let export = |out: &str| factotum_in(dir.path(), &["map", "export", "home", "--out", out]);
    factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    let original = std::fs::read(dir.path().join("house.pgm")).unwrap();
    std::fs::rename(dir.path().join("house.yaml"), dir.path().join("other.yaml")).unwrap();
    assert_refused(&export("house.yaml"), &["`house.pgm` exists already"]);
    assert_refused(&export("other.yaml"), &["`other.yaml` exists already"]);
    assert_refused(&export("map.pgm"), &["--out is `map.pgm`", "YAML"]);
    assert_eq!(
        std::fs::read(dir.path().join("house.pgm")).unwrap(),
        original
    );
    assert_eq!(export("a.yaml").code, Some(0));
    assert_eq!(export("b.yaml").code, Some(0));
    assert!(dir.path().join("a.pgm").exists() && dir.path().join("b.pgm").exists());
}

/// A map of 6 x 4 m, with its walls and one between left and right but for a door at the top.
fn write_two_rooms(dir: &Path) {
    let mut image = b"P5\n120 80\n255\n".to_vec();
    image.extend((0..80).flat_map(|row| {
        (0..120).map(move |column| {
            let is_outer = row == 0 || row == 79 || column == 0 || column == 119;
            let is_inner = column == 60 && row > 30;
            if is_outer || is_inner { 0 } else { 254_u8 }
        })
    }));
    std::fs::write(dir.join("rooms.pgm"), image).unwrap();
    std::fs::write(
        dir.join("rooms.yaml"),
        "image: rooms.pgm\nresolution: 0.05\norigin: [-3.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )
    .unwrap();
}

#[test]
fn a_path_of_the_base_leads_around_the_wall() {
    let dir = tempfile::tempdir().unwrap();
    write_two_rooms(dir.path());
    let map = |arguments: &[&str]| factotum_in(dir.path(), arguments);
    map(&["map", "import", "rooms.yaml", "--out", "home"]);
    let path = ["map", "path", "home", "--from", "-1.5", "-1", "--to"];
    let said = map(&[&path[..], &["1.5", "-1", "--json"]].concat());
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let found = said.json();
    // Straight it is 3 m; by the door's edge at (0, 0.45) m, 4.2 m and what the base keeps clear.
    let length_m = found["length_m"].as_f64().unwrap();
    assert!((4.2..5.5).contains(&length_m), "{length_m} m");
    let poses = found["map_from_base"].as_array().unwrap();
    let crosses = |pose: &&serde_json::Value| pose[0].as_f64().unwrap().abs() < 0.1;
    assert!(
        poses
            .iter()
            .filter(crosses)
            .all(|pose| pose[1].as_f64().unwrap() > 0.45)
    );

    let said = map(&[&path[..], &["1.5", "-1.95"]].concat());
    assert_eq!(said.code, Some(1), "{}", said.stderr);
    assert!(
        said.stdout
            .contains("the goal is off the map or too near to an obstacle"),
        "{}",
        said.stdout
    );
    let said = map(&[&path[..], &["inf", "0"]].concat());
    assert_refused(&said, &["--to", "inf", "two numbers, metres"]);
    let said = map(&[&path[..], &["1.5", "-1", "--robot", "panda"]].concat());
    assert_refused(&said, &["panda", "no mobile base"]);
}

#[test]
fn a_reader_that_leaves_early_is_no_fault() {
    let dir = tempfile::tempdir().unwrap();
    write_two_rooms(dir.path());
    factotum_in(
        dir.path(),
        &["map", "import", "rooms.yaml", "--out", "home"],
    );
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_factotum"));
    let mut running = program
        .args(["home", "show", "home"])
        .current_dir(dir.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(running.stdout.take());
    let said = running.wait_with_output().unwrap();
    assert_eq!(
        said.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
    assert!(
        said.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
}

#[test]
fn a_home_is_shown_and_checked() {
    let dir = tempfile::tempdir().unwrap();
    write_map(dir.path());
    factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    let said = factotum_in(dir.path(), &["home", "show", "home", "--json"]);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let shown = said.json();
    assert_eq!(shown["home"], "house");
    assert_eq!(shown["map"]["free"], 8);
    assert_eq!(shown["map"]["occupied"], 8);
    assert_eq!(shown["map"]["unknown"], 8);
    let said = factotum_in(dir.path(), &["home", "check", "home"]);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    assert!(
        said.stdout.contains("in order") && said.stdout.contains("no journal yet"),
        "{}",
        said.stdout
    );
}

#[test]
fn a_home_is_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    write_map(dir.path());
    factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    let said = factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    assert_refused(&said, &["home folder already"]);
    let said = factotum_in(
        dir.path(),
        &["map", "explore", "--headless", "--out", "home"],
    );
    assert_refused(&said, &["home folder already"]);
}

#[test]
fn an_unknown_key_in_a_home_is_named() {
    let dir = tempfile::tempdir().unwrap();
    write_map(dir.path());
    factotum_in(
        dir.path(),
        &["map", "import", "house.yaml", "--out", "home"],
    );
    let file = dir.path().join("home/home.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("colour = \"blue\"\n{text}")).unwrap();
    let said = factotum_in(dir.path(), &["home", "check", "home"]);
    assert_refused(&said, &["home.toml", "colour"]);
}
