//! Finding oneself in a stored map, as on the second day in a home: by scans, turning on the spot, and driving a little
//! where turning does not tell.

use std::f64::consts::TAU;

use factotum_control::{BaseTwist, Command, Robot};
use factotum_geometry::Pose2;
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::sensing::LaserScan;
use factotum_perception::localise::{GlobalLocaliser, Localisation, LocaliseParams};
use nalgebra::{Rotation2, Vector3};

use crate::{AgentError, Event, LogLevel, Observer, Wish};

/// Looks in a full turn.
const N_LOOKS: usize = 6;
/// Drives after which the search is given up.
const N_DRIVES_MAX: usize = 4;
/// Looks in a row that must name one pose before it is believed.
const N_AGREED: usize = 2;
/// Longest drive to another view, metres.
const DRIVE_M: f64 = 0.8;
/// Room kept beside and before the footprint while driving without a map, metres.
const ROOM_M: f64 = 0.15;
/// How often a drive is looked at, seconds.
const PERIOD_SECS: f64 = 0.1;

/// Where the odometry frame lies in `map`, of a robot that stands anywhere in it.
///
/// # Errors
/// [`AgentError::NotInMap`] if no place looks like what the robot scans, or several do, after some driving;
/// [`AgentError`] if the robot does not answer, and [`AgentError::Stopped`] when the observer wished to stop.
pub fn find_in_map(
    robot: &mut dyn Robot,
    map: &OccupancyGrid,
    observer: &mut dyn Observer,
) -> Result<Pose2, AgentError> {
    log(robot, observer, "looking where I am".to_owned())?;
    let mut localiser = GlobalLocaliser::new(map, LocaliseParams::default());
    let mut n_agreed = 0;
    let mut verdict = String::new();
    for drive in 0..=N_DRIVES_MAX {
        if drive > 0 {
            drive_on(robot)?;
        }
        for _ in 0..N_LOOKS {
            let scan = robot.scan()?;
            match localiser.update(&scan.odom_from_base, &scan.data) {
                Localisation::Found(place) => {
                    n_agreed += 1;
                    if n_agreed >= N_AGREED {
                        let at = place.map_from_base.translation;
                        let text = format!("I am at ({:.1}, {:.1}) m of the map", at.x, at.y);
                        log(robot, observer, text)?;
                        return Ok(place.map_from_base * scan.odom_from_base.inverse());
                    }
                }
                Localisation::Ambiguous { candidates } => {
                    n_agreed = 0;
                    verdict = format!("{} places in it look like this", candidates.len());
                }
                Localisation::Lost {
                    confidence,
                    confidence_min,
                } => {
                    n_agreed = 0;
                    verdict = format!(
                        "no place in it looks like this: the best agrees to {confidence:.2}, expected {confidence_min}"
                    );
                }
            }
            turn(robot, TAU / N_LOOKS as f64)?;
        }
        log(robot, observer, verdict.clone())?;
    }
    Err(AgentError::NotInMap { verdict })
}

fn log(robot: &mut dyn Robot, observer: &mut dyn Observer, text: String) -> Result<(), AgentError> {
    let event = Event::Log {
        time_secs: robot.state()?.time_secs,
        level: LogLevel::Info,
        text,
    };
    match observer.observe(&event) {
        Wish::GoOn => Ok(()),
        Wish::Stop => Err(AgentError::Stopped),
    }
}

fn turn(robot: &mut dyn Robot, angle_rad: f64) -> Result<(), AgentError> {
    let limit = robot.description().base.as_ref();
    let rate = limit.map_or(0.5, |base| base.yaw_rate_max_rad_per_s);
    let rate = rate.copysign(angle_rad);
    let n_periods = (angle_rad / rate / PERIOD_SECS).ceil() as usize;
    for _ in 0..n_periods {
        twist(robot, Vector3::new(0.0, 0.0, rate))?;
    }
    come_to_rest(robot)
}

/// Turns to where there is most room and drives there, as far as the scan says that it is free.
fn drive_on(robot: &mut dyn Robot) -> Result<(), AgentError> {
    let (radius_m, speed_m_per_s) = robot
        .description()
        .base
        .as_ref()
        .map_or((0.3, 0.1), |base| {
            (base.footprint_radius_m, base.velocity_max_m_per_s / 2.0)
        });
    let scan = robot.scan()?.data;
    let directions = (0..2 * N_LOOKS).map(|i| TAU * i as f64 / (2 * N_LOOKS) as f64);
    let roomiest = directions
        .map(|angle| (free_m(&scan, angle, radius_m), angle))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((room_m, angle)) = roomiest else {
        return Ok(());
    };
    turn(
        robot,
        if angle > TAU / 2.0 {
            angle - TAU
        } else {
            angle
        },
    )?;
    let step_m = speed_m_per_s * PERIOD_SECS;
    let n_periods = (room_m.min(DRIVE_M) / step_m) as usize;
    for _ in 0..n_periods {
        if free_m(&robot.scan()?.data, 0.0, radius_m) < step_m {
            break;
        }
        twist(robot, Vector3::new(speed_m_per_s, 0.0, 0.0))?;
    }
    come_to_rest(robot)
}

/// How far a disc of `radius_m` can go from the base in the direction `angle_rad` of the base frame, with room to spare.
fn free_m(scan: &LaserScan, angle_rad: f64, radius_m: f64) -> f64 {
    let base_from_way = Rotation2::new(angle_rad);
    let ends = scan.rays().filter(|ray| ray.is_hit);
    let ahead = ends
        .map(|ray| base_from_way.inverse() * ray.end_in_base)
        .filter(|end| end.x > 0.0 && end.y.abs() < radius_m + ROOM_M)
        .map(|end| end.x);
    (ahead.fold(scan.range_max_m, f64::min) - radius_m - ROOM_M).max(0.0)
}

fn twist(robot: &mut dyn Robot, velocity: Vector3<f64>) -> Result<(), AgentError> {
    robot.send(Command::BaseTwist(BaseTwist {
        velocity,
        valid_secs: 2.0 * PERIOD_SECS,
    }))?;
    Ok(robot.wait(PERIOD_SECS)?)
}

fn come_to_rest(robot: &mut dyn Robot) -> Result<(), AgentError> {
    Ok(robot.wait(4.0 * PERIOD_SECS)?)
}
