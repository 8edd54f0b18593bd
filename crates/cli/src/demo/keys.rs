//! Keys that move the tool, or a joint.
//!
//! A key moves for a fifth of a second, and holding it down goes on. In a terminal time runs as on the wall, whether keys come
//! or not; from a pipe each character is a key, and time passes by keys alone, so that a motion can be kept as text.

use std::io::{IsTerminal as _, Read as _};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use factotum_skills::cip::rig::Rig as _;
use factotum_worlds::TaskRig;
use nalgebra::{DVector, Matrix6, Vector6};
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};

use crate::console::Console;

/// What `--help` says of them.
pub(super) const HELP: &str = "\
Keys:
  w s, a d, r f   tool forward and back, left and right, up and down, in the robot's base frame
  i k, j l, u o   tool about the base frame's y, x and z axis
  1 to 9, [ ]     choose a joint, and move it back or on
  + -             faster, slower
  . or space      stay for a moment
  x               done

Time runs as on the wall. Without a terminal every character of standard input is a key and takes 0.2 s:
  echo 'wwwwaaaax' | factotum demo record t-ball";

/// A key moves for so long, seconds.
const KEY_SECS: f64 = 0.2;

/// Speeds of the tool and of a joint at the start.
const TOOL_M_PER_SEC: f64 = 0.15;
const TOOL_RAD_PER_SEC: f64 = 0.6;
const JOINT_RAD_PER_SEC: f64 = 0.6;

/// `+` and `-` change speeds by this factor, within these bounds.
const FASTER: f64 = 1.5;
const SPEED_BOUNDS: [f64; 2] = [0.1, 10.0];

/// Of the damped inverse of the Jacobian, so that the arm comes through singular postures.
const DAMPING: f64 = 0.1;

/// Nobody moves an arm for longer, seconds.
const SECS_MAX: f64 = 300.0;

/// Keys, and what they mean now.
pub(super) struct Keyboard {
    keys: Keys,
    speed: f64,
    joint: usize,
    motion: Motion,
    left_secs: f64,
    secs: f64,
    begun: Option<Instant>,
}

enum Keys {
    /// As they are pressed, on a terminal that is left as it was found.
    Live(
        Receiver<char>,
        #[expect(dead_code, reason = "for its drop")] Option<TerminalMode>,
    ),
    /// All there are, the last first.
    Script(Vec<char>),
}

/// The terminal's mode, which comes back in the end: whoever waits for a key has it changed.
struct TerminalMode(Termios);

impl TerminalMode {
    fn now() -> Option<Self> {
        tcgetattr(std::io::stdin()).ok().map(Self)
    }
}

impl Drop for TerminalMode {
    fn drop(&mut self) {
        // Where it fails there is no terminal any more.
        let _gone = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.0);
    }
}

/// What moves now.
#[derive(Clone, Copy)]
enum Motion {
    None,
    /// Linear then angular velocity, as shares of the speeds.
    Tool(Vector6<f64>),
    Joint(f64),
}

impl Keyboard {
    pub(super) fn new() -> anyhow::Result<Self> {
        let keys = if std::io::stdin().is_terminal() {
            let mode = TerminalMode::now();
            let (sender, receiver) = sync_channel(64);
            // It waits for the last key until the program ends.
            std::thread::Builder::new()
                .name("keys".to_owned())
                .spawn(move || {
                    let terminal = ::console::Term::stdout();
                    while let Ok(key) = terminal.read_char() {
                        if sender.send(key).is_err() {
                            return;
                        }
                    }
                })?;
            Keys::Live(receiver, mode)
        } else {
            let mut text = String::new();
            std::io::stdin().read_to_string(&mut text)?;
            let keys = text.chars().filter(|key| !matches!(key, '\n' | '\r'));
            Keys::Script(keys.rev().collect())
        };
        Ok(Self {
            keys,
            speed: 1.0,
            joint: 0,
            motion: Motion::None,
            left_secs: 0.0,
            secs: 0.0,
            begun: None,
        })
    }

