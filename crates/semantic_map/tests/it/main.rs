//! The AOSM against the shipped object classes: vocabulary, plans, options, and the home folder on disk.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failed unwrap is a failed test"
)]

mod crash;
mod home;
mod requests;

use std::path::{Path, PathBuf};

use factotum_descriptions::ObjectClass;
use factotum_geometry::grid::{Cell, OccupancyGrid};
use factotum_geometry::{Pose, Pose2};
use factotum_semantic_map::{
    Aosm, ChoreGoal, GraphNode, Location, MapError, ObjectSource, OptionKind, TopologicalGraph,
    Wanted, home_folder,
};
use factotum_task_planning::operator::GroundAction;
use factotum_task_planning::pddl::{write_domain, write_problem};
use factotum_task_planning::planner::{Ferroplan, Limits, Planner as _};

fn objects_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/objects")
}

fn household() -> Aosm {
    let classes = ["bottle", "bin", "light_switch", "faucet"]
        .map(|name| ObjectClass::load(&objects_dir().join(name)).unwrap());
    let grid = OccupancyGrid::filled(40, 30, 0.05, Pose2::identity(), Cell::FREE).unwrap();
    let mut aosm = Aosm::new(classes, grid);
    for (class, x) in [
        ("bottle", 1.0),
        ("bin", 2.0),
        ("light_switch", 3.0),
        ("faucet", 4.0),
    ] {
        aosm.add_object(
            class,
            Pose::translation(x, 0.5, 0.3),
            ObjectSource::Seen,
            0.01,
        )
        .unwrap();
    }
    aosm.object_mut("light_switch_1")
        .unwrap()
        .joints
        .insert("toggle".to_owned(), 0.35);
    aosm.object_mut("faucet_1")
        .unwrap()
        .joints
        .insert("handle".to_owned(), 1.2);
    aosm
}

fn chore(class: &str, wanted: Wanted) -> ChoreGoal {
    ChoreGoal {
        class: class.to_owned(),
        wanted,
    }
}

fn plan_for(aosm: &Aosm, goal: &ChoreGoal) -> Vec<String> {
    let domain = aosm.domain().unwrap();
    let problem = aosm
        .problem(&domain, goal.condition(aosm).unwrap())
        .unwrap();
    let outcome = Ferroplan::default()
        .solve(&domain, &problem, &Limits::default())
        .unwrap();
    let plan = outcome
        .plan()
        .unwrap_or_else(|| panic!("no plan for {goal:?}: {outcome:?}"));
    plan.steps.iter().map(ToString::to_string).collect()
}

#[test]
fn on_a_new_day_what_was_done_is_looked_at_again() {
    let mut aosm = household();
    let light = chore("light_switch", Wanted::State("off".to_owned()));
    let off = aosm.class("light_switch").unwrap().state("off").unwrap();
    let position = (off.range[0] + off.range[1]) / 2.0;
    let joints = &mut aosm.object_mut("light_switch_1").unwrap().joints;
    joints.insert("toggle".to_owned(), position);
    aosm.object_mut("bottle_1").unwrap().location = Location::In("bin_1".to_owned());
    assert!(plan_for(&aosm, &light).is_empty());
    aosm.begin_day();
    assert_eq!(plan_for(&aosm, &light), ["(turn_off light_switch_1)"]);
    let names: Vec<&String> = aosm.objects.keys().collect();
    assert_eq!(names, ["bin_1", "faucet_1", "light_switch_1"]);
    assert!(
        aosm.objects
            .values()
            .all(|object| object.position_std_m > 0.03)
    );
}

#[test]
fn the_three_chores_have_the_plans_one_expects() {
    let aosm = household();
    let throw_away = chore("bottle", Wanted::In("bin".to_owned()));
    assert_eq!(
        plan_for(&aosm, &throw_away),
        ["(pick bottle_1)", "(throw_away bottle_1 bin_1)"]
    );
    let light_off = chore("light_switch", Wanted::State("off".to_owned()));
    assert_eq!(plan_for(&aosm, &light_off), ["(turn_off light_switch_1)"]);
    let faucet_closed = chore("faucet", Wanted::State("closed".to_owned()));
    assert_eq!(plan_for(&aosm, &faucet_closed), ["(close_faucet faucet_1)"]);
}

#[test]
fn a_goal_that_holds_needs_no_steps() {
    let mut aosm = household();
    aosm.object_mut("light_switch_1")
        .unwrap()
        .joints
        .insert("toggle".to_owned(), -0.35);
    assert!(
        plan_for(
            &aosm,
            &chore("light_switch", Wanted::State("off".to_owned()))
        )
        .is_empty()
    );
}

