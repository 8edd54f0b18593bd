//! Driven by hand: a home is mapped, nothing is touched, and what was found is kept.

pub(crate) mod page;

use std::cell::{Cell, RefCell};
use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

use factotum_agent::{Event, Executive, LogLevel, Settings, Steer, Wish};
use factotum_control::{
    BaseTwist, Command, MotionId, MotionStatus, Robot, RobotError, RobotState, Stamped,
};
use factotum_descriptions::RobotDescription;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{self, OccupancyGrid};
use factotum_geometry::sensing::{DepthFrame, LaserScan};
use factotum_semantic_map::Aosm;
use factotum_task_planning::planner::Ferroplan;
use factotum_worlds::{HomeScene, Noise, SimRobot, WorldConfig};
use nalgebra::Vector3;

use crate::small_home::SmallHome;
use crate::{assert_refused, factotum, factotum_in, repository};
use page::Page;

/// A robot in the small home, and the hardest push that it has felt.
struct Felt {
    sim: SimRobot,
    push_max_n: f64,
}

impl Felt {
    fn in_small_home(home: &SmallHome) -> Self {
        let sim = SimRobot::new(WorldConfig {
            robot: RobotDescription::load(&repository().join("assets/robots/movo")).unwrap(),
            scene: HomeScene::load(home.path()).unwrap(),
            seed: 3,
            noise: Noise::default(),
            fault: None,
        });
        Self {
            sim: sim.unwrap(),
            push_max_n: 0.0,
        }
    }
}

impl Robot for Felt {
    fn description(&self) -> &RobotDescription {
        self.sim.description()
    }

    fn state(&mut self) -> Result<RobotState, RobotError> {
        self.sim.state()
    }

    fn send(&mut self, command: Command) -> Result<MotionId, RobotError> {
        self.sim.send(command)
    }

    fn progress(&mut self, id: MotionId) -> Result<MotionStatus, RobotError> {
        self.sim.progress(id)
    }

    fn scan(&mut self) -> Result<Stamped<LaserScan>, RobotError> {
        self.sim.scan()
    }

    fn look(&mut self) -> Result<Stamped<DepthFrame>, RobotError> {
        self.sim.look()
    }

    /// In slices, so that no touch is missed.
    fn wait(&mut self, secs: f64) -> Result<(), RobotError> {
        const N_SLICES: u32 = 10;
        for _ in 0..N_SLICES {
            self.sim.wait(secs / f64::from(N_SLICES))?;
            self.push_max_n = self.push_max_n.max(self.sim.push_on_robot_n());
        }
        Ok(())
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.sim.stop()
    }
}

/// What is pressed, and for how many robot seconds: at the walls on all sides, then around and at them again.
const PRESSED: [([f64; 3], f64); 6] = [
    ([1.0, 0.0, 0.0], 5.0),
    ([0.0, 1.0, 0.0], 5.0),
    ([-1.0, 0.0, 0.0], 6.0),
    ([0.0, -1.0, 0.0], 6.0),
    ([0.0, 0.0, 1.0], 8.0),
    ([1.0, -1.0, 0.4], 6.0),
];

/// What is pressed so long after the beginning, until it is done.
fn pressed_at(secs: f64) -> Option<Vector3<f64>> {
    let mut until_secs = 0.0;
    PRESSED.into_iter().find_map(|(shares, for_secs)| {
        until_secs += for_secs;
        (secs < until_secs).then(|| Vector3::from(shares))
    })
}

#[test]
fn driven_at_every_wall_it_maps_the_home_and_touches_nothing() {
    let home = SmallHome::new();
    let mut robot = Felt::in_small_home(&home);
    let resolution_m = 0.05;
    let nothing =
        OccupancyGrid::filled(1, 1, resolution_m, Pose2::identity(), grid::Cell::UNKNOWN).unwrap();
    let aosm = Aosm::new(robot.sim.scene().classes().values().cloned(), nothing);
    let (areas_m2, warnings) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
    let n_checkpoints = Cell::new(0);
    let mut observer = |event: &Event<'_>| {
        match event {
            Event::Map { aosm, .. } => {
                let n_free = aosm
                    .grid
                    .cells()
                    .iter()
                    .filter(|cell| cell.is_free())
                    .count();
                areas_m2
                    .borrow_mut()
                    .push(n_free as f64 * resolution_m.powi(2));
            }
            Event::Log {
                level: LogLevel::Warning,
                text,
                ..
            } => warnings.borrow_mut().push(text.clone()),
            Event::Checkpoint { .. } => n_checkpoints.set(n_checkpoints.get() + 1),
            Event::Log { .. } | Event::Plan { .. } => {}
        }
        Wish::GoOn
    };
    let planner = Ferroplan::default();
    let settings = Settings::default();
    let mut executive = Executive::new(
        &mut robot,
        aosm,
        Pose2::identity(),
        &planner,
        &mut observer,
        settings,
        1,
    )
    .unwrap();
    let (mut began_secs, mut places) = (None, Vec::new());
    let mut driver = |state: &RobotState| {
        let began_secs = *began_secs.get_or_insert(state.time_secs);
        places.push(state.odom_from_base.translation.vector);
        pressed_at(state.time_secs - began_secs).map_or(Steer::Done, Steer::Drive)
    };
    executive.drive_by_hand(&mut driver).unwrap();
    let aosm = executive.into_aosm();

    assert_eq!(robot.push_max_n, 0.0, "physics felt a touch");
    let way_m: f64 = places
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    assert!(way_m > 4.0, "it drove {way_m:.2} m");
    // The floor between walls, counter and table is 8.5 m².
    let areas_m2 = areas_m2.into_inner();
    let (first, last) = (areas_m2[0], *areas_m2.last().unwrap());
    assert!(
        areas_m2.len() > 20,
        "{} pictures of the map",
        areas_m2.len()
    );
    assert!(last > first, "the map grew from {first} to {last} m²");
    assert!((7.5..9.5).contains(&last), "{last} m² of floor");
    assert!(aosm.objects_of("bottle").next().is_some(), "bottle seen");
    assert!(!aosm.cloud.points().is_empty());
    assert_eq!(n_checkpoints.get(), 1);
    let warnings = warnings.into_inner();
    let n_told = warnings
        .iter()
        .filter(|text| text.starts_with("held back: something is at ("))
        .count();
    assert!(
        (1..=PRESSED.len()).contains(&n_told),
        "told once for each wall at most: {warnings:?}"
    );
}

