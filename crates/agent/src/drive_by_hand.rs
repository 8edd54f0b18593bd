//! Driven by hand: the other way to know a home. A person steers; the robot scans, maps and looks as it goes, and keeps
//! itself from touching anything that it knows of.
//!
//! Velocities expire ([`VALID_SECS`]), so a driver who falls silent means a robot at rest.

use factotum_control::base_tracking::BaseLimits;
use factotum_control::{BaseTwist, Command, RobotError, RobotState};
use factotum_geometry::grid::{OccupancyGrid, SignedCell};
use nalgebra::{Point2, Vector3};

use crate::braking::{SafeVelocity, safe_velocity};
use crate::senses::Care;
use crate::{AgentError, Executive, LogLevel};

/// Time from one velocity to the next, seconds.
const PERIOD_SECS: f64 = 0.1;
/// How long a velocity holds unless another follows, seconds.
const VALID_SECS: f64 = 0.25;
/// Distance kept between footprint and obstacles, metres: a cell of the map, and the lidar's noise.
const CLEAR_M: f64 = 0.05;
/// Periods from one look to the next.
const N_PERIODS_PER_LOOK: usize = 8;
/// Periods from one picture of the map to the next.
const N_PERIODS_PER_MAP: usize = 10;
/// Periods at rest after which nothing new is to be seen.
const N_PERIODS_IDLE: usize = 20;

/// What a driver wishes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Steer {
    /// A velocity of the base, as shares of its limits in `[-1, 1]`: ahead, to the left, turning counterclockwise.
    Drive(Vector3<f64>),
    /// The drive is over.
    Done,
}

/// Whoever drives by hand.
pub trait Driver {
    /// Asked ten times a second of the robot's clock. It must not block.
    fn steer(&mut self, state: &RobotState) -> Steer;
}

impl<F: FnMut(&RobotState) -> Steer> Driver for F {
    fn steer(&mut self, state: &RobotState) -> Steer {
        self(state)
    }
}

/// Whether the driver has been told that something is in the way.
#[derive(Debug, Default)]
struct Told {
    is_told: bool,
    n_periods_free: usize,
}

impl Told {
    /// Whether to tell: once, until there was nothing in the way for a while.
    fn is_news(&mut self, is_held_back: bool) -> bool {
        if !is_held_back {
            self.n_periods_free += 1;
            self.is_told &= self.n_periods_free < N_PERIODS_IDLE;
            return false;
        }
        self.n_periods_free = 0;
        !std::mem::replace(&mut self.is_told, true)
    }
}

