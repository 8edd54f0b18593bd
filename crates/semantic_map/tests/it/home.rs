//! A home that is kept: edits, undo and redo against a model, files changed by hand, and files that are broken.

use std::collections::BTreeMap;
use std::path::Path;

use factotum_descriptions::{Form, Grasp, ObjectClass, Provenance};
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::grid::{Cell, CellIndex, OccupancyGrid};
use factotum_geometry::{Pose, Pose2};
use factotum_semantic_map::{
    Aosm, Edit, EntryKind, Execution, Home, Location, MapError, MapObject, ObjectSource, Thing,
    home_folder,
};
use factotum_task_planning::operator::GroundAction;
use nalgebra::Point3;
use proptest::prelude::*;

use super::{household, objects_dir};

pub(crate) fn new_home(dir: &Path) -> Home {
    Home::create(dir, "test home", &household(), 0.0).unwrap()
}

fn class_name() -> impl Strategy<Value = String> {
    prop_oneof![Just("faucet"), Just("flask")].prop_map(str::to_owned)
}

fn form() -> impl Strategy<Value = Form> {
    (0.0..0.3_f64).prop_map(|height_m| Form::Cylinder {
        diameter_m: 0.06,
        height_m,
    })
}

fn grasp(name: &str, height_m: f64) -> Grasp {
    Grasp {
        name: name.to_owned(),
        xyz: [0.0, 0.0, height_m],
        rpy: [0.0; 3],
        aperture_m: 0.08,
        link: None,
        yaw_symmetric: false,
        provenance: Provenance::Taught,
    }
}

#[test]
fn an_edit_of_what_has_changed_since_is_refused_across_processes() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let bottle = Thing::Object("bottle_1".to_owned());
    assert_eq!(home.revision(&bottle), Some(1));
    assert_eq!(home.revision(&Thing::Object("cup_1".to_owned())), None);
    let entry = home.edit_on(1, &move_bottle(7.0), "ada", 1.0).unwrap();
    assert_eq!(home.revision(&bottle), entry);

    drop(home);
    let mut home = Home::open(dir.path(), 2.0).unwrap();
    assert_eq!(home.revision(&bottle), entry);
    let error = home.edit_on(1, &move_bottle(8.0), "ben", 3.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "object `bottle_1` was changed meanwhile: move bottle_1, by ada (entry 2 of the journal, the edit was made on 1); \
         look at it again and repeat the edit"
    );
    assert_eq!(bottle_x(home.aosm()), 7.0);

    // Whoever teaches its class does not disturb who moves an object of it, and the other way round.
    let teach = Edit::PutGrasp {
        class: "bottle".to_owned(),
        grasp: grasp("top", 0.1),
    };
    let taught = home.edit_on(1, &teach, "ben", 3.0).unwrap();
    assert_eq!(home.revision(&Thing::Class("bottle".to_owned())), taught);
    home.edit_on(2, &move_bottle(8.0), "ben", 4.0).unwrap();

    // An undo is a change, and so is a hand on the text file.
    home.undo("ada", 5.0).unwrap();
    assert!(home.edit_on(2, &move_bottle(9.0), "ben", 6.0).is_err());
    let base = home.revision(&bottle).unwrap();
    let file = dir.path().join("objects.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("7.0,", "7.5,")).unwrap();
    let by_hand = home.edit_on(base, &move_bottle(9.0), "ben", 7.0);
    assert!(
        matches!(by_hand, Err(MapError::ChangedMeanwhile { .. })),
        "{by_hand:?}"
    );
    assert_eq!(bottle_x(home.aosm()), 7.5);
}

#[test]
fn an_object_keeps_its_rank_whatever_others_come_and_go() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let ranks = |home: &Home| -> Vec<_> {
        let names = home.aosm().objects.keys();
        names.map(|name| home.object_rank(name)).collect()
    };
    assert_eq!(ranks(&home), [Some(0), Some(1), Some(2), Some(3)]);
    let name = "a_cup".to_owned();
    let cup = MapObject {
        name: name.clone(),
        ..home.aosm().object("bottle_1").unwrap().clone()
    };
    home.edit(&Edit::AddObject(cup), "ada", 1.0).unwrap();
    home.edit(
        &Edit::RemoveObject {
            name: "bin_1".to_owned(),
        },
        "ada",
        2.0,
    )
    .unwrap();
    assert_eq!(home.aosm().objects.keys().next(), Some(&name));
    assert_eq!(ranks(&home), [Some(4), Some(1), Some(2), Some(3)]);
    assert_eq!(home.object_rank("unicorn"), None);
}

