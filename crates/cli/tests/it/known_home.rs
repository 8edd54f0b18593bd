//! Executives at work in a home that they know, so that nothing need be explored: what is tested is what comes after.

use factotum_agent::{Event, Executive, RunReport, Settings, Wish};
use factotum_control::Robot;
use factotum_descriptions::RobotDescription;
use factotum_geometry::Pose2;
use factotum_semantic_map::{Aosm, ChoreGoal, ObjectSource};
use factotum_task_planning::planner::Ferroplan;
use factotum_worlds::{HomeScene, Noise, SimRobot, WorldConfig};
use nalgebra::Vector2;

use crate::repository;

/// A place in the kitchen of the household, facing the light switch.
pub(crate) fn near_the_switch() -> Pose2 {
    Pose2::new(Vector2::new(5.9, 3.4), std::f64::consts::PI)
}

/// Movo in the household, its senses as noisy as in a run.
pub(crate) fn household(seed: u64, world_from_start: Pose2) -> SimRobot {
    let assets = repository().join("assets");
    let scene = HomeScene::load(&assets.join("scenes/household")).unwrap();
    SimRobot::new(WorldConfig {
        robot: RobotDescription::load(&assets.join("robots/movo")).unwrap(),
        scene: scene.with_start(world_from_start),
        seed,
        noise: Noise::default(),
        fault: None,
    })
    .unwrap()
}

/// The home as it really is, as if it had been mapped without a fault; the map's frame is the world's.
pub(crate) fn true_map(sim: &SimRobot) -> Aosm {
    let scene = sim.scene();
    let classes = scene.classes().values().cloned();
    let mut aosm = Aosm::new(classes, sim.true_grid(0.05).unwrap());
    for object in scene.objects() {
        let map_from_object = sim.world_from_object(&object.name).unwrap();
        let name = aosm
            .add_object(&object.class, map_from_object, ObjectSource::Given, 0.01)
            .unwrap();
        assert_eq!(name, object.name, "the map names objects as the scene does");
        let joints = object
            .joints
            .iter()
            .map(|(joint, [low, high])| (joint.clone(), f64::midpoint(*low, *high)));
        aosm.object_mut(&name).unwrap().joints.extend(joints);
    }
    aosm
}

/// Lets an executive that believes `aosm` do a chore.
pub(crate) fn do_chore(
    robot: &mut dyn Robot,
    aosm: Aosm,
    map_from_odom: Pose2,
    class: &str,
    action: &str,
) -> RunReport {
    let goal = ChoreGoal::of_action(&aosm.classes[class], action).unwrap();
    let planner = Ferroplan::default();
    let mut observer = |_: &Event<'_>| Wish::GoOn;
    let settings = Settings::default();
    let mut executive = Executive::new(
        robot,
        aosm,
        map_from_odom,
        &planner,
        &mut observer,
        settings,
        1,
    )
    .unwrap();
    executive.do_chore(&goal).unwrap()
}
