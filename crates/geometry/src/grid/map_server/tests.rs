use super::super::CellIndex;
use super::*;
use proptest::prelude::*;

const YAML: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.5, 2.0, 0.3]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn map(mode: MapMode, negate: bool, maxval: u16, pixels: &[u16]) -> StoredMap {
    let mut metadata = MapMetadata::parse(YAML).unwrap();
    metadata.mode = mode;
    metadata.negate = negate;
    let text: Vec<String> = pixels.iter().map(ToString::to_string).collect();
    let pgm = format!("P2\n{} 1\n{maxval}\n{}\n", pixels.len(), text.join(" "));
    StoredMap {
        metadata,
        image: GrayImage::parse_pgm(pgm.as_bytes()).unwrap(),
    }
}

fn values(map: &StoredMap) -> Vec<i8> {
    map.checked_grid()
        .unwrap()
        .cells()
        .iter()
        .map(|cell| cell.to_ros())
        .collect()
}

#[test]
fn pixels_mean_what_map_server_says() {
    // p = 1 - v/255: occupied from v = 89 down, free from v = 206 up (205 gives 0.19608 > 0.196).
    let pixels = [0, 89, 90, 205, 206, 254, 255];
    assert_eq!(
        values(&map(MapMode::Trinary, false, 255, &pixels)),
        [100, 100, -1, -1, 0, 0, 0]
    );
    assert_eq!(
        values(&map(MapMode::Trinary, true, 255, &pixels)),
        [0, -1, -1, 100, 100, 100, 100]
    );
    assert_eq!(
        values(&map(MapMode::Scale, false, 255, &pixels)),
        [100, 100, 99, 0, 0, 0, 0]
    );
    assert_eq!(values(&map(MapMode::Scale, false, 255, &[147])), [50]);
    assert_eq!(
        values(&map(MapMode::Raw, false, 255, &[0, 50, 100, 101, 255])),
        [0, 50, 100, -1, -1]
    );
    // 16 bits: the same shades.
    assert_eq!(
        values(&map(MapMode::Trinary, false, 65535, &[0, 65535, 205 * 257])),
        [100, 0, -1]
    );
    assert_eq!(values(&map(MapMode::Raw, false, 65535, &[7, 300])), [7, -1]);
}

#[test]
fn the_top_row_of_the_image_is_the_highest_y() {
    let mut stored = map(MapMode::Trinary, false, 255, &[0]);
    stored.image = GrayImage::parse_pgm(b"P2\n2 2\n255\n0 254\n205 254\n").unwrap();
    let grid = stored.checked_grid().unwrap();
    assert!(grid.cell(CellIndex { column: 0, row: 1 }).is_occupied());
    assert_eq!(grid.cell(CellIndex { column: 0, row: 0 }), Cell::UNKNOWN);
    assert!((grid.world_from_grid().rotation.angle() - 0.3).abs() < 1e-15);
}

fn any_map() -> impl Strategy<Value = StoredMap> {
    let mode = prop_oneof![
        Just(MapMode::Trinary),
        Just(MapMode::Scale),
        Just(MapMode::Raw)
    ];
    (
        mode,
        any::<bool>(),
        prop_oneof![Just(255u16), Just(65535), Just(100), 1..=65535u16],
        1..9usize,
        1..9usize,
    )
        .prop_flat_map(|(mode, negate, maxval, width, height)| {
            let pixels = prop::collection::vec(0..=maxval, width * height);
            let numbers = (
                1e-3..10.0f64,
                prop::array::uniform3(-9.0..9.0f64),
                0.1..0.4f64,
                0.5..0.9f64,
                any::<bool>(),
                any::<bool>(),
            );
            (pixels, numbers).prop_map(
                move |(
                    pixels,
                    (resolution_m, origin, free_thresh, occupied_thresh, text, has_mode_key),
                )| {
                    let mut pgm = format!(
                        "{}\n# a comment\n{width} {height}\n{maxval}\n",
                        if text { "P2" } else { "P5" }
                    )
                    .into_bytes();
                    for pixel in pixels {
                        if text {
                            pgm.extend_from_slice(format!("{pixel} ").as_bytes());
                        } else if maxval > 255 {
                            pgm.extend_from_slice(&pixel.to_be_bytes());
                        } else {
                            pgm.push(pixel as u8);
                        }
                    }
                    let metadata = MapMetadata {
                        image: PathBuf::from("it's a map.pgm"),
                        resolution_m,
                        origin,
                        negate,
                        occupied_thresh,
                        free_thresh,
                        mode,
                        has_mode_key: has_mode_key || mode != MapMode::Trinary,
                    };
                    StoredMap {
                        metadata,
                        image: GrayImage::parse_pgm(&pgm).unwrap(),
                    }
                },
            )
        })
}