pub(crate) fn move_bottle(x: f64) -> Edit {
    Edit::MoveObject {
        name: "bottle_1".to_owned(),
        map_from_object: Pose::translation(x, 0.5, 0.3),
    }
}

fn bottle_x(aosm: &Aosm) -> f64 {
    aosm.object("bottle_1")
        .unwrap()
        .map_from_object
        .translation
        .x
}

pub(crate) fn execution() -> Execution {
    Execution {
        step: GroundAction::new("throw_away", ["bottle_1", "bin_1"]),
        outcome: "done".to_owned(),
        robot_secs: 12.5,
    }
}

/// Whether a home holds what a model says; poses within the rounding of roll, pitch and yaw.
fn assert_same(home: &Aosm, model: &Aosm) {
    let classes = |aosm: &Aosm| -> Vec<_> {
        aosm.classes
            .values()
            .map(|class| {
                let (name, description) = (class.name.clone(), class.description.clone());
                (name, description, class.form, class.grasps.clone())
            })
            .collect()
    };
    assert_eq!(classes(home), classes(model));
    assert_eq!(home.grid, model.grid);
    assert_eq!(home.cloud, model.cloud);
    assert_eq!(
        home.objects.keys().collect::<Vec<_>>(),
        model.objects.keys().collect::<Vec<_>>()
    );
    for (found, wanted) in home.objects.values().zip(model.objects.values()) {
        let apart = found.map_from_object.inverse() * wanted.map_from_object;
        assert!(
            apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-7,
            "{found:?} {wanted:?}"
        );
        assert_eq!(
            &MapObject {
                map_from_object: wanted.map_from_object,
                ..found.clone()
            },
            wanted
        );
    }
}

/// What an edit does, said again in the plainest way; nothing if it must be refused.
fn model_edit(aosm: &Aosm, edit: &Edit) -> Option<Aosm> {
    let mut new = aosm.clone();
    match edit.clone() {
        Edit::AddObject(object) => {
            if new.objects.insert(object.name.clone(), object).is_some() {
                return None;
            }
        }
        Edit::RemoveObject { name } => {
            new.objects.remove(&name)?;
        }
        Edit::MoveObject {
            name,
            map_from_object,
        } => new.objects.get_mut(&name)?.map_from_object = map_from_object,
        Edit::SetJoints { name, joints } => new.objects.get_mut(&name)?.joints.extend(joints),
        Edit::SetLocation { name, location } => new.objects.get_mut(&name)?.location = location,
        Edit::Rename { name, to } => {
            if new.objects.contains_key(&to) {
                return None;
            }
            let object = new.objects.remove(&name)?;
            new.objects.insert(
                to.clone(),
                MapObject {
                    name: to.clone(),
                    ..object
                },
            );
            for object in new.objects.values_mut() {
                if object.location == Location::In(name.clone()) {
                    object.location = Location::In(to.clone());
                }
            }
        }
        Edit::PutClass(class) => {
            new.classes.insert(class.name.clone(), *class);
        }
        Edit::RemoveClass { name } => {
            new.classes.remove(&name)?;
        }
        Edit::MakeClass {
            name,
            form,
            movable,
        } => {
            let (class, _) = ObjectClass::of_form(&name, form, movable).ok()?;
            if new.classes.insert(name, class).is_some() {
                return None;
            }
        }
        Edit::ReshapeClass { name, form, .. } => {
            let class = new.classes.get_mut(&name)?;
            class.form = Some(class.form.and(Some(form))?);
        }
        Edit::PutGrasp { class, grasp } => {
            let grasps = &mut new.classes.get_mut(&class)?.grasps;
            match grasps.iter().position(|other| other.name == grasp.name) {
                Some(index) => grasps[index] = grasp,
                None => grasps.push(grasp),
            }
        }
        Edit::RemoveGrasp { class, name } => {
            let grasps = &mut new.classes.get_mut(&class)?.grasps;
            let index = grasps.iter().position(|other| other.name == name)?;
            grasps.remove(index);
        }
        Edit::SetMap(grid) => new.grid = grid,
        Edit::SetCloud(cloud) => new.cloud = cloud,
        Edit::SetAll(all) => new = *all,
        other => panic!("the model does not know {other:?}"),
    }
    let is_sound = new.objects.values().all(|object| {
        let Some(class) = new.classes.get(&object.class) else {
            return false;
        };
        let is_known = |joint: &String| class.joints.iter().any(|known| known.name == *joint);
        // Holders of holders: more of them than objects means a circle.
        let mut holder = Some(object);
        for _ in 0..=new.objects.len() {
            holder = match holder.map(|holder| &holder.location) {
                Some(Location::In(name)) if !new.objects.contains_key(name) => return false,
                Some(Location::In(name)) => new.objects.get(name),
                _ => None,
            };
        }
        holder.is_none() && object.joints.keys().all(is_known)
    });
    is_sound.then_some(new)
}

