use super::*;
use crate::test_scene::{Scene, at, bottle, camera};

#[test]
fn the_cloud_of_several_views_lies_on_the_surfaces() {
    let mut cloud = HomeCloud::new(0.03, 3.0);
    let place_in_map = at([2.0, 0.0, 0.0], [0.0; 3]);
    for (i, base) in [
        at([0.5, 0.0, 0.0], [0.0; 3]),
        at([3.4, 0.0, 0.0], [0.0, 0.0, 3.1]),
        at([2.0, 1.3, 0.0], [0.0, 0.0, -1.6]),
    ]
    .iter()
    .enumerate()
    {
        let scene = Scene {
            things: vec![(bottle(), base.inverse() * place_in_map, "bottle")],
            sigma_m: 0.001,
        };
        assert!(cloud.add(base, &scene.look(&camera(0.6), i as u64), |_| true) > 1000);
    }
    let points = cloud.to_cloud(2);
    assert!(points.len() > 300 && points.len() <= cloud.len());
    let n_bottle = points
        .points()
        .iter()
        .filter(|p| {
            let off_axis_m = (p.x - 2.0).hypot(p.y);
            assert!(
                p.z.abs() < 0.02 || off_axis_m < 0.05,
                "{p} is neither floor nor bottle"
            );
            p.z > 0.03
        })
        .count();
    assert!(n_bottle > 10, "{n_bottle}");
}

#[test]
fn far_and_unwanted_points_are_left_out() {
    let frame = Scene {
        things: vec![(bottle(), at([1.2, 0.0, 0.0], [0.0; 3]), "bottle")],
        sigma_m: 0.0,
    }
    .look(&camera(0.5), 1);
    let mut near = HomeCloud::new(0.05, 0.5);
    assert_eq!(near.add(&Pose::identity(), &frame, |_| true), 0);
    assert!(near.is_empty());
    let mut only_bottle = HomeCloud::new(0.02, 3.0);
    only_bottle.add(&Pose::identity(), &frame, |label| label == 1);
    assert!(
        only_bottle
            .to_cloud(1)
            .points()
            .iter()
            .all(|p| (p.x - 1.2).hypot(p.y) < 0.04)
    );
    let nowhere = Pose::translation(f64::NAN, 0.0, 0.0);
    assert_eq!(only_bottle.add(&nowhere, &frame, |_| true), 0);
}

#[test]
fn a_stored_cloud_is_gone_on_from() {
    let frame = Scene {
        things: vec![(bottle(), at([1.2, 0.0, 0.0], [0.0; 3]), "bottle")],
        sigma_m: 0.0,
    }
    .look(&camera(0.5), 1);
    let mut first = HomeCloud::new(0.03, 3.0);
    first.add(&Pose::identity(), &frame, |_| true);
    let stored = first.to_cloud(1);
    let mut again = HomeCloud::from_cloud(0.03, 3.0, &stored);
    assert_eq!(again.to_cloud(1), stored);
    again.add(&Pose::identity(), &frame, |_| true);
    assert_eq!(
        again.len(),
        first.len(),
        "the same surfaces fall into the same voxels"
    );
    let broken = PointCloud::new(vec![Point3::new(f64::NAN, 0.0, 0.0)]);
    assert!(HomeCloud::from_cloud(0.03, 3.0, &broken).is_empty());
}

#[test]
fn what_is_near_is_what_is_near_in_the_whole_cloud() {
    let scene = Scene {
        things: vec![(bottle(), at([1.2, 0.1, 0.0], [0.0; 3]), "bottle")],
        sigma_m: 0.001,
    };
    let mut cloud = HomeCloud::new(0.03, 3.0);
    cloud.add(
        &at([0.0; 3], [0.0; 3]),
        &scene.look(&camera(0.6), 1),
        |_| true,
    );
    let (place, radius_m) = (nalgebra::Point2::new(1.2, 0.0), 0.3);
    let is_near = |p: &nalgebra::Point3<f64>| (p.xy() - place).norm() < radius_m;
    let all: Vec<_> = cloud
        .to_cloud(1)
        .points()
        .iter()
        .copied()
        .filter(is_near)
        .collect();
    let near: Vec<_> = cloud.near(&place, radius_m).filter(is_near).collect();
    assert!(near.len() > 100 && near.len() < cloud.len());
    assert_eq!(near, all);
}

#[test]
fn what_was_taken_away_is_gone_once_seen_through() {
    let base = Pose::identity();
    let at_front = at([0.9, 0.0, 0.0], [0.0; 3]);
    let behind = at([1.3, 0.0, 0.0], [0.0; 3]);
    let look = |places: &[Pose], seed| {
        let things = places.iter().map(|place| (bottle(), *place, "bottle"));
        let scene = Scene {
            things: things.collect(),
            sigma_m: 0.002,
        };
        scene.look(&camera(0.8), seed)
    };
    let n_near = |cloud: &HomeCloud, x: f64| {
        let cloud = cloud.to_cloud(1);
        let points = cloud.points().iter();
        points
            .filter(|p| p.z > 0.1 && (p.x - x).hypot(p.y) < 0.06)
            .count()
    };
    let mut cloud = HomeCloud::new(0.03, 3.0);
    cloud.add(&base, &look(&[behind], 1), |_| true);
    let n_behind = n_near(&cloud, 1.3);
    assert!(n_behind > 5, "{n_behind}");
    cloud.add(&base, &look(&[at_front, behind], 2), |_| true);
    assert!(n_near(&cloud, 0.9) > 5);
    assert!(n_near(&cloud, 1.3) >= n_behind, "hidden things stay");
    cloud.add(&base, &look(&[behind], 3), |_| true);
    assert_eq!(n_near(&cloud, 0.9), 0);
    assert!(n_near(&cloud, 1.3) >= n_behind);
}