    /// Sets joint velocities for the next step; false when all is done.
    pub(super) fn jog(&mut self, rig: &TaskRig, action: &mut [f64], console: &Console) -> bool {
        let step_secs = 1.0 / rig.task().episode.control_hz;
        if !self.listen(action.len()) || self.secs > SECS_MAX {
            return false;
        }
        if self.left_secs > 0.0 {
            self.left_secs -= step_secs;
            self.move_by(rig, action);
        }
        self.secs += step_secs;
        if matches!(self.keys, Keys::Live(..)) {
            let begun = *self.begun.get_or_insert_with(Instant::now);
            let due = Duration::from_secs_f64(self.secs);
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
        }
        let reading = rig.reading();
        let tool = reading.base_from_tcp.translation;
        console.progress(format!(
            "{:5.1} s  tool ({:.3}, {:.3}, {:.3}) m  object {:.3}  joint {}  speed {:.1}",
            self.secs,
            tool.x,
            tool.y,
            tool.z,
            reading.object_joint,
            self.joint + 1,
            self.speed
        ));
        true
    }

    /// Takes the keys there are; false for the last.
    fn listen(&mut self, n_joints: usize) -> bool {
        loop {
            let key = match &mut self.keys {
                Keys::Live(keys, _) => match keys.try_recv() {
                    Ok(key) => key,
                    Err(TryRecvError::Empty) => return true,
                    Err(TryRecvError::Disconnected) => return false,
                },
                // Half a step is rounding.
                Keys::Script(_) if self.left_secs > 1e-9 => return true,
                Keys::Script(keys) => match keys.pop() {
                    Some(key) => key,
                    None => return false,
                },
            };
            if key == 'x' {
                return false;
            }
            self.take(key, n_joints);
        }
    }

    fn take(&mut self, key: char, n_joints: usize) {
        let axis = |i: usize, sign: f64| {
            let mut velocity = Vector6::zeros();
            velocity[i] = sign;
            Motion::Tool(velocity)
        };
        self.motion = match key {
            'w' => axis(0, 1.0),
            's' => axis(0, -1.0),
            'a' => axis(1, 1.0),
            'd' => axis(1, -1.0),
            'r' => axis(2, 1.0),
            'f' => axis(2, -1.0),
            'i' => axis(4, 1.0),
            'k' => axis(4, -1.0),
            'j' => axis(3, -1.0),
            'l' => axis(3, 1.0),
            'u' => axis(5, 1.0),
            'o' => axis(5, -1.0),
            '[' => Motion::Joint(-1.0),
            ']' => Motion::Joint(1.0),
            '.' | ' ' => Motion::None,
            '+' | '-' => {
                let factor = if key == '+' { FASTER } else { 1.0 / FASTER };
                let [slowest, fastest] = SPEED_BOUNDS;
                self.speed = (self.speed * factor).clamp(slowest, fastest);
                return;
            }
            _ => {
                if let Some(digit) = key.to_digit(10).filter(|digit| *digit > 0) {
                    self.joint = (digit as usize - 1).min(n_joints.saturating_sub(1));
                }
                return;
            }
        };
        self.left_secs = KEY_SECS;
    }

    fn move_by(&self, rig: &TaskRig, action: &mut [f64]) {
        match self.motion {
            Motion::None => {}
            Motion::Joint(sign) => action[self.joint] = self.speed * sign * JOINT_RAD_PER_SEC,
            Motion::Tool(shares) => {
                let mut velocity = shares * self.speed;
                velocity.fixed_rows_mut::<3>(0).scale_mut(TOOL_M_PER_SEC);
                velocity.fixed_rows_mut::<3>(3).scale_mut(TOOL_RAD_PER_SEC);
                let q = &rig.reading().arm_positions;
                let jacobian = rig.anatomy().robot.chain().jacobian(q);
                let square: Matrix6<f64> = (&jacobian * jacobian.transpose())
                    .fixed_view::<6, 6>(0, 0)
                    .into_owned();
                let damped = square + Matrix6::identity() * DAMPING.powi(2);
                // The damping makes it positive.
                if let Some(damped) = damped.cholesky() {
                    let joints: DVector<f64> = jacobian.transpose() * damped.solve(&velocity);
                    let limits = &rig.anatomy().robot.description().arm.velocity_max_rad_per_s;
                    let shares = joints.iter().zip(limits).map(|(v, most)| v.abs() / most);
                    // All slower alike where one is too fast, so that the direction stays.
                    let factor = 1.0 / shares.fold(1.0, f64::max);
                    for (action, velocity) in action.iter_mut().zip(&joints) {
                        *action = factor * velocity;
                    }
                }
            }
        }
    }
}