#[test]
fn an_entry_that_is_not_there_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    home.edit(&move_bottle(7.0), "ada", 1.0).unwrap();
    for entry in [-1, 0, 3] {
        let error = home.return_to(entry, "ada", 2.0).unwrap_err().to_string();
        assert!(
            error.contains(&format!("no entry {entry}; its last is 2")),
            "{error}"
        );
    }
    assert_eq!(home.last_entry().unwrap(), 2);
}

#[derive(Debug, Clone)]
enum Step {
    Edit(Edit),
    Undo,
    Redo,
    Execute,
    Reopen,
    /// Back to what the home held after an earlier step, by its place among them (modulo their number).
    Return(usize),
}

fn name() -> impl Strategy<Value = String> {
    prop::sample::select(vec![
        "bottle_1",
        "bin_1",
        "light_switch_1",
        "faucet_1",
        "extra",
    ])
    .prop_map(str::to_owned)
}

fn pose() -> impl Strategy<Value = Pose> {
    (-9.0..9.0, -9.0..9.0, -3.0..3.0).prop_map(|(x, y, yaw)| {
        Pose::new(
            nalgebra::Vector3::new(x, y, 0.4),
            nalgebra::Vector3::z() * yaw,
        )
    })
}

fn edit() -> impl Strategy<Value = Edit> {
    let location = prop_oneof![
        Just(Location::Loose),
        Just(Location::Held),
        name().prop_map(Location::In),
    ];
    prop_oneof![
        (name(), pose()).prop_map(|(name, map_from_object)| Edit::AddObject(MapObject {
            name,
            class: "bottle".to_owned(),
            map_from_object,
            joints: BTreeMap::new(),
            location: Location::Loose,
            source: ObjectSource::Taught,
            position_std_m: 0.02,
        })),
        name().prop_map(|name| Edit::RemoveObject { name }),
        (name(), pose()).prop_map(|(name, map_from_object)| Edit::MoveObject {
            name,
            map_from_object
        }),
        (name(), -0.3..0.3).prop_map(|(name, position)| Edit::SetJoints {
            name,
            joints: BTreeMap::from([("toggle".to_owned(), position)]),
        }),
        (name(), location).prop_map(|(name, location)| Edit::SetLocation { name, location }),
        (name(), name()).prop_map(|(name, to)| Edit::Rename { name, to }),
        (0..3).prop_map(|version| {
            let class = ObjectClass::load(&objects_dir().join("faucet")).unwrap();
            Edit::PutClass(Box::new(ObjectClass {
                description: format!("version {version}"),
                ..class
            }))
        }),
        class_name().prop_map(|name| Edit::RemoveClass { name }),
        (class_name(), form()).prop_map(|(name, form)| Edit::MakeClass {
            name,
            form,
            movable: true,
        }),
        (class_name(), form()).prop_map(|(name, form)| Edit::ReshapeClass {
            name,
            form,
            movable: true,
        }),
        (class_name(), 0.0..0.2).prop_map(|(class, height_m)| Edit::PutGrasp {
            class,
            grasp: grasp("top", height_m),
        }),
        class_name().prop_map(|class| Edit::RemoveGrasp {
            class,
            name: "top".to_owned(),
        }),
        (2..5usize, 0..4usize)
            .prop_map(|(width, occupied)| Edit::SetMap(small_grid(width, occupied))),
        (0..3u8).prop_map(|n| Edit::SetCloud(PointCloud::new(
            (0..n)
                .map(|i| Point3::new(f64::from(i), 0.1, 0.7))
                .collect()
        ))),
        pose().prop_map(|pose| {
            let mut aosm = household();
            aosm.object_mut("bin_1").unwrap().map_from_object = pose;
            Edit::SetAll(Box::new(aosm))
        }),
    ]
}

