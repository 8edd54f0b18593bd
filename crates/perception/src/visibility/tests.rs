use super::*;
use crate::test_scene::{Scene, Shape, Solid, at, bottle, camera};

fn look(things: Vec<(Solid, Pose, &'static str)>) -> DepthFrame {
    Scene {
        things,
        sigma_m: 0.002,
    }
    .look(&camera(0.5), 1)
}

fn judge(frame: &DepthFrame, place: &Pose) -> Presence {
    presence(
        frame,
        &bottle().class("bottle", true, true),
        place,
        &PresenceParams::default(),
    )
}

#[test]
fn an_object_is_seen_gone_hidden_or_out_of_view() {
    let place = at([1.3, 0.1, 0.3], [0.0; 3]);
    let frame = look(vec![(bottle(), place, "bottle")]);
    assert!(matches!(judge(&frame, &place), Presence::Seen { confirmed } if confirmed > 0.8));

    let empty = look(Vec::new());
    assert!(matches!(judge(&empty, &place), Presence::Gone { seen_through } if seen_through > 0.9));

    let moved = look(vec![(bottle(), at([1.3, -0.3, 0.3], [0.0; 3]), "bottle")]);
    assert!(matches!(judge(&moved, &place), Presence::Gone { .. }));

    let wall = Solid(vec![(Pose::identity(), Shape::Box([0.02, 0.6, 0.6]))]);
    let walled = look(vec![
        (wall, at([0.8, 0.0, 0.6], [0.0; 3]), ""),
        (bottle(), place, "bottle"),
    ]);
    assert_eq!(judge(&walled, &place), Presence::Hidden);

    for outside in [
        at([1.3, 4.0, 0.3], [0.0; 3]),
        at([-1.5, 0.0, 0.3], [0.0; 3]),
    ] {
        assert_eq!(judge(&frame, &outside), Presence::OutOfView);
    }
}

#[test]
fn another_class_in_its_place_is_not_it() {
    let place = at([1.3, 0.1, 0.3], [0.0; 3]);
    let frame = look(vec![(bottle(), place, "vase")]);
    assert_eq!(judge(&frame, &place), Presence::Hidden);
    let unlabelled = DepthFrame {
        labels: Vec::new(),
        ..frame
    };
    assert!(matches!(judge(&unlabelled, &place), Presence::Seen { .. }));
}
