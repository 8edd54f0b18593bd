//! Teaching a home from nothing but a map, refusals, and two pages at once.

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, OccupancyGrid};
use factotum_physics::Model;
use factotum_protocol::{
    Action, ActionMotion, Approach, Contact, Edit, EditOutcome, EditRequest, Form, Grasp, Pose,
    Provenance,
};
use factotum_semantic_map::{Aosm, Home};

use super::Desk;

fn desk_over_a_map(dir: &Path) -> Desk {
    let grid = OccupancyGrid::filled(40, 40, 0.1, Pose2::identity(), Cell::FREE).unwrap();
    drop(Home::create(dir, "flat", &Aosm::new([], grid), 0.0).unwrap());
    open(dir)
}

fn open(dir: &Path) -> Desk {
    Desk::open(dir, 0.12, 1.0).unwrap()
}

/// Asks as a page does, under an id of its own.
fn ask(desk: &mut Desk, base: Option<u32>, edit: Edit) -> EditOutcome {
    static N_ASKED: AtomicU32 = AtomicU32::new(0);
    let id = format!("edit {}", N_ASKED.fetch_add(1, Ordering::Relaxed));
    desk.answer(&EditRequest { id, base, edit }, 2.0)
}

#[track_caller]
fn accept(desk: &mut Desk, edit: Edit) -> String {
    match ask(desk, None, edit.clone()) {
        EditOutcome::Accepted { what, .. } => what,
        EditOutcome::Refused { reason } => panic!("{edit:?} refused: {reason}"),
    }
}

#[track_caller]
fn refuse(desk: &mut Desk, edit: Edit) -> String {
    let before = desk.teaching().unwrap();
    let EditOutcome::Refused { reason } = ask(desk, None, edit.clone()) else {
        panic!("{edit:?} was taken");
    };
    assert_eq!(desk.teaching().unwrap(), before, "{edit:?}");
    reason
}

fn make(name: &str, movable: bool) -> Edit {
    Edit::MakeClass {
        name: name.to_owned(),
        form: Form::Cylinder {
            diameter_m: 0.065,
            height_m: 0.2,
        },
        movable,
    }
}

fn add(class: &str, x: f64) -> Edit {
    Edit::AddObject {
        class: class.to_owned(),
        pose: Pose::from_position_yaw([x, 1.0, 0.0], 0.5),
    }
}

fn grasp(name: &str) -> Grasp {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Grasp {
        name: name.to_owned(),
        object_from_tool: Pose {
            position: [0.0, 0.0, 0.085],
            orientation_xyzw: [0.0, half, 0.0, half],
        },
        aperture_m: 0.1,
        link: None,
        yaw_symmetric: true,
        provenance: Provenance::Given,
    }
}

fn put_grasp(class: &str, name: &str) -> Edit {
    Edit::PutGrasp {
        class: class.to_owned(),
        grasp: grasp(name),
    }
}

fn put_into(class: &str, target: &str, grasp: Option<&str>) -> Edit {
    Edit::PutAction {
        class: class.to_owned(),
        action: Action {
            name: "throw_away".to_owned(),
            grasp: grasp.map(str::to_owned),
            motion: ActionMotion::PutInto {
                class: target.to_owned(),
                target_from_object: Pose::from_position_yaw([0.0, 0.0, 0.3], 0.0),
                approach: None,
            },
            approach: Some(Approach {
                distance_m: [0.55, 0.85],
            }),
            provenance: Provenance::Given,
        },
    }
}

fn move_joint(name: &str, termination: f64, effect: &str) -> Edit {
    Edit::PutAction {
        class: "light_switch".to_owned(),
        action: Action {
            name: name.to_owned(),
            grasp: Some("push_down".to_owned()),
            motion: ActionMotion::Joint {
                joint: "toggle".to_owned(),
                initiation: Some(0.4),
                termination,
                contact: Contact::Push,
                effect: effect.to_owned(),
            },
            approach: None,
            provenance: Provenance::Given,
        },
    }
}

/// The edits of a person who teaches how a bottle is thrown away.
fn lesson() -> Vec<Edit> {
    vec![
        make("basket", false),
        add("basket", 3.0),
        make("flask", true),
        add("flask", 1.0),
        put_grasp("flask", "side"),
        put_into("flask", "basket", Some("side")),
    ]
}

