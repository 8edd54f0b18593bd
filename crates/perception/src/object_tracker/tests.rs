use super::*;
use crate::test_scene::at;
use proptest::prelude::*;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};

fn seen(class: &str, base_from_object: Pose, distance_m: f64) -> Detection {
    Detection {
        class: class.to_owned(),
        label: 1,
        base_from_object,
        rms_m: 0.003,
        n_points: 100,
        fitness: 0.9,
        distance_m,
        is_yaw_symmetric: false,
        is_turn_sure: true,
        is_fixed: false,
    }
}

#[test]
fn many_noisy_sightings_make_one_exact_object() {
    let truth = at([2.0, 1.0, 0.8], [0.0, 0.0, 0.7]);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let unit = Normal::new(0.0, 1.0).unwrap();
    let mut tracker = ObjectTracker::new(TrackerParams::default());
    for i in 0..50 {
        let base = at([0.05 * f64::from(i), 0.2, 0.0], [0.0, 0.0, 0.3]);
        let mut noise = || unit.sample(&mut rng);
        let off = at(
            [0.02 * noise(), 0.02 * noise(), 0.02 * noise()],
            [0.0, 0.0, 0.05 * noise()],
        );
        tracker.observe(
            &base,
            0.01,
            &[seen("mug", base.inverse() * truth * off, 1.0)],
        );
    }
    let [object] = tracker.objects() else {
        panic!("{:?}", tracker.objects())
    };
    let error = object.map_from_object.inverse() * truth;
    assert!(
        error.translation.vector.norm() < 0.01 && error.rotation.angle() < 0.03,
        "{error}"
    );
    assert_eq!(object.n_seen, 50);
    assert!(object.sigma_m < 0.005);
}

#[test]
fn near_sightings_outweigh_far_ones() {
    let mut tracker = ObjectTracker::new(TrackerParams::default());
    tracker.observe(
        &Pose::identity(),
        0.0,
        &[seen("mug", at([1.0, 0.0, 0.0], [0.0; 3]), 4.0)],
    );
    tracker.observe(
        &Pose::identity(),
        0.0,
        &[seen("mug", at([1.1, 0.0, 0.0], [0.0; 3]), 0.5)],
    );
    let x = tracker.objects()[0].map_from_object.translation.x;
    assert!((1.09..1.1).contains(&x), "{x}");
}

#[test]
fn objects_apart_or_of_other_classes_stay_apart() {
    let mut tracker = ObjectTracker::new(TrackerParams::default());
    let near = [
        seen("mug", at([1.0, 0.0, 0.0], [0.0; 3]), 1.0),
        seen("mug", at([1.2, 0.0, 0.0], [0.0; 3]), 1.0),
        seen("bowl", at([1.0, 0.0, 0.0], [0.0; 3]), 1.0),
    ];
    let first = tracker.observe(&Pose::identity(), 0.0, &near);
    assert_eq!(first, [TrackId(0), TrackId(1), TrackId(2)]);
    // The same again, in another order: each goes to its own, though both mugs are within the gate of both.
    let again = tracker.observe(
        &Pose::identity(),
        0.0,
        &[near[1].clone(), near[2].clone(), near[0].clone()],
    );
    assert_eq!(again, [TrackId(1), TrackId(2), TrackId(0)]);
    let moved = tracker.observe(
        &Pose::identity(),
        0.0,
        &[seen("mug", at([3.0, 0.0, 0.0], [0.0; 3]), 1.0)],
    );
    assert_eq!(moved, [TrackId(3)]);
    assert_eq!(tracker.forget(TrackId(0)).unwrap().class, "mug");
    assert!(tracker.object(TrackId(0)).is_none() && tracker.forget(TrackId(0)).is_none());
    assert_eq!(tracker.objects().len(), 3);
}

#[test]
fn the_heading_of_round_things_is_not_averaged() {
    let mut tracker = ObjectTracker::new(TrackerParams::default());
    for yaw in [0.0, 2.0, -2.0, 3.0] {
        let detection = Detection {
            is_yaw_symmetric: true,
            ..seen("bottle", at([1.0, 0.0, 0.0], [0.1, 0.0, yaw]), 1.0)
        };
        tracker.observe(&Pose::identity(), 0.0, &[detection]);
    }
    let up = tracker.objects()[0].map_from_object.rotation * Vector3::z();
    assert!(up.z > 0.99, "{up}");
}

proptest! {
    /// The mean of two rotations lies between them, whatever their order and size.
    #[test]
    fn the_mean_rotation_lies_between(a in prop::array::uniform3(-1.5..1.5f64), b in prop::array::uniform3(-1.5..1.5f64), share in 0.0..1.0f64) {
        let (a, b) = (UnitQuaternion::from_scaled_axis(Vector3::from(a)), UnitQuaternion::from_scaled_axis(Vector3::from(b)));
        let mean = mean_rotation(&a, &b, share, false);
        let whole = a.angle_to(&b);
        prop_assert!((mean.angle_to(&a) - share * whole).abs() < 1e-6);
        prop_assert!((mean.angle_to(&b) - (1.0 - share) * whole).abs() < 1e-6);
    }
}

#[test]
fn a_sure_turn_replaces_guesses_and_no_guess_moves_it() {
    let turned = |yaw_rad: f64, is_turn_sure| Detection {
        is_turn_sure,
        ..seen("switch", at([1.0, 0.0, 1.0], [0.0, 0.0, yaw_rad]), 1.0)
    };
    let mut tracker = ObjectTracker::new(TrackerParams::default());
    let mut yaw_after = |yaw_rad, is_turn_sure| {
        let sighting = [turned(yaw_rad, is_turn_sure)];
        let ids = tracker.observe(&Pose::identity(), 0.0, &sighting);
        let object = tracker.object(ids[0]).unwrap();
        object.map_from_object.rotation.euler_angles().2
    };
    assert!((yaw_after(2.0, false) - 2.0).abs() < 1e-9);
    let between = yaw_after(1.0, false);
    assert!(between > 1.1 && between < 1.9, "{between}");
    assert!((yaw_after(0.2, true) - 0.2).abs() < 1e-9);
    assert!((yaw_after(2.0, false) - 0.2).abs() < 1e-9);
    let mean = yaw_after(0.4, true);
    assert!(mean > 0.2 && mean < 0.4, "{mean}");
}