pub(crate) fn small_grid(width: usize, occupied: usize) -> OccupancyGrid {
    let mut grid =
        OccupancyGrid::filled(width, 2, 0.05, Pose2::translation(-1.0, 2.0), Cell::FREE).unwrap();
    grid.set_cell(
        CellIndex {
            column: occupied % width,
            row: occupied / width,
        },
        Cell::OCCUPIED,
    );
    grid
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        6 => edit().prop_map(Step::Edit),
        3 => Just(Step::Undo),
        2 => Just(Step::Redo),
        1 => Just(Step::Execute),
        1 => Just(Step::Reopen),
        2 => any::<usize>().prop_map(Step::Return),
    ]
}

/// The journal, from its first entry on, makes the home as it is: nothing is missing from it.
fn assert_journal_replays(home: &Home) {
    let mut documents: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let mut entries = home.history(usize::MAX).unwrap();
    entries.reverse();
    for (entry, number) in entries.iter().zip(1..) {
        assert_eq!(entry.id, number);
        for change in home.changes(entry.id).unwrap() {
            assert_eq!(
                documents.get(&change.document),
                change.before.as_ref(),
                "{entry:?}"
            );
            match change.after {
                Some(bytes) => documents.insert(change.document, bytes),
                None => documents.remove(&change.document),
            };
        }
    }
    for object in home.aosm().objects.keys() {
        assert!(documents.remove(&format!("objects/{object}")).is_some());
    }
    for (path, bytes) in documents {
        assert_eq!(
            std::fs::read(home.dir().join(&path)).unwrap(),
            bytes,
            "{path}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_edits_undone_and_redone_equal_the_model(steps in prop::collection::vec(step(), 1..16)) {
        let dir = tempfile::tempdir().unwrap();
        let mut home = new_home(dir.path());
        let mut past = vec![household()];
        let mut future = Vec::new();
        let mut n_executions = 0;
        let mut held = vec![(1, household())];
        for (step, when) in steps.iter().zip(1..) {
            let when = f64::from(when);
            let now = past.last().unwrap().clone();
            match step {
                Step::Edit(edit) => {
                    let result = home.edit(edit, "ada", when);
                    let wanted = model_edit(&now, edit);
                    prop_assert_eq!(result.is_ok(), wanted.is_some(), "{:?}: {:?}", edit, result);
                    if let Some(new) = wanted && result.unwrap().is_some() {
                        past.push(new);
                        future.clear();
                    }
                }
                Step::Undo => {
                    prop_assert_eq!(home.undo("ada", when).unwrap().is_some(), past.len() > 1);
                    if past.len() > 1 {
                        future.extend(past.pop());
                    }
                }
                Step::Redo => {
                    prop_assert_eq!(home.redo("ada", when).unwrap().is_some(), !future.is_empty());
                    past.extend(future.pop());
                }
                Step::Execute => {
                    home.record_execution(&execution(), "robot", when).unwrap();
                    n_executions += 1;
                }
                Step::Reopen => {
                    let before = home.aosm().clone();
                    drop(home);
                    home = Home::open(dir.path(), when).unwrap();
                    prop_assert_eq!(home.aosm(), &before);
                }
                Step::Return(place) => {
                    let (entry, then) = held[place % held.len()].clone();
                    if home.return_to(entry, "ada", when).unwrap().is_some() {
                        past.push(then);
                        future.clear();
                    } else {
                        assert_same(home.aosm(), &then);
                    }
                }
            }
            held.push((home.last_entry().unwrap(), past.last().unwrap().clone()));
            assert_same(home.aosm(), past.last().unwrap());
            let can = home.undo_redo().unwrap().map(|what| what.is_some());
            prop_assert_eq!(can, [past.len() > 1, !future.is_empty()]);
            // What a person reads is what the home holds.
            prop_assert!(home.unwritten().is_none());
            prop_assert_eq!(&home_folder::read(dir.path()).unwrap().1, home.aosm());
        }
        assert_journal_replays(&home);
        let history = home.history(usize::MAX).unwrap();
        let executions = history.iter().filter(|entry| entry.kind == EntryKind::Execution(execution()));
        prop_assert_eq!(executions.count(), n_executions);
    }
}

#[test]
fn undo_and_redo_go_on_in_another_session_and_skip_executions() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    home.edit(&move_bottle(5.0), "ada", 1.0).unwrap();
    home.edit(&move_bottle(6.0), "robot", 2.0).unwrap();
    home.record_execution(&execution(), "robot", 3.0).unwrap();
    drop(home);
    let mut home = Home::open(dir.path(), 4.0).unwrap();
    assert_eq!(
        home.undo("ada", 5.0).unwrap().as_deref(),
        Some("move bottle_1")
    );
    assert_eq!(bottle_x(home.aosm()), 5.0);
    drop(home);
    let mut home = Home::open(dir.path(), 6.0).unwrap();
    home.undo("ada", 7.0).unwrap();
    assert_eq!(bottle_x(home.aosm()), 1.0);
    assert_eq!(home.undo("ada", 8.0).unwrap(), None);
    home.redo("ada", 9.0).unwrap();
    assert_eq!(bottle_x(home.aosm()), 5.0);
    let latest = &home.history(1).unwrap()[0];
    assert_eq!((latest.when_secs, latest.author.as_str()), (9.0, "ada"));
    assert_eq!(
        latest.kind,
        EntryKind::Redo {
            edit: 2,
            what: "move bottle_1".to_owned()
        }
    );
    // Another edit ends what could be redone.
    home.edit(&move_bottle(7.0), "ada", 10.0).unwrap();
    assert_eq!(home.redo("ada", 11.0).unwrap(), None);
}

