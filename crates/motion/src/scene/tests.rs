use super::*;
use crate::test_robots;
use nalgebra::{Point3, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn sphere_at(name: &str, base_from_obstacle: Pose, radius_m: f64) -> Obstacle {
    Obstacle {
        name: name.to_owned(),
        shape: ObstacleShape::Sphere { radius_m },
        base_from_obstacle,
    }
}

#[test]
fn postures_of_the_robots_are_free() {
    for name in ["panda", "iiwa7", "jaco", "movo"] {
        let robot = test_robots::load(name);
        let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
        assert_eq!(scene.collision(&robot.q_rest()), None, "{name} at rest");
        assert_eq!(scene.collision(&robot.q_ready()), None, "{name} ready");
    }
}

#[test]
fn an_obstacle_in_the_hand_collides_until_it_is_allowed() {
    let robot = test_robots::load("movo");
    let q = robot.q_ready();
    let tcp = robot.chain().base_from_tcp(&q);
    let ball = sphere_at("ball", tcp, 0.08);
    let mut scene = PlanningScene::new(&robot, &[ball], None).unwrap();
    let (a, b) = scene.collision(&q).unwrap();
    assert!(a == "ball" || b == "ball", "{a} {b}");
    scene.allow_contact("ball");
    assert_eq!(scene.collision(&q), None);
    scene.forbid_contact("ball");
    assert!(!scene.is_free(&q));
}

#[test]
fn a_margin_finds_what_is_near() {
    let robot = test_robots::load("movo");
    let q = robot.q_ready();
    // A plate across the approach direction: its distance from the hand grows as it is moved along it.
    let plate = |ahead_m: f64| Obstacle {
        name: "plate".to_owned(),
        shape: ObstacleShape::Box {
            half_extents_m: [0.3, 0.3, 0.01],
        },
        base_from_obstacle: robot.chain().base_from_tcp(&q)
            * nalgebra::Translation3::new(0.0, 0.0, ahead_m),
    };
    let touches = |ahead_m: f64, margin_m: f64| {
        !PlanningScene::with_margin(&robot, &[plate(ahead_m)], None, margin_m)
            .unwrap()
            .is_free(&q)
    };
    let (mut near, mut far) = (0.0, 0.3);
    for _ in 0..20 {
        let middle = 0.5 * (near + far);
        if touches(middle, 0.0) {
            near = middle
        } else {
            far = middle
        }
    }
    assert!(touches(far + 0.009, 0.01), "10 mm margin at 9 mm");
    assert!(!touches(far + 0.011, 0.01), "10 mm margin at 11 mm");
    // The clearance is what is left of the distance, as far as it is seen.
    let clearance = |ahead_m: f64, margin_m: f64| {
        PlanningScene::with_margin(&robot, &[plate(ahead_m)], None, margin_m)
            .unwrap()
            .clearance_m(&q)
    };
    let bare = PlanningScene::new(&robot, &[], None)
        .unwrap()
        .clearance_m(&q);
    assert!((clearance(far + 0.003, 0.0) - bare.min(0.003)).abs() < 1e-4);
    assert!((clearance(far + 0.003, 0.01) + 0.007).abs() < 1e-4);
    assert_eq!(clearance(far + 0.1, 0.0), bare);
}

#[test]
fn a_held_object_reaches_farther() {
    let robot = test_robots::load("movo");
    let q = robot.q_ready();
    let tcp = robot.chain().base_from_tcp(&q);
    let ball = sphere_at(
        "ball",
        tcp * nalgebra::Translation3::new(0.0, 0.0, 0.25),
        0.05,
    );
    let stick = HeldObject {
        shape: ObstacleShape::Cylinder {
            radius_m: 0.01,
            half_length_m: 0.25,
        },
        tcp_from_object: Pose::identity(),
    };
    let free = PlanningScene::new(&robot, std::slice::from_ref(&ball), None)
        .unwrap()
        .collision(&q);
    assert_eq!(free, None);
    let mut scene = PlanningScene::new(&robot, &[ball], Some(&stick)).unwrap();
    let pair = scene.collision(&q).unwrap();
    assert!(
        [&pair.0, &pair.1].contains(&&HELD_OBJECT.to_owned()),
        "{pair:?}"
    );
    scene.allow_contact("ball");
    assert!(scene.is_free(&q));
}

#[test]
fn obstacles_may_touch_each_other_and_the_base() {
    let robot = test_robots::load("movo");
    let at = Pose::translation(0.0, 0.0, 0.1);
    let both = [sphere_at("a", at, 0.1), sphere_at("b", at, 0.1)];
    let mut scene = PlanningScene::new(&robot, &both, None).unwrap();
    assert_eq!(scene.collision(&robot.q_rest()), None);
}

#[test]
fn a_class_model_is_an_obstacle_with_its_joints_in_place() {
    let robot = test_robots::load("movo");
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../assets/objects/bottle/model.xml");
    let base_from_tcp = robot.chain().base_from_tcp(&robot.q_ready());
    // Upright at the tool, moved along the approach direction.
    let bottle = |ahead_m: f64, joint_positions| {
        let at = base_from_tcp * Point3::new(0.0, 0.0, ahead_m) - Vector3::z() * 0.08;
        Obstacle {
            name: "bottle".to_owned(),
            shape: ObstacleShape::Model {
                file: file.clone(),
                joint_positions,
            },
            base_from_obstacle: Pose::translation(at.x, at.y, at.z),
        }
    };
    let collision = |ahead_m: f64| {
        let mut scene = PlanningScene::new(&robot, &[bottle(ahead_m, vec![])], None).unwrap();
        scene.collision(&robot.q_ready())
    };
    assert_eq!(
        collision(0.0),
        None,
        "the bottle fits between the open fingers"
    );
    let pair = collision(-0.08).unwrap();
    assert!(
        [&pair.0, &pair.1].contains(&&"bottle".to_owned()),
        "{pair:?}"
    );
    let absent = bottle(0.0, vec![("lid".to_owned(), 0.1)]);
    let error = PlanningScene::new(&robot, &[absent], None)
        .unwrap_err()
        .to_string();
    assert!(error.contains("lid"), "{error}");
}

#[test]
fn two_obstacles_of_one_name_are_refused() {
    let robot = test_robots::load("jaco");
    let twice = [
        sphere_at("a", Pose::identity(), 0.1),
        sphere_at("a", Pose::identity(), 0.1),
    ];
    let error = PlanningScene::new(&robot, &twice, None)
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "two obstacles are named `a`, expected different names"
    );
}

