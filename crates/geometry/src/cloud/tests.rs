use super::ply::{PlyEncoding, PlyError, format_ply, parse_ply};
use super::*;
use proptest::prelude::*;

prop_compose! {
    fn cloud(with_normals: bool)(rows in prop::collection::vec(prop::array::uniform6(-3.0..3.0f64), 0..60)) -> PointCloud {
        let points = rows.iter().map(|r| Point3::new(r[0], r[1], r[2])).collect();
        if !with_normals {
            return PointCloud::new(points);
        }
        let normals = rows
            .iter()
            .map(|r| Unit::try_new(Vector3::new(r[3], r[4], r[5]), 1e-6).unwrap_or_else(Vector3::z_axis))
            .collect();
        PointCloud::with_normals(points, normals).unwrap()
    }
}

proptest! {
    #[test]
    fn nearest_points_equal_those_of_exhaustive_search(cloud in cloud(false), q in prop::array::uniform3(-3.0..3.0f64), k in 1..8usize, radius in 0.1..2.0f64) {
        let query = Point3::from(q);
        let tree = NearestPoints::new(cloud.points());
        let mut order: Vec<usize> = (0..cloud.len()).collect();
        order.sort_by(|&a, &b| (cloud.points()[a] - query).norm().total_cmp(&(cloud.points()[b] - query).norm()));
        prop_assert_eq!(tree.nearest(&query).map(|n| n.0), order.first().copied());
        prop_assert_eq!(tree.nearest_within(&query, radius), tree.nearest(&query).filter(|n| n.1 <= radius * radius));
        prop_assert_eq!(tree.nearest_k(&query, k), order[..k.min(cloud.len())].to_vec());
        let within: Vec<usize> = (0..cloud.len()).filter(|&i| (cloud.points()[i] - query).norm() <= radius).collect();
        prop_assert_eq!(tree.within(&query, radius), within);
    }

    #[test]
    fn one_point_a_voxel_remains_whatever_the_order(cloud in cloud(true), edge in 0.05..1.0f64) {
        let small = cloud.voxel_downsampled(edge);
        let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|v| (v / edge).floor() as i64);
        let mut keys: Vec<_> = cloud.points().iter().map(key).collect();
        keys.sort_unstable();
        keys.dedup();
        prop_assert_eq!(small.len(), keys.len());
        prop_assert_eq!(small.normals().map(<[_]>::len), Some(keys.len()));
        let reversed: Vec<usize> = (0..cloud.len()).rev().collect();
        let again = cloud.select(&reversed).voxel_downsampled(edge);
        for (a, b) in small.points().iter().zip(again.points()) {
            prop_assert!((a - b).norm() < 1e-12);
        }
    }

    #[test]
    fn ply_files_round_trip_exactly(bare in cloud(false), full in cloud(true)) {
        for encoding in [PlyEncoding::Ascii, PlyEncoding::BinaryLittleEndian] {
            prop_assert_eq!(&parse_ply(&format_ply(&bare, encoding)).unwrap(), &bare);
            let read = parse_ply(&format_ply(&full, encoding)).unwrap();
            prop_assert_eq!(read.points(), full.points());
            for (a, b) in read.normals().unwrap().iter().zip(full.normals().unwrap()) {
                prop_assert!((a.into_inner() - b.into_inner()).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn ply_bytes_from_anywhere_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), cut in 0..200usize) {
        let _read = parse_ply(&bytes);
        let whole = format_ply(&PointCloud::new(vec![Point3::new(1.0, 2.0, 3.0); 3]), PlyEncoding::Ascii);
        let _read = parse_ply(&whole[..cut.min(whole.len())]);
    }
}

#[test]
fn normals_of_a_sphere_point_outward_to_the_viewpoint_side() {
    let points: Vec<_> = (0..4000)
        .map(|i| {
            let (z, turn) = (
                1.0 - 2.0 * (f64::from(i) + 0.5) / 4000.0,
                f64::from(i) * 2.399_963,
            );
            let r = (1.0 - z * z).sqrt();
            Point3::new(r * turn.cos(), r * turn.sin(), z)
        })
        .collect();
    let viewpoint = Point3::new(5.0, 0.0, 0.0);
    let cloud = PointCloud::new(points)
        .with_estimated_normals(10, &viewpoint)
        .unwrap();
    let normals = cloud.normals().unwrap();
    for (p, n) in cloud.points().iter().zip(normals) {
        assert!(n.dot(&p.coords).abs() > 0.99, "normal {n:?} at {p}");
        assert!(n.dot(&(viewpoint - p)) >= 0.0);
    }
    // The visible half looks outward.
    assert!(
        cloud
            .points()
            .iter()
            .zip(normals)
            .filter(|(p, _)| p.x > 0.3)
            .all(|(p, n)| n.dot(&p.coords) > 0.99)
    );
}

#[test]
fn normals_of_degenerate_clouds_are_finite_or_refused() {
    let line: Vec<_> = (0..20)
        .map(|i| Point3::new(f64::from(i), 0.0, 0.0))
        .collect();
    let viewpoint = Point3::new(0.0, 0.0, 4.0);
    for points in [line.clone(), vec![Point3::origin(); 5], vec![viewpoint; 5]] {
        let cloud = PointCloud::new(points)
            .with_estimated_normals(5, &viewpoint)
            .unwrap();
        assert!(
            cloud
                .normals()
                .unwrap()
                .iter()
                .all(|n| (n.norm() - 1.0).abs() < 1e-12)
        );
    }
    let error = PointCloud::new(line[..2].to_vec())
        .with_estimated_normals(5, &viewpoint)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "normals asked from 5 neighbours of 2 points, expected at least 3 of each"
    );
}

