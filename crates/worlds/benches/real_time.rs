//! How fast the simulated robot runs: each bench is one simulated second unless its name says otherwise, so a time of
//! 50 ms means twenty times real time.

use std::path::Path;

use factotum_control::{BaseTwist, Command, Impedance, Robot as _, ToolPath};
use factotum_descriptions::RobotDescription;
use factotum_worlds::{HomeScene, Noise, SimRobot, WorldConfig};
use nalgebra::Vector3;

fn main() {
    divan::main();
}

fn config() -> WorldConfig {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let load = "the assets of the repository load";
    WorldConfig {
        robot: RobotDescription::load(&assets.join("robots/movo")).expect(load),
        scene: HomeScene::load(&assets.join("scenes/household")).expect(load),
        seed: 1,
        noise: Noise::default(),
        fault: None,
    }
}

fn household() -> SimRobot {
    SimRobot::new(config()).expect("the household composes")
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn making_the_world(bencher: divan::Bencher<'_, '_>) {
    bencher.with_inputs(config).bench_values(SimRobot::new);
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn idle(bencher: divan::Bencher<'_, '_>) {
    let mut robot = household();
    bencher.bench_local(|| robot.wait(1.0));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn driving_in_a_circle(bencher: divan::Bencher<'_, '_>) {
    let mut robot = household();
    bencher.bench_local(|| {
        let twist = BaseTwist {
            velocity: Vector3::new(0.1, 0.0, 0.8),
            valid_secs: 1.0,
        };
        robot.send(Command::BaseTwist(twist))?;
        robot.wait(1.0)
    });
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn tool_under_impedance(bencher: divan::Bencher<'_, '_>) {
    let mut robot = household();
    let mut dynamics = factotum_control::ArmDynamics::new(robot.description()).expect("its model");
    bencher.bench_local(|| {
        let state = robot.state()?;
        let pose = dynamics
            .base_from_tcp(state.lift_m, &state.arm_positions)
            .expect("finite readings");
        robot.send(Command::Tool(ToolPath {
            base_from_tcp: vec![(0.0, pose), (1.0, pose)],
            impedance: Impedance::default(),
            stop_force_n: None,
            tolerance_m: 0.05,
        }))?;
        robot.wait(1.0)
    });
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn one_laser_scan(bencher: divan::Bencher<'_, '_>) {
    let mut robot = household();
    bencher.with_inputs(|| ()).bench_local_values(|()| {
        robot.wait(0.1)?;
        robot.scan()
    });
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn one_look(bencher: divan::Bencher<'_, '_>) {
    let mut robot = household();
    bencher.bench_local(|| robot.look());
}