#[test]
fn what_is_taught_from_nothing_can_be_planned_is_kept_and_is_undone() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    let made: Vec<String> = lesson()
        .into_iter()
        .map(|edit| accept(&mut desk, edit))
        .collect();
    assert_eq!(
        made,
        ["basket", "basket_1", "flask", "flask_1", "flask", "flask"]
    );
    let options = |desk: &Desk| -> Vec<String> {
        let options = desk.aosm().options();
        options
            .iter()
            .map(|option| option.step.to_string())
            .collect()
    };
    let wanted = ["(pick flask_1)", "(throw_away flask_1 basket_1)"];
    assert_eq!(options(&desk), wanted);
    for class in desk.aosm().classes.values() {
        Model::from_mjcf_file(&class.model).unwrap();
        assert_eq!(class.provenance, factotum_descriptions::Provenance::Taught);
    }
    let taught = desk.teaching().unwrap();
    assert_eq!(taught.classes[1].name, "flask");
    assert_eq!(taught.classes[1].parts[0].shapes.len(), 1, "it is drawn");
    assert_eq!(taught.classes[1].actions[0].provenance, Provenance::Taught);
    assert_eq!(taught.objects[0].provenance, Provenance::Taught);
    let pose = taught.classes[1].grasps[0].object_from_tool;
    for (found, wanted) in pose
        .orientation_xyzw
        .iter()
        .zip(grasp("side").object_from_tool.orientation_xyzw)
    {
        assert!((found - wanted).abs() < 1e-6, "{pose:?}");
    }

    // Another day, another process: it is all there, and can be undone, one edit at a time.
    drop(desk);
    let mut desk = open(dir.path());
    assert_eq!(desk.teaching().unwrap(), taught);
    assert_eq!(options(&desk), wanted);
    assert_eq!(accept(&mut desk, Edit::Undo), "teach throw_away of flask");
    assert_eq!(options(&desk), wanted[..1]);
    for _ in 1..lesson().len() {
        accept(&mut desk, Edit::Undo);
    }
    assert!(desk.aosm().classes.is_empty() && desk.aosm().objects.is_empty());
    assert_eq!(refuse(&mut desk, Edit::Undo), "there is nothing to undo");
    for _ in lesson() {
        accept(&mut desk, Edit::Redo);
    }
    assert_eq!(options(&desk), wanted);
    assert_eq!(
        refuse(&mut desk, Edit::Redo),
        "there is nothing to do again"
    );
}

#[test]
fn refusals_name_the_thing_what_was_found_and_what_was_wanted() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    for edit in lesson() {
        accept(&mut desk, edit);
    }
    let tilted = Edit::MoveObject {
        name: "flask_1".to_owned(),
        pose: Pose {
            position: [0.0; 3],
            orientation_xyzw: [0.0; 4],
        },
    };
    let far = Edit::MoveObject {
        name: "flask_1".to_owned(),
        pose: Pose::from_position_yaw([1e9, 0.0, 0.0], 0.0),
    };
    let at = |position: [f64; 3]| Edit::MoveObject {
        name: "flask_1".to_owned(),
        pose: Pose::from_position_yaw(position, 0.0),
    };
    let (high, nowhere) = (at([1.0, 1.0, 12.0]), at([f64::NAN, 0.0, 0.0]));
    let linked = Edit::PutGrasp {
        class: "flask".to_owned(),
        grasp: Grasp {
            link: Some("wing".to_owned()),
            ..grasp("side")
        },
    };
    let away = Edit::PutGrasp {
        class: "flask".to_owned(),
        grasp: Grasp {
            object_from_tool: Pose::from_position_yaw([0.0, 0.0, 50.0], 0.0),
            ..grasp("side")
        },
    };
    let remove_class = |name: &str| Edit::RemoveClass {
        name: name.to_owned(),
    };
    let flat = Edit::ReshapeClass {
        name: "flask".to_owned(),
        form: Form::Box {
            size_m: [0.1, 0.1, 0.0],
        },
        movable: true,
    };
    let not_movable = Edit::ReshapeClass {
        name: "flask".to_owned(),
        form: Form::Box { size_m: [0.1; 3] },
        movable: false,
    };
    let remove_grasp = Edit::RemoveGrasp {
        class: "flask".to_owned(),
        name: "side".to_owned(),
    };
    let take = |name: &str| Edit::TakeClass {
        name: name.to_owned(),
    };
    let wide = Edit::PutGrasp {
        class: "flask".to_owned(),
        grasp: Grasp {
            aperture_m: 7.0,
            ..grasp("side")
        },
    };
    for (edit, wanted) in [
        (make("flask", true), "a class is named `flask` already"),
        (make("../etc", true), "class name `../etc` found, expected"),
        (make("Flask", true), "class name `Flask` found, expected"),
        (make(&"x".repeat(49), true), "expected 1 to 48"),
        (make("object", true), "a class is named `object` already"),
        (
            add("unicorn", 0.0),
            "object class `unicorn` is not in the map",
        ),
        (tilted, "quaternion of length 0, expected 1"),
        (
            far,
            "object `flask_1` is at (1000000000.00, 0.00) m, expected at most 1 m outside the map",
        ),
        (
            high,
            "object `flask_1` is at a height of 12.00 m, expected -3 to 10 m",
        ),
        (nowhere, "object `flask_1` has the pose (NaN, 0, 0) m"),
        (linked, "holds the link `wing`, expected one of `flask`"),
        (
            away,
            "grasp `side` of `flask` is at (0, 0, 50) m, expected at most 10 m",
        ),
        (flat, "`size_m.z` is 0 m, expected 0.002 to 5 m"),
        (not_movable, "not movable"),
        (wide, "opening of grasp `side` is 7 m, expected 0 to 1 m"),
        (remove_grasp, "`actions.throw_away.grasp` is `side`"),
        (
            remove_class("flask"),
            "object class `flask` is not in the map",
        ),
        (
            remove_class("unicorn"),
            "object class `unicorn` is not in the map",
        ),
        (put_into("flask", "moon", None), "moon"),
        (put_into("basket", "flask", None), "not movable"),
        (
            put_into("flask", "basket", Some("lid")),
            "is `lid`, expected one of `side`",
        ),
        (
            take("unicorn"),
            "class `unicorn` is not in the catalogue; it has: `bin`",
        ),
        (
            move_joint("turn", 0.0, "on"),
            "object class `light_switch` is not in the map",
        ),
    ] {
        let reason = refuse(&mut desk, edit.clone());
        assert!(reason.contains(wanted), "{edit:?}: {reason}");
    }
}