/// What the test above would see without the guard: else it could not fail.
#[test]
fn the_same_commands_unguarded_push_at_a_wall() {
    let home = SmallHome::new();
    let mut robot = Felt::in_small_home(&home);
    for _ in 0..60 {
        let forward = BaseTwist {
            velocity: Vector3::new(0.5, 0.0, 0.0),
            valid_secs: 0.25,
        };
        robot.send(Command::BaseTwist(forward)).unwrap();
        robot.wait(0.1).unwrap();
    }
    assert!(robot.push_max_n > 10.0, "{} N", robot.push_max_n);
}

/// The whole program with a page at its side: driven by its messages, ended by its Done, kept as a home in order.
#[test]
fn a_home_driven_from_the_page_is_kept() {
    let home = SmallHome::new();
    let mut running = std::process::Command::new(env!("CARGO_BIN_EXE_factotum"))
        .args(["map", "explore", "--drive", "--speed", "0", "--json"])
        .args(["--scene", home.path().to_str().unwrap(), "--out", "home"])
        .current_dir(home.path())
        .env("FACTOTUM_ASSETS", repository().join("assets"))
        .env("NO_COLOR", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut messages = BufReader::new(running.stderr.take().unwrap());
    let url = loop {
        let mut line = String::new();
        assert!(messages.read_line(&mut line).unwrap() > 0, "no address");
        if let Some((_, url)) = line.trim().split_once("watch at ") {
            break url.to_owned();
        }
    };
    let mut page = Page::open(&url);
    page.until(|message| message["type"] == "status" && message["takes_driving"] == true);

    page.send(r#"{"type":"drive","forward":1.5,"left":0,"turn":0}"#);
    let refusal = page.until(|message| message["type"] == "event" && message["level"] == "warning");
    let text = refusal["text"].as_str().unwrap();
    assert!(
        text.contains("1.5") && text.contains("in [-1, 1]"),
        "{text}"
    );

    // Ahead there is most of a metre of floor, whichever way it looks. A page hears of 60 states a second at most.
    let (mut n_states, mut from) = (0, None);
    loop {
        let message = page.until(|message| message["type"] == "state");
        let at =
            [&message["base"]["x"], &message["base"]["y"]].map(|value| value.as_f64().unwrap());
        let from = *from.get_or_insert(at);
        if (at[0] - from[0]).hypot(at[1] - from[1]) > 0.5 {
            break;
        }
        if n_states % 6 == 0 {
            page.send(r#"{"type":"drive","forward":1,"left":0,"turn":0}"#);
        }
        n_states += 1;
    }
    page.send(r#"{"type":"drive_done"}"#);
    let over =
        page.until(|message| message["type"] == "status" && message["activity"] == "finished");
    assert_eq!(over["takes_driving"], false);
    page.send(r#"{"type":"stop"}"#);

    let said = running.wait_with_output().unwrap();
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut messages, &mut rest).unwrap();
    assert_eq!(said.status.code(), Some(0), "{rest}");
    let answer: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    assert_eq!(answer["complete"], true, "{answer}");
    assert!(answer["width"].as_u64().unwrap() >= 80, "{answer}");
    let checked = factotum_in(home.path(), &["home", "check", "home"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stdout.contains("in order"), "{}", checked.stdout);
}

#[test]
fn driving_takes_a_page_and_a_base() {
    let explore = ["map", "explore", "--drive", "--out", "nowhere"];
    let said = factotum(&[&explore[..], &["--headless"]].concat());
    assert_refused(&said, &["--drive", "--headless", "page"]);
    let said = factotum(&[&explore[..], &["--robot", "panda"]].concat());
    assert_refused(&said, &["panda", "no mobile base"]);
}