proptest! {
    #[test]
    fn metadata_and_images_round_trip(map in any_map()) {
        prop_assert_eq!(&MapMetadata::parse(&map.metadata.to_yaml()).unwrap(), &map.metadata);
        prop_assert_eq!(&GrayImage::parse_pgm(&map.image.to_pgm()).unwrap(), &map.image);
    }

    #[test]
    fn updating_with_the_own_grid_changes_nothing(map in any_map()) {
        let mut updated = map.clone();
        updated.update(&map.checked_grid().unwrap()).unwrap();
        prop_assert_eq!(updated, map);
    }

    #[test]
    fn updates_change_only_the_cells_that_changed(map in any_map(), pick in 0..64usize, state in 0..3usize) {
        prop_assume!(map.image.maxval() >= 100);
        prop_assume!(map.metadata.mode != MapMode::Scale || state != 2); // scale cannot say unknown
        let mut grid = map.checked_grid().unwrap();
        let index = CellIndex { column: pick % grid.width(), row: pick / 8 % grid.height() };
        grid.set_cell(index, [Cell::FREE, Cell::OCCUPIED, Cell::UNKNOWN][state]);
        prop_assume!(map.metadata.mode != MapMode::Raw || map.image.maxval() > 100 || state != 2);
        let mut updated = map.clone();
        updated.update(&grid).unwrap();
        let n_changed = updated.image.pixels().iter().zip(map.image.pixels()).filter(|(a, b)| a != b).count();
        prop_assert!(n_changed <= 1);
        prop_assert_eq!(updated.checked_grid().unwrap(), grid);
    }

    #[test]
    fn grids_survive_being_stored(map in any_map()) {
        let grid = map.checked_grid().unwrap();
        for mode in [MapMode::Trinary, MapMode::Raw] {
            let stored = StoredMap::from_grid_in_mode(&grid, "map.pgm", mode).checked_grid().unwrap();
            let same = |a: &Cell, b: &Cell| if mode == MapMode::Raw { a == b } else { a.state() == b.state() };
            prop_assert!(stored.cells().iter().zip(grid.cells()).all(|(a, b)| same(a, b)));
            prop_assert!((stored.world_from_grid().translation.vector - grid.world_from_grid().translation.vector).norm() < 1e-12);
        }
    }

    #[test]
    fn bytes_from_anywhere_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..120), text in "\\PC{0,120}") {
        let _read = GrayImage::parse_pgm(&[b"P5 3 3 255 ".as_slice(), &bytes].concat());
        let _read = GrayImage::parse_pgm(&bytes);
        let _read = MapMetadata::parse(&text);
    }
}

#[test]
fn metadata_forms_that_yaml_allows_are_read() {
    let text = "---\n# written by hand\nimage: \"my map.pgm\" # the floor\nresolution: 1e-1\norigin:\n  - -1.5\n  - 2\n  - 0.0\nnegate: false\nmode: raw\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
    let metadata = MapMetadata::parse(text).unwrap();
    assert_eq!(metadata.image, Path::new("my map.pgm"));
    assert_eq!(metadata.origin, [-1.5, 2.0, 0.0]);
    assert_eq!(
        (metadata.mode, metadata.negate, metadata.resolution_m),
        (MapMode::Raw, false, 0.1)
    );
}

#[test]
fn metadata_errors_name_the_thing() {
    let message = |text: &str| MapMetadata::parse(text).unwrap_err().to_string();
    let with = |from: &str, to: &str| message(&YAML.replace(from, to));
    assert_eq!(
        message(&YAML.replace("occupied_thresh", "occupied_treshold")),
        "unknown key `occupied_treshold` in line 5; did you mean `occupied_thresh`?"
    );
    assert_eq!(
        with("resolution: 0.05\n", ""),
        "key `resolution` is missing"
    );
    assert_eq!(
        with("0.05", "-0.05"),
        "`resolution` is `-0.05`, expected a positive number of metres"
    );
    assert_eq!(
        with("0.05", "nan"),
        "`resolution` is `nan`, expected a positive number of metres"
    );
    assert_eq!(
        with("[-1.5, 2.0, 0.3]", "[-1.5, 2.0]"),
        "`origin` is `[-1.5, 2.0]`, expected a list of three numbers, [x, y, yaw]"
    );
    assert_eq!(
        with("negate: 0", "negate: maybe"),
        "`negate` is `maybe`, expected 0, 1, false or true"
    );
    assert_eq!(
        with("negate: 0", "negate: 0\nmode: binary"),
        "`mode` is `binary`, expected trinary, scale or raw"
    );
    assert_eq!(
        with("negate: 0", "negate: 0\nnegate: 1"),
        "key `negate` in line 5 is given twice"
    );
    assert_eq!(
        with("negate: 0", "negate 0"),
        "line 4 is `negate 0`, expected `key: value`"
    );
    assert_eq!(
        with("0.196", "0.7"),
        "`free_thresh` 0.7 is not below `occupied_thresh` 0.65"
    );
    assert_eq!(
        with("0.196", "1.7"),
        "`free_thresh` is `1.7`, expected a number from 0 to 1"
    );
    assert_eq!(
        with("map.pgm", ""),
        "`image` is ``, expected the name of a PGM file"
    );
}