#[test]
fn an_edit_of_what_another_page_has_changed_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    for edit in lesson() {
        accept(&mut desk, edit);
    }
    let move_to = |x: f64| Edit::MoveObject {
        name: "flask_1".to_owned(),
        pose: Pose::from_position_yaw([x, 0.0, 0.0], 0.0),
    };
    let seen = desk.teaching().unwrap();
    let base = Some(seen.objects[1].revision);
    assert_eq!(seen.objects[1].name, "flask_1");
    let entry = match ask(&mut desk, base, move_to(1.5)) {
        EditOutcome::Accepted { entry, .. } => entry.unwrap(),
        refused @ EditOutcome::Refused { .. } => panic!("{refused:?}"),
    };
    let EditOutcome::Refused { reason } = ask(&mut desk, base, move_to(0.5)) else {
        panic!("the other page's change was lost");
    };
    assert!(
        reason.starts_with("object `flask_1` was changed meanwhile: move flask_1, by page"),
        "{reason}"
    );
    // Of another object, of its class, and of the object as it is now, edits are taken.
    let class_base = Some(seen.classes[1].revision);
    for (base, edit) in [
        (class_base, put_grasp("flask", "top")),
        (Some(entry), move_to(0.5)),
    ] {
        let outcome = ask(&mut desk, base, edit);
        assert!(
            matches!(outcome, EditOutcome::Accepted { .. }),
            "{outcome:?}"
        );
    }
    // An undo changes it too.
    accept(&mut desk, Edit::Undo);
    assert!(matches!(
        ask(&mut desk, Some(entry), move_to(0.7)),
        EditOutcome::Refused { .. }
    ));
}

