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
    let image = metadata
        .lines()
        .find_map(|line| line.strip_prefix("image: "))
        .unwrap();
    let exported = dir.path().join("again").join(image);
    assert_eq!(pixels(&dir.path().join("house.pgm")), pixels(&exported));
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