#[test]
fn an_edit_that_makes_no_sense_is_refused_and_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let before = home.aosm().clone();
    let class = home.aosm().class("bin").unwrap().clone();
    let joints = |joint: &str| BTreeMap::from([(joint.to_owned(), 0.1)]);
    let name = "bottle_1".to_owned();
    let refused = [
        (
            Edit::SetJoints {
                name: "faucet_1".to_owned(),
                joints: joints("handel"),
            },
            "object `faucet_1`: class `faucet` has no joint `handel`; it has: `handle`",
        ),
        (
            Edit::SetLocation {
                name: name.clone(),
                location: Location::In("bim_1".to_owned()),
            },
            "object `bottle_1` is inside: object `bim_1` is not in the map",
        ),
        (
            Edit::SetLocation {
                name: name.clone(),
                location: Location::In(name.clone()),
            },
            "object `bottle_1` is inside of itself",
        ),
        (
            Edit::RemoveClass {
                name: "bin".to_owned(),
            },
            "object `bin_1`: object class `bin` is not in the map",
        ),
        (
            Edit::Rename {
                name: name.clone(),
                to: "bin_1".to_owned(),
            },
            "an object is named `bin_1` already",
        ),
        (
            Edit::Rename {
                name: name.clone(),
                to: "my bottle".to_owned(),
            },
            "my bottle",
        ),
        (
            Edit::PutClass(Box::new(ObjectClass {
                name: "../bin".to_owned(),
                ..class
            })),
            "../bin",
        ),
        (
            move_bottle(f64::NAN),
            "object `bottle_1`: NaN found, expected a finite number",
        ),
    ];
    for (edit, wanted) in refused {
        let error = home.edit(&edit, "ada", 1.0).unwrap_err().to_string();
        assert!(error.contains(wanted), "{edit:?}: {error}");
        assert_eq!(home.aosm(), &before);
    }
    assert_eq!(home.history(10).unwrap().len(), 1);
    assert!(!dir.path().join("bin").exists());
}