#[test]
fn what_cannot_be_checked_counts_as_colliding() {
    let robot = test_robots::load("jaco");
    let mut scene = PlanningScene::new(&robot, &[], None).unwrap();
    let unchecked = |pair: Option<(String, String)>| {
        let (first, reason) = pair.unwrap();
        assert_eq!(first, UNCHECKED);
        reason
    };
    let reason = unchecked(scene.collision(&[f64::NAN; 7]));
    assert_eq!(reason, "joint position is NaN, expected a finite number");
    let reason = unchecked(scene.collision(&[0.0; 3]));
    assert_eq!(
        reason,
        "configuration has 3 values, expected 7, one per chain joint"
    );
    assert!(!scene.is_free(&[f64::NAN; 7]));
    assert!(
        scene.is_free(&robot.q_ready()),
        "the scene is usable afterwards"
    );
}

/// The pairs left out by contact bits are exactly those that never matter: the verdict is that of the plain model.
#[test]
fn the_verdict_agrees_with_the_unfiltered_model() {
    let robot = test_robots::load("movo");
    let table = Obstacle {
        name: "table".to_owned(),
        shape: ObstacleShape::Box {
            half_extents_m: [0.3, 0.5, 0.02],
        },
        base_from_obstacle: Pose::translation(0.8, 0.0, 0.7),
    };
    let mut scene = PlanningScene::new(&robot, &[table], None).unwrap();
    let mut plain = crate::robot::scene_of_robot(robot.description()).unwrap();
    plain.add_box(
        "table",
        &Pose::translation(0.8, 0.0, 0.7),
        [0.3, 0.5, 0.02],
        [1.0; 4],
        true,
    );
    let model = plain.compile().unwrap();
    let joints: Vec<_> = robot
        .chain_joints()
        .iter()
        .map(|name| model.joint(name).unwrap())
        .collect();
    let groups = crate::robot::Groups::of(&model, &joints).unwrap();
    let mut state = State::new(&model).unwrap();
    for finger in &robot.description().gripper.as_ref().unwrap().joints {
        state.set_joint_position(model.joint(finger).unwrap(), 0.0);
    }
    let table = model.body("table").unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut q = vec![0.0; robot.n()];
    let mut n_colliding = 0;
    for _ in 0..500 {
        robot.space().sample_into(&mut rng, &mut q);
        for (&joint, &q) in joints.iter().zip(&q) {
            state.set_joint_position(joint, q);
        }
        state.detect_collisions().unwrap();
        let collides = state.contacts().any(|contact| {
            let (a, b) = (
                model.geom_body(contact.geom_a),
                model.geom_body(contact.geom_b),
            );
            let matters = match (a == table, b == table) {
                (true, _) => groups.of_body(b) > 0,
                (_, true) => groups.of_body(a) > 0,
                _ => {
                    groups.may_meet(a, b)
                        && !robot.always_touch(model.body_name(a), model.body_name(b))
                }
            };
            contact.distance_m < 0.0 && matters
        });
        assert_eq!(scene.collision(&q).is_some(), collides, "{q:?}");
        n_colliding += usize::from(collides);
    }
    assert!(
        (50..450).contains(&n_colliding),
        "{n_colliding} of 500 collide"
    );
}