#[test]
fn a_held_bottle_is_not_picked_again_and_blocks_the_switch() {
    let mut aosm = household();
    aosm.object_mut("bottle_1").unwrap().location = Location::Held;
    let throw_away = chore("bottle", Wanted::In("bin".to_owned()));
    assert_eq!(
        plan_for(&aosm, &throw_away),
        ["(throw_away bottle_1 bin_1)"]
    );
    // The switch needs an empty hand, so the bottle goes into the bin first.
    let light_off = chore("light_switch", Wanted::State("off".to_owned()));
    assert_eq!(plan_for(&aosm, &light_off).len(), 2);
}

#[test]
fn the_domain_reads_like_the_classes() {
    let mut aosm = household();
    aosm.classes
        .retain(|name, _| name == "light_switch" || name == "bottle" || name == "bin");
    aosm.objects.retain(|_, object| object.class != "faucet");
    let domain = aosm.domain().unwrap();
    let goal = chore("light_switch", Wanted::State("off".to_owned()))
        .condition(&aosm)
        .unwrap();
    let problem = aosm.problem(&domain, goal).unwrap();
    insta::assert_snapshot!(format!(
        "{}\n{}",
        write_domain(&domain),
        write_problem(&problem)
    ));
}

#[test]
fn a_goal_without_its_bin_says_what_is_missing() {
    let mut aosm = household();
    aosm.objects.remove("bin_1");
    let error = chore("bottle", Wanted::In("bin".to_owned()))
        .condition(&aosm)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "no bin has been found in this home; found: `bottle_1`, `faucet_1`, `light_switch_1`"
    );
}

#[test]
fn a_plan_step_binds_to_the_object_and_its_approach_region() {
    let aosm = household();
    let option = aosm
        .option(&GroundAction::new("throw_away", ["bottle_1", "bin_1"]))
        .unwrap();
    assert!(matches!(&option.kind, OptionKind::Place { target, .. } if target == "bin_1"));
    // The base must stand by the bin, not by the bottle.
    assert_eq!(
        option.anchor.map_from_object,
        aosm.object("bin_1").unwrap().map_from_object
    );
    let error = aosm
        .option(&GroundAction::new("turn_up", ["light_switch_1"]))
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "class `light_switch` has no action `turn_up`; it has: `turn_off`, `turn_on`"
    );
}

#[test]
fn the_graph_has_a_node_per_option_and_an_edge_per_drivable_pair() {
    let aosm = household();
    let nodes: Vec<GraphNode> = aosm
        .options()
        .into_iter()
        .enumerate()
        .map(|(i, option)| GraphNode {
            option: option.step,
            map_from_base: vec![Pose2::translation(i as f64, 0.0)],
        })
        .collect();
    let n = nodes.len();
    assert_eq!(n, 6, "pick and throw away, turn on and off, open and close");
    let graph = TopologicalGraph::build(nodes, |a, b| {
        let length_m = (a.translation.vector - b.translation.vector).norm();
        (length_m < 1.5).then_some(length_m)
    });
    assert_eq!(graph.edges.len(), n - 1, "only neighbours are within 1.5 m");
}

#[test]
fn a_home_folder_reads_back_as_it_was_written() {
    let mut aosm = household();
    aosm.object_mut("bottle_1").unwrap().location = Location::In("bin_1".to_owned());
    let dir = tempfile::tempdir().unwrap();
    home_folder::write(dir.path(), "test home", &aosm).unwrap();
    let (name, again) = home_folder::read(dir.path()).unwrap();
    assert_eq!(name, "test home");
    assert_eq!(again.grid, aosm.grid);
    for (object, read) in aosm.objects.values().zip(again.objects.values()) {
        let apart = object.map_from_object.inverse() * read.map_from_object;
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9);
        assert_eq!(
            (&object.name, &object.joints, &object.location),
            (&read.name, &read.joints, &read.location)
        );
    }
    // Writing it again changes no file.
    home_folder::write(dir.path(), "test home", &again).unwrap();
    assert_eq!(home_folder::read(dir.path()).unwrap().1, again);
}

#[test]
fn a_home_folder_that_contradicts_itself_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    home_folder::write(dir.path(), "test home", &household()).unwrap();
    let path = dir.path().join("objects.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("class = \"bin\"", "class = \"bim\"")).unwrap();
    let error = home_folder::read(dir.path()).unwrap_err();
    assert!(matches!(error, MapError::Home { .. }));
    assert!(
        error
            .to_string()
            .contains("object class `bim` is not in the map; known: `bin`"),
        "{error}"
    );
}