#[test]
fn a_file_changed_by_hand_is_taken_in_as_an_edit_and_can_be_undone() {
    let dir = tempfile::tempdir().unwrap();
    drop(new_home(dir.path()));
    let path = dir.path().join("objects.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replacen("name = \"bottle_1\"", "name = \"my_bottle\"", 1),
    )
    .unwrap();
    let class = dir.path().join("classes/bottle/class.toml");
    let with_comment = format!("# Ours.\n{}", std::fs::read_to_string(&class).unwrap());
    std::fs::write(&class, &with_comment).unwrap();
    for _ in 0..2 {
        let check = Home::check(dir.path()).unwrap();
        let changed = [
            "classes/bottle/class.toml",
            "objects/bottle_1",
            "objects/my_bottle",
        ];
        assert_eq!(
            (check.n_entries, check.changed),
            (Some(1), changed.map(str::to_owned).to_vec())
        );
        assert!(check.aosm.objects.contains_key("my_bottle"));
    }

    let mut home = Home::open(dir.path(), 3.0).unwrap();
    assert!(
        home.aosm().objects.contains_key("my_bottle")
            && !home.aosm().objects.contains_key("bottle_1")
    );
    assert_eq!(
        std::fs::read_to_string(&class).unwrap(),
        with_comment,
        "a person's comments stay"
    );
    let latest = home.history(1).unwrap().remove(0);
    assert_eq!((latest.author.as_str(), latest.when_secs), ("file", 3.0));
    assert_eq!(
        latest.kind,
        EntryKind::Edit {
            what: "change classes/bottle/class.toml, objects.toml by hand".to_owned()
        }
    );
    home.undo("ada", 4.0).unwrap();
    assert!(home.aosm().objects.contains_key("bottle_1"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    // Setting a file back by hand, as version control does, is a change by hand too.
    home.edit(&move_bottle(5.0), "ada", 5.0).unwrap();
    drop(home);
    std::fs::write(&path, text).unwrap();
    assert_eq!(bottle_x(Home::open(dir.path(), 6.0).unwrap().aosm()), 1.0);
}

#[test]
fn a_file_changed_while_the_home_is_open_is_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let path = dir.path().join("objects.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replacen("name = \"bin_1\"", "name = \"our_own_bin\"", 1),
    )
    .unwrap();
    home.edit(&move_bottle(5.0), "ada", 1.0).unwrap();
    assert!(home.aosm().objects.contains_key("our_own_bin"));
    assert_eq!(bottle_x(home.aosm()), 5.0);
}

#[test]
fn a_new_class_folder_and_a_new_cloud_are_taken_in() {
    let dir = tempfile::tempdir().unwrap();
    drop(new_home(dir.path()));
    let drawer = dir.path().join("classes/drawer");
    std::fs::create_dir(&drawer).unwrap();
    for file in ["class.toml", "model.xml"] {
        std::fs::copy(objects_dir().join("drawer").join(file), drawer.join(file)).unwrap();
    }
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nend_header\n1 2 3\n";
    std::fs::write(dir.path().join("cloud.ply"), ply).unwrap();
    let mut home = Home::open(dir.path(), 1.0).unwrap();
    assert!(home.aosm().classes.contains_key("drawer"));
    assert_eq!(home.aosm().cloud.points(), [Point3::new(1.0, 2.0, 3.0)]);
    home.undo("ada", 2.0).unwrap();
    assert!(!drawer.exists() && !dir.path().join("cloud.ply").exists());
    home.redo("ada", 3.0).unwrap();
    assert!(drawer.join("model.xml").exists() && dir.path().join("cloud.ply").exists());
}

#[test]
fn a_file_broken_by_hand_is_refused_by_name_and_nothing_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    home.edit(&move_bottle(5.0), "ada", 1.0).unwrap();
    let wanted = home.aosm().clone();
    drop(home);
    let truncated = |bytes: &[u8]| bytes[..bytes.len() / 2].to_vec();
    type Breakage<'a> = (&'a str, &'a dyn Fn(&[u8]) -> Vec<u8>, &'a str);
    let misspelt = |bytes: &[u8]| {
        String::from_utf8_lossy(bytes)
            .replace("class =", "clas =")
            .into_bytes()
    };
    let breakages: [Breakage<'_>; 5] = [
        (
            "objects.toml",
            &misspelt,
            "objects.toml`:5: unknown key `clas`; did you mean `class`?",
        ),
        (
            "classes/bin/class.toml",
            &|_| b"name = 3".to_vec(),
            "class.toml`: line 1: invalid type",
        ),
        ("map.pgm", &truncated, "map.pgm`"),
        (
            "map.yaml",
            &|_| b"image: ../map.pgm\n".to_vec(),
            "map.yaml`",
        ),
        (
            "home.toml",
            &|_| b"format = 1\nnam = 'x'".to_vec(),
            "home.toml`:2: unknown key `nam`; did you mean `name`?",
        ),
    ];
    for (file, breakage, error) in breakages {
        let path = dir.path().join(file);
        let whole = std::fs::read(&path).unwrap();
        let broken = breakage(&whole);
        std::fs::write(&path, &broken).unwrap();
        let found = Home::open(dir.path(), 2.0).unwrap_err().to_string();
        assert!(found.contains(error), "{file}: {found}");
        assert_eq!(
            std::fs::read(&path).unwrap(),
            broken,
            "{file} is the person's to mend"
        );
        std::fs::write(&path, &whole).unwrap();
        let home = Home::open(dir.path(), 3.0).unwrap();
        assert_eq!(home.aosm(), &wanted);
        assert_eq!(home.history(10).unwrap().len(), 2, "{file}");
    }
}

