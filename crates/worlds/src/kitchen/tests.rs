use std::f64::consts::FRAC_PI_2;

use factotum_geometry::Pose2;
use nalgebra::{Point3, Vector2};

use super::*;
use crate::action_map::{MapObject, StandingPlace};

#[test]
fn the_same_seed_is_the_same_kitchen_and_another_is_not() {
    assert_eq!(kitchen(3).unwrap(), kitchen(3).unwrap());
    assert_ne!(kitchen(3).unwrap(), kitchen(4).unwrap());
}

/// Whatever is drawn: coffee can be made, from places near the objects, and not from all of them.
#[test]
fn coffee_can_be_made_in_all_of_them() {
    for seed in 0..12 {
        let map = kitchen(seed).unwrap();
        assert_eq!(map.scene(), format!("kitchen-{seed}"));
        let n_places = map.places().count();
        for (action, class) in [
            ("PickupObject", "Mug"),
            ("ToggleObjectOn", "CoffeeMachine"),
            ("PutObject", "CoffeeMachine"),
        ] {
            let object = map.object_for(action, class).unwrap();
            let feasible = &object.feasible[action];
            assert!(
                feasible.len() < n_places / 4,
                "{seed}: {} of {n_places}",
                feasible.len()
            );
            for place in feasible {
                let distance_m = distance_m(&map, object, *place);
                assert!((0.2..1.3).contains(&distance_m), "{seed}: {distance_m}");
            }
        }
    }
}

fn distance_m(map: &ActionMap, object: &MapObject, place: StandingPlace) -> f64 {
    let object_from_base = object
        .world_from_object
        .inv_mul(&map.world_from_base(place));
    object_from_base.translation.vector.norm()
}

/// A room of 4 by 4 m with a machine at the end of a table along the wall y = 0, and something between it and the room.
fn map_with(obstacle_height_m: Option<f64>) -> ActionMap {
    use factotum_geometry::Pose;
    use factotum_physics::{Motion, Primitive, Shape};
    let shape = |name: &str, half: [f64; 3], at: [f64; 3]| Shape {
        name: name.to_owned(),
        primitive: Primitive::Box { half },
        world_from_shape: Pose::translation(at[0], at[1], at[2]),
        rgba: [1.0; 4],
        collides: true,
        motion: Motion::Fixed,
    };
    let mut shapes = vec![
        shape("table", [2.0, 0.3, 0.45], [2.0, 0.3, 0.45]),
        shape("CoffeeMachine", [0.1, 0.1, 0.15], [2.0, 0.2, 1.05]),
    ];
    if let Some(height_m) = obstacle_height_m {
        let half = [2.0, 0.01, 0.5 * height_m];
        shapes.push(shape("screen", half, [2.0, 0.5, 0.9 + 0.5 * height_m]));
    }
    let layout = Layout {
        room_m: [4.0, 4.0],
        shapes,
        targets: vec![layout::Target {
            class: "CoffeeMachine",
            world_from_object: Pose2::new(Vector2::new(2.0, 0.2), FRAC_PI_2),
            point_in_world: Point3::new(2.0, 0.3, 1.05),
            actions: &["ToggleObjectOn"],
        }],
    };
    feasibility::action_map("room", &layout).unwrap()
}

#[test]
fn reach_collision_and_sight_decide() {
    let map = map_with(None);
    let machine = map.object_for("ToggleObjectOn", "CoffeeMachine").unwrap();
    let feasible = &machine.feasible["ToggleObjectOn"];
    for place in feasible {
        let base = map.world_from_base(*place);
        // In front of it, within reach of the arm, and not turned away.
        assert!(distance_m(&map, machine, *place) < 1.3);
        assert!(base.translation.y > 0.6);
        assert!((base.rotation.angle() - FRAC_PI_2).abs() > 1e-6, "{base}");
    }
    // As near as the table lets it, facing it.
    let facing = |place: &StandingPlace| {
        let base = map.world_from_base(*place);
        (base.translation.x - 2.0).abs() < 0.2 && (base.rotation.angle() + FRAC_PI_2).abs() < 1e-6
    };
    assert!(feasible.iter().any(facing));
    // Nobody stands in the table.
    let lowest = map
        .places()
        .map(|place| map.world_from_base(place).translation.y);
    assert!(lowest.fold(f64::INFINITY, f64::min) > 0.6 + 0.27);
    // Behind a screen as high as the camera it is seen from nowhere, and the arm is stopped.
    let behind = map_with(Some(0.8));
    assert!(
        behind
            .object_for("ToggleObjectOn", "CoffeeMachine")
            .is_none()
    );
    assert_eq!(behind.places().count(), map.places().count());
}