#[test]
fn image_errors_say_what_was_found_and_wanted() {
    let message = |bytes: &[u8]| GrayImage::parse_pgm(bytes).unwrap_err().to_string();
    assert_eq!(
        message(b"P5\n4 3\n255\nabcde"),
        "truncated: found 5 bytes of pixels, wanted 12 (4 x 3 at 1)"
    );
    assert_eq!(
        message(b"P5\n4 3\n65535\nabcde"),
        "truncated: found 5 bytes of pixels, wanted 24 (4 x 3 at 2)"
    );
    assert_eq!(
        message(b"P2\n2 2\n255\n1 2 3"),
        "truncated: found 3 pixels, wanted 4 (2 x 2)"
    );
    assert_eq!(
        message(b"P6\n1 1\n255\nabc"),
        "file starts with `P6`, expected `P5` or `P2`"
    );
    assert_eq!(
        message(b"P5\nwide 3\n255\n"),
        "header field `width` is `wide`, expected a whole number of columns"
    );
    assert_eq!(
        message(b"P5\n1 1\n0\na"),
        "header field `maxval` is `0`, expected a whole number from 1 to 65535"
    );
    assert_eq!(
        message(b"P2\n1 1\n9\n10"),
        "pixel 0 is `10`, expected a whole number up to 9"
    );
    assert_eq!(
        message(b"P5\n99999 99999\n255\n"),
        "header field `height` is `99999`, expected a whole number of rows"
    );
    // Comments may stand anywhere in the header; one blank ends it even when pixels look like blanks.
    let image = GrayImage::parse_pgm(b"P5# one\n2 # two\n1\n#three\n255\n\n ").unwrap();
    assert_eq!(image.pixels(), [10, 32]);
}

#[test]
fn maps_are_written_beside_their_image_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("home.yaml");
    let mut stored = map(MapMode::Trinary, false, 255, &[0, 205, 254]);
    stored.metadata.image = PathBuf::from("elsewhere/floor.pgm");
    stored.write(&path).unwrap();
    assert!(folder.path().join("floor.pgm").exists());
    let read = StoredMap::read(&path).unwrap();
    assert_eq!(read.image, stored.image);
    assert_eq!(
        read.metadata,
        MapMetadata {
            image: PathBuf::from("floor.pgm"),
            ..stored.metadata.clone()
        }
    );

    let bytes = std::fs::read(folder.path().join("floor.pgm")).unwrap();
    std::fs::write(folder.path().join("floor.pgm"), &bytes[..bytes.len() - 5]).unwrap();
    let message = StoredMap::read(&path).unwrap_err().to_string();
    assert!(
        message.contains("floor.pgm`: truncated: found"),
        "{message}"
    );
    std::fs::remove_file(folder.path().join("floor.pgm")).unwrap();
    assert!(
        StoredMap::read(&path)
            .unwrap_err()
            .to_string()
            .contains("cannot read map file")
    );
    let refused = stored
        .write(Path::new("/nonexistent/folder/home.yaml"))
        .unwrap_err();
    assert!(
        refused
            .to_string()
            .starts_with("cannot write map file `/nonexistent/folder/floor.pgm`")
    );
}

/// Maps of real buildings, where the shared data are at hand: import and export leave them unchanged.
#[test]
fn real_maps_import_and_export_unchanged() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/maps");
    let out = tempfile::tempdir().unwrap();
    for (name, size) in [
        ("willow-full", (584, 526)),
        ("willow-full-0.05", (1165, 945)),
        ("lse_arena", (80, 60)),
        ("turtlebot3_world", (384, 384)),
    ] {
        let path = PathBuf::from(format!("{folder}/{name}.yaml"));
        if !path.exists() {
            #[expect(clippy::print_stderr, reason = "a skipped test says so")]
            {
                eprintln!("skipped: no {}", path.display());
            }
            return;
        }
        let map = StoredMap::read(&path).unwrap();
        let grid = map.checked_grid().unwrap();
        assert_eq!((grid.width(), grid.height()), size);
        let [free, occupied, _] = grid.count_states();
        assert!(
            free > 1000 && occupied > 100,
            "{name}: {free} free, {occupied} occupied"
        );

        let mut updated = map.clone();
        updated.update(&grid).unwrap();
        let exported = out.path().join(format!("{name}.yaml"));
        updated.write(&exported).unwrap();
        assert_eq!(StoredMap::read(&exported).unwrap(), map);
        let bytes = |folder: &Path| std::fs::read(folder.join(format!("{name}.pgm"))).unwrap();
        assert!(
            bytes(out.path()) == bytes(Path::new(folder)),
            "{name}.pgm changed"
        );
    }
}