#[test]
fn a_deleted_file_comes_back_from_the_journal() {
    let dir = tempfile::tempdir().unwrap();
    let home = new_home(dir.path());
    let wanted = home.aosm().clone();
    drop(home);
    for file in [
        "objects.toml",
        "map.pgm",
        "map.yaml",
        "home.toml",
        "domain.pddl",
    ] {
        std::fs::remove_file(dir.path().join(file)).unwrap();
    }
    std::fs::remove_dir_all(dir.path().join("classes")).unwrap();
    assert_eq!(Home::open(dir.path(), 1.0).unwrap().aosm(), &wanted);
    assert_eq!(home_folder::read(dir.path()).unwrap().1, wanted);
}

#[test]
fn a_damaged_journal_is_named_and_the_text_files_go_on_without_it() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    for x in 0..50 {
        home.edit(&move_bottle(f64::from(x)), "ada", 1.0).unwrap();
    }
    let wanted = home.aosm().clone();
    drop(home);
    let path = dir.path().join("journal.sqlite");
    let whole = std::fs::read(&path).unwrap();
    let damages = [
        b"not a database, but some text that is long enough to be one".repeat(9),
        Vec::new(),
        whole[..whole.len() / 2].to_vec(),
    ];
    for damaged in damages {
        std::fs::write(&path, &damaged).unwrap();
        for error in [
            Home::open(dir.path(), 2.0).unwrap_err(),
            Home::check(dir.path()).unwrap_err(),
        ] {
            assert!(matches!(error, MapError::JournalDamaged { .. }), "{error}");
            assert!(
                error.to_string().contains("journal.sqlite` is damaged"),
                "{error}"
            );
        }
    }
    std::fs::write(&path, &whole).unwrap();
    assert_eq!(
        Home::open(dir.path(), 3.0)
            .unwrap()
            .history(100)
            .unwrap()
            .len(),
        51
    );
    std::fs::remove_file(&path).unwrap();
    let home = Home::open(dir.path(), 4.0).unwrap();
    assert_eq!(home.aosm(), &wanted);
    assert_eq!(home.history(10).unwrap().len(), 1);
}

#[test]
fn one_process_at_a_time_and_no_home_on_top_of_a_home() {
    let dir = tempfile::tempdir().unwrap();
    let home = new_home(dir.path());
    assert!(matches!(
        Home::open(dir.path(), 1.0),
        Err(MapError::InUse { .. })
    ));
    assert!(
        home_folder::read(dir.path()).is_ok(),
        "reading needs no lock"
    );
    drop(home);
    assert!(Home::open(dir.path(), 1.0).is_ok());
    assert!(matches!(
        Home::create(dir.path(), "x", &household(), 2.0),
        Err(MapError::Exists { .. })
    ));
}

#[test]
fn a_folder_without_a_journal_is_adopted() {
    let dir = tempfile::tempdir().unwrap();
    home_folder::write(dir.path(), "imported", &household()).unwrap();
    let mut home = Home::open(dir.path(), 1.0).unwrap();
    assert_eq!(home.name(), "imported");
    home.edit(&Edit::SetHomeName("ours".to_owned()), "ada", 2.0)
        .unwrap();
    assert_eq!(home_folder::read(dir.path()).unwrap().0, "ours");
    home.undo("ada", 3.0).unwrap();
    assert_eq!(home.name(), "imported");
    assert!(matches!(
        Home::open(&dir.path().join("nowhere"), 1.0),
        Err(MapError::Io { .. })
    ));
}