#[test]
fn flat_walls_with_equal_coordinates_build_a_tree() {
    // Many equal coordinates on each axis have broken k-d trees before.
    let points: Vec<_> = (0..5000)
        .map(|i| Point3::new(0.0, f64::from(i % 50) * 0.1, f64::from(i / 1000)))
        .collect();
    let tree = NearestPoints::new(&points);
    assert_eq!(tree.len(), 5000);
    let (index, m2) = tree.nearest(&Point3::new(0.3, 1.0, 2.0)).unwrap();
    assert!((m2 - 0.09).abs() < 1e-12 && points[index].z == 2.0);
}

#[test]
fn merging_and_bounds() {
    let a = PointCloud::new(vec![
        Point3::new(1.0, 5.0, -1.0),
        Point3::new(0.0, 6.0, 2.0),
    ]);
    assert_eq!(
        a.bounds(),
        Some((Point3::new(0.0, 5.0, -1.0), Point3::new(1.0, 6.0, 2.0)))
    );
    assert_eq!(a.centroid(), Some(Point3::new(0.5, 5.5, 0.5)));
    assert_eq!(PointCloud::default().bounds(), None);
    assert_eq!(PointCloud::default().centroid(), None);
    assert_eq!(a.clone().merged(PointCloud::default()), a);
    assert_eq!(a.clone().merged(a.clone()).len(), 4);
    let error = PointCloud::with_normals(a.points().to_vec(), Vec::new()).unwrap_err();
    assert_eq!(error.to_string(), "cloud has 2 points but 0 normals");
}

#[test]
fn malformed_ply_files_say_what_is_wrong() {
    let message = |text: &str| parse_ply(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(message("obj\n"), "file does not start with `ply`");
    assert_eq!(
        message("ply\nformat ascii 1.0\n"),
        "PLY header has no `end_header` line"
    );
    assert_eq!(
        message("ply\nformat binary_big_endian 1.0\nend_header\n"),
        "PLY header line 2 is `format binary_big_endian 1.0`, expected `format ascii 1.0` or `format binary_little_endian 1.0`"
    );
    let head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n";
    assert_eq!(
        message(&format!("{head}end_header\n")),
        r#"PLY vertices have properties ["x", "y"], expected x, y and z among them"#
    );
    let head = format!("{head}property float z\nend_header\n");
    assert_eq!(
        message(&format!("{head}1 2 3\n4 5\n")),
        "PLY data end in element `vertex` at row 1 of 2"
    );
    assert_eq!(
        message(&format!("{head}1 2 3\n4 five 6\n")),
        "PLY element `vertex` row 1 has `five`, expected a number"
    );
    assert!(matches!(parse_ply(b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nproperty double x\nproperty double y\nproperty double z\nend_header\n123"), Err(PlyError::Truncated { row: 0, .. })));
}

#[test]
fn other_elements_and_lists_before_the_vertices_are_passed_over() {
    let text = "ply\r\nformat ascii 1.0\r\nelement face 2\r\nproperty list uchar int vertex_indices\r\nelement vertex 1\r\n\
                property uchar red\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nend_header\r\n3 0 1 2\r\n0\r\n255 1 2 3\r\n";
    assert_eq!(
        parse_ply(text.as_bytes()).unwrap().points(),
        [Point3::new(1.0, 2.0, 3.0)]
    );
}

/// Handle clouds written by Open3D, where the shared data are at hand.
#[test]
fn real_handle_clouds_read_with_unit_normals() {
    let folder = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/cip_grasps"
    );
    for (name, n_points) in [
        ("door", 563),
        ("drawer", 179),
        ("lever", 72),
        ("slide", 137),
    ] {
        let path = format!("{folder}/{name}_handle.ply");
        let Ok(bytes) = std::fs::read(&path) else {
            #[expect(clippy::print_stderr, reason = "a skipped test says so")]
            {
                eprintln!("skipped: no {path}");
            }
            return;
        };
        let cloud = parse_ply(&bytes).unwrap();
        assert_eq!(cloud.len(), n_points);
        assert_eq!(cloud.normals().unwrap().len(), n_points);
        assert_eq!(
            parse_ply(&format_ply(&cloud, PlyEncoding::BinaryLittleEndian))
                .unwrap()
                .points(),
            cloud.points()
        );
        let (low, high) = cloud.bounds().unwrap();
        assert!(
            (high - low).norm() < 1.0,
            "a handle is smaller than a metre"
        );
    }
}