impl Executive<'_> {
    /// Lets a driver steer until it is done, and maps what comes into view.
    ///
    /// # Errors
    /// [`AgentError`] for faults of the robot, or if it has no base, and [`AgentError::Stopped`] when the observer wished
    /// to stop.
    pub fn drive_by_hand(&mut self, driver: &mut dyn Driver) -> Result<(), AgentError> {
        let limits = self.base_limits()?;
        self.tuck()?;
        self.look_at_rest(Care::InPassing)?;
        self.show_map()?;
        self.log(LogLevel::Info, "ready to be driven by hand".to_owned())?;
        let (mut told, mut n_idle) = (Told::default(), 0);
        for period in 1_usize.. {
            let state = self.robot.state()?;
            let Steer::Drive(shares) = driver.steer(&state) else {
                break;
            };
            let wished = velocity_of(&shares, &limits);
            let safe = self.keep_clear(&state, &wished, &limits)?;
            if told.is_news(safe.obstacle.is_some())
                && let Some(place) = safe.obstacle
            {
                let place = self.map_from_base()? * place;
                self.log(
                    LogLevel::Warning,
                    format!(
                        "held back: something is at ({:.1}, {:.1}) m",
                        place.x, place.y
                    ),
                )?;
            }
            self.robot.send(Command::BaseTwist(BaseTwist {
                velocity: safe.velocity,
                valid_secs: VALID_SECS,
            }))?;
            self.robot.wait(PERIOD_SECS)?;
            let is_moving = wished != Vector3::zeros();
            n_idle = if is_moving { 0 } else { n_idle + 1 };
            self.sense_on_the_way(period, n_idle)?;
        }
        self.robot.stop()?;
        self.look_at_rest(Care::InPassing)?;
        self.show_map()?;
        self.checkpoint()?;
        self.conclude("driven by hand")
    }

    /// Scans; looks and shows the map from time to time, until the robot has stood for a while.
    fn sense_on_the_way(&mut self, period: usize, n_idle: usize) -> Result<(), AgentError> {
        if n_idle < N_PERIODS_IDLE && period.is_multiple_of(N_PERIODS_PER_LOOK) {
            self.observe_home()?;
        } else {
            self.senses.feel(self.robot)?;
        }
        if n_idle < N_PERIODS_IDLE && period.is_multiple_of(N_PERIODS_PER_MAP) {
            self.show_map()?;
        }
        if n_idle == N_PERIODS_IDLE {
            self.show_map()?;
            self.checkpoint()?;
        }
        Ok(())
    }

    fn base_limits(&self) -> Result<BaseLimits, AgentError> {
        let description = self.robot.description();
        let Some(base) = &description.base else {
            return Err(RobotError::Absent {
                robot: description.name.clone(),
                what: "mobile base",
            }
            .into());
        };
        Ok(base.into())
    }

    /// What of a wished velocity leads near nothing that the last scan or the map shows.
    fn keep_clear(
        &self,
        state: &RobotState,
        wished: &Vector3<f64>,
        limits: &BaseLimits,
    ) -> Result<SafeVelocity, AgentError> {
        let keep_m = self.footprint_m() + CLEAR_M;
        // Farther than it goes in a second and takes to brake, the base does not come before it is asked again.
        let speed = limits.velocity_max_m_per_s;
        let reach_m = keep_m + speed + speed.powi(2) / (2.0 * limits.acceleration_max_m_per_s2);
        let base_from_odom = state.odom_from_base.inverse();
        let base_from_map = base_from_odom * self.senses.map_from_odom().inverse();
        let felt = self.senses.felt_in_odom().iter();
        let mut obstacles: Vec<Point2<f64>> = felt.map(|hit| base_from_odom * hit).collect();
        if let Some(map) = self.senses.map() {
            let here = base_from_map.inverse().translation.vector.into();
            let mapped = occupied_about(map, &here, reach_m);
            obstacles.extend(mapped.map(|center| base_from_map * center));
        }
        obstacles.retain(|point| point.coords.norm() < reach_m);
        let now = &state.base_velocity;
        Ok(safe_velocity(limits, now, wished, &obstacles, keep_m))
    }
}

/// Centres of the occupied cells in a square about a place, `reach_m` to each side.
fn occupied_about<'a>(
    map: &'a OccupancyGrid,
    place: &Point2<f64>,
    reach_m: f64,
) -> impl Iterator<Item = Point2<f64>> + 'a {
    let reach = (reach_m / map.resolution_m()).ceil() as i64;
    let middle = map.signed_cell_at(place);
    let square = (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| (x, y)));
    square
        .filter_map(move |(x, y)| {
            map.index_of_signed(SignedCell {
                column: middle.column + x,
                row: middle.row + y,
            })
        })
        .filter(|index| map.cell(*index).is_occupied())
        .map(|index| map.center_of(index))
}

/// The velocity that the shares mean. What is no number is a hand at rest.
fn velocity_of(shares: &Vector3<f64>, limits: &BaseLimits) -> Vector3<f64> {
    if shares.iter().any(|share| !share.is_finite()) {
        return Vector3::zeros();
    }
    let speed = limits.velocity_max_m_per_s;
    let full = Vector3::new(speed, speed, limits.yaw_rate_max_rad_per_s);
    shares
        .map(|share| share.clamp(-1.0, 1.0))
        .component_mul(&full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_beyond_the_limits_are_the_limits_and_no_numbers_are_rest() {
        let limits = BaseLimits {
            velocity_max_m_per_s: 0.5,
            yaw_rate_max_rad_per_s: 0.8,
            acceleration_max_m_per_s2: 0.5,
        };
        let velocity = |x, y, z| velocity_of(&Vector3::new(x, y, z), &limits);
        assert_eq!(velocity(3.0, -0.5, -1.0), Vector3::new(0.5, -0.25, -0.8));
        assert_eq!(velocity(f64::NAN, 1.0, 1.0), Vector3::zeros());
        assert_eq!(velocity(1.0, f64::INFINITY, 0.0), Vector3::zeros());
    }

    #[test]
    fn a_thing_in_the_way_is_told_once_until_the_way_was_free_for_a_while() {
        let mut told = Told::default();
        assert!(told.is_news(true));
        assert!(!told.is_news(true));
        assert!(!told.is_news(false));
        assert!(!told.is_news(true));
        for _ in 0..N_PERIODS_IDLE {
            assert!(!told.is_news(false));
        }
        assert!(told.is_news(true));
    }
}