#[test]
fn an_edit_of_the_map_keeps_the_pixels_that_still_say_the_same() {
    let dir = tempfile::tempdir().unwrap();
    drop(new_home(dir.path()));
    // A person's own shade of free.
    let path = dir.path().join("map.pgm");
    let pixels: Vec<u8> = std::fs::read(&path)
        .unwrap()
        .into_iter()
        .map(|b| if b == 254 { 250 } else { b })
        .collect();
    std::fs::write(&path, &pixels).unwrap();
    let mut home = Home::open(dir.path(), 1.0).unwrap();
    let mut grid = home.aosm().grid.clone();
    grid.set_cell(CellIndex { column: 3, row: 4 }, Cell::OCCUPIED);
    home.edit(&Edit::SetMap(grid), "robot", 2.0).unwrap();
    let after = std::fs::read(&path).unwrap();
    assert_eq!(after.iter().zip(&pixels).filter(|(a, b)| a != b).count(), 1);
    home.undo("ada", 3.0).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), pixels);
}

#[test]
fn a_text_file_that_cannot_be_written_is_written_later() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let in_the_way = dir.path().join(".objects.toml.part");
    std::fs::create_dir(&in_the_way).unwrap();
    home.edit(&move_bottle(5.0), "ada", 1.0).unwrap();
    let unwritten = home.unwritten().unwrap().to_string();
    assert!(unwritten.contains("objects.toml"), "{unwritten}");
    drop(home);
    // The folder lags behind, the home does not.
    assert_eq!(bottle_x(&home_folder::read(dir.path()).unwrap().1), 1.0);
    let home = Home::open(dir.path(), 2.0).unwrap();
    assert_eq!(bottle_x(home.aosm()), 5.0);
    assert!(home.unwritten().is_some());
    drop(home);
    std::fs::remove_dir(&in_the_way).unwrap();
    let home = Home::open(dir.path(), 3.0).unwrap();
    assert!(home.unwritten().is_none());
    assert_eq!(bottle_x(&home_folder::read(dir.path()).unwrap().1), 5.0);
    assert_eq!(home.history(9).unwrap().len(), 2);
}

#[test]
fn a_class_comes_with_all_the_files_of_its_folder() {
    let (dir, shelf) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let folder = shelf.path().join("drawer");
    std::fs::create_dir_all(folder.join("meshes")).unwrap();
    for file in ["class.toml", "model.xml"] {
        std::fs::copy(objects_dir().join("drawer").join(file), folder.join(file)).unwrap();
    }
    std::fs::write(folder.join("meshes/front.stl"), b"solid").unwrap();
    let mut home = new_home(dir.path());
    let class = ObjectClass::load(&folder).unwrap();
    home.edit(&Edit::PutClass(Box::new(class)), "ada", 1.0)
        .unwrap();
    let mesh = dir.path().join("classes/drawer/meshes/front.stl");
    assert_eq!(std::fs::read(&mesh).unwrap(), b"solid");
    drop(home);
    std::fs::write(&mesh, b"other").unwrap();
    let mut home = Home::open(dir.path(), 2.0).unwrap();
    home.undo("ada", 3.0).unwrap();
    assert_eq!(std::fs::read(&mesh).unwrap(), b"solid");
    home.undo("ada", 4.0).unwrap();
    assert!(!dir.path().join("classes/drawer").exists());
}

#[test]
fn replacing_everything_changes_only_what_differs() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let mut aosm = home.aosm().clone();
    assert_eq!(
        home.edit(&Edit::SetAll(Box::new(aosm.clone())), "robot", 1.0)
            .unwrap(),
        None
    );
    aosm.object_mut("bin_1").unwrap().position_std_m = 0.5;
    let entry = home
        .edit(&Edit::SetAll(Box::new(aosm.clone())), "robot", 2.0)
        .unwrap()
        .unwrap();
    let changed: Vec<String> = home
        .changes(entry)
        .unwrap()
        .into_iter()
        .map(|change| change.document)
        .collect();
    assert_eq!(changed, ["objects/bin_1"]);
    assert_eq!(home.aosm(), &aosm);
}