#[test]
fn a_request_that_comes_again_is_answered_and_not_applied_again() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    accept(&mut desk, make("flask", true));
    let request = EditRequest {
        id: "5eed".to_owned(),
        base: None,
        edit: add("flask", 1.0),
    };
    let first = desk.answer(&request, 3.0);
    assert_eq!(desk.answer(&request, 4.0), first);
    assert_eq!(desk.aosm().objects.len(), 1);
    let other = EditRequest {
        edit: add("flask", 2.0),
        ..request.clone()
    };
    let EditOutcome::Refused { reason } = desk.answer(&other, 5.0) else {
        panic!("an answer to another edit was given");
    };
    assert!(reason.contains("`5eed`"), "{reason}");

    // Another process: the home itself remembers, but for what was refused.
    drop(desk);
    let mut desk = open(dir.path());
    assert_eq!(desk.answer(&request, 6.0), first);
    assert!(matches!(
        desk.answer(&other, 7.0),
        EditOutcome::Refused { .. }
    ));
    assert_eq!(desk.aosm().objects.len(), 1);
    let undo = EditRequest {
        id: "back".to_owned(),
        base: None,
        edit: Edit::Undo,
    };
    let undone = desk.answer(&undo, 8.0);
    assert!(desk.aosm().objects.is_empty());
    drop(desk);
    let mut desk = open(dir.path());
    assert_eq!(desk.answer(&undo, 9.0), undone, "the class is still there");
    assert_eq!(desk.aosm().classes.len(), 1);
    let early = EditRequest {
        id: "early".to_owned(),
        base: None,
        edit: add("cup", 1.0),
    };
    assert!(matches!(
        desk.answer(&early, 10.0),
        EditOutcome::Refused { .. }
    ));
    accept(&mut desk, make("cup", true));
    let outcome = desk.answer(&early, 11.0);
    assert!(
        matches!(outcome, EditOutcome::Accepted { .. }),
        "what was refused is looked at again: {outcome:?}"
    );
}

#[test]
fn a_joint_is_not_taught_beyond_its_range() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    accept(
        &mut desk,
        Edit::TakeClass {
            name: "light_switch".to_owned(),
        },
    );
    // Range of the lever: 0.4 rad each way; pushes are aimed a little beyond.
    accept(&mut desk, move_joint("turn_off", -0.55, "off"));
    let reason = refuse(&mut desk, move_joint("turn_off", -0.7, "off"));
    let wanted = "termination of action `turn_off` is -0.7 rad, expected -0.4 to 0.4 rad, the range of joint `toggle` of \
                  `light_switch`";
    assert_eq!(reason, wanted);
    for (spoil, wanted) in [
        (
            (Some(-0.9), -0.55, Contact::Push),
            "initiation of action `turn_off` is -0.9 rad",
        ),
        (
            (None, -0.41, Contact::Grasp),
            "termination of action `turn_off` is -0.41 rad",
        ),
        ((None, f64::NAN, Contact::Grasp), "is NaN rad"),
    ] {
        let mut edit = move_joint("turn_off", -0.55, "off");
        let Edit::PutAction { action, .. } = &mut edit else {
            unreachable!();
        };
        let ActionMotion::Joint {
            initiation,
            termination,
            contact,
            ..
        } = &mut action.motion
        else {
            unreachable!();
        };
        (*initiation, *termination, *contact) = spoil;
        let reason = refuse(&mut desk, edit);
        assert!(reason.contains(wanted), "{reason}");
    }
}

#[test]
fn an_action_on_a_joint_makes_the_state_that_it_brings_about() {
    let dir = tempfile::tempdir().unwrap();
    let mut desk = desk_over_a_map(dir.path());
    accept(
        &mut desk,
        Edit::TakeClass {
            name: "light_switch".to_owned(),
        },
    );
    accept(&mut desk, add("light_switch", 2.0));
    accept(&mut desk, move_joint("dim", 0.0, "dimmed"));
    let class = desk.teaching().unwrap().classes.remove(0);
    assert_eq!(class.parts.len(), 2, "the lever moves, the rest does not");
    assert_eq!(class.parts[1].joints, ["toggle"]);
    let state = class.states.iter().find(|state| state.name == "dimmed");
    let range = state.unwrap().range;
    assert!((range[0] + 0.12).abs() < 1e-9 && (range[1] - 0.12).abs() < 1e-9);
    let reason = refuse(&mut desk, move_joint("dim", -0.3, "dimmed"));
    assert!(reason.contains("expected `off`"), "{reason}");
    accept(
        &mut desk,
        Edit::RemoveAction {
            class: "light_switch".to_owned(),
            name: "dim".to_owned(),
        },
    );
    assert_eq!(desk.teaching().unwrap().classes[0].states.len(), 2);
}

#[test]
fn a_home_that_another_process_is_at_work_on_can_be_looked_at() {
    let dir = tempfile::tempdir().unwrap();
    let mut first = desk_over_a_map(dir.path());
    accept(&mut first, make("flask", true));
    let mut second = open(dir.path());
    let closed = second.closed().unwrap().to_owned();
    assert!(closed.contains("is open in another process"), "{closed}");
    assert_eq!(refuse(&mut second, add("flask", 1.0)), closed);
    assert_eq!(second.teaching().unwrap().classes[0].name, "flask");
}
