//! Environment steps per second at a door, beside what the physics alone costs in the same states.
//!
//! An environment step is one action for 50 ms: 25 steps of 2 ms, in each of which the impedance law is computed from the
//! simulated arm, and an observation at the end. Two doors: robosuite's own Door scene, given as a file (its Panda, its
//! meshes), and ours (`assets/tasks/door.toml`). Actions are random and small; every hundredth step begins anew, which is
//! not measured.
//!
//! ```text
//! cargo bench -p factotum-worlds --bench contact -- path/to/robosuite_door/door.xml
//! ```
//!
//! What the control costs over the physics is measured step by step: each environment step is followed by its physics
//! steps alone, from the same state with the controls that were applied, and the median of the ratios of processor time
//! counts. So two times that are compared are less than a millisecond apart, and what else runs on the machine meets both.
//!
//! With the argument `paced` before the path it reads a line at a time, so that it can be measured in turn with
//! robosuite. On `robosuite` or `own` it makes [`N_STEPS`] steps there and answers with their number and the seconds they
//! took, on `overhead` with the share of time over the physics alone at robosuite's door.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it measured")]

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use factotum_control::impedance::ToolTarget;
use factotum_control::tool_servo::{JointGuard, ToolServo};
use factotum_control::{ArmState, Impedance, ModelArm};
use factotum_descriptions::TaskSpec;
use factotum_physics::{ActuatorId, JointId, Model, Pose, SiteId, Snapshot, State};
use factotum_skills::cip::rig::{Placing, Rig as _, RigCommand};
use factotum_worlds::TaskRig;
use nalgebra::{DVector, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rustix::time::{ClockId, clock_gettime};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Environment steps of one measurement.
const N_STEPS: u32 = 50;
const N_SUBSTEPS: usize = 25;
const N_ROUNDS: usize = 30;
const STEP_SECS: f64 = 0.002;
/// What an action moves the tool by at most, a fifth of robosuite's 50 mm and 0.5 rad.
const STEP_M: f64 = 0.01;
const STEP_RAD: f64 = 0.1;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let Some(file) = arguments.last().filter(|last| Path::new(last).is_file()) else {
        println!("skipped: give the path of robosuite's Door scene as MJCF");
        return Ok(());
    };
    let mut robosuite = RobosuiteDoor::new(Path::new(file))?;
    let mut own = OwnDoor::new()?;
    if arguments[0] == "paced" {
        for line in std::io::stdin().lines() {
            match line?.trim() {
                "robosuite" => println!("{N_STEPS} {}", robosuite.steps()?),
                "own" => println!("{N_STEPS} {}", own.steps()?),
                "overhead" => println!("{}", robosuite.overhead()?),
                other => return Err(format!("no measurement `{other}`").into()),
            }
        }
        return Ok(());
    }
    let mut rows: [Vec<f64>; 2] = Default::default();
    let mut overheads = Vec::new();
    for _ in 0..N_ROUNDS {
        rows[0].push(robosuite.steps()?);
        rows[1].push(own.steps()?);
        overheads.push(robosuite.overhead()?);
    }
    println!("environment steps/s, one thread, {N_ROUNDS} rounds");
    println!("| | median | most |\n|---|---|---|");
    let rate = |secs: f64| f64::from(N_STEPS) / secs;
    for (name, secs) in ["robosuite's door", "our door"].iter().zip(&rows) {
        let least = secs.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "| {name} | {:.0} | {:.0} |",
            rate(median(secs)),
            rate(least)
        );
    }
    println!(
        "robosuite's door takes {:.1} % longer than its physics alone, median of the rounds",
        100.0 * median(&overheads)
    );
    Ok(())
}

/// Seconds that this thread has been on the processor.
fn processor_secs() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// A small random action.
fn draw(rng: &mut ChaCha8Rng, base_from_tcp: &Pose) -> (Pose, Impedance) {
    let mut three = |most: f64| Vector3::from_fn(|_, _| rng.random_range(-most..most));
    let moved = Translation3::from(three(STEP_M)) * base_from_tcp.translation;
    let turned = UnitQuaternion::from_scaled_axis(three(STEP_RAD)) * base_from_tcp.rotation;
    let gains = Impedance {
        kp_position: three(150.0).add_scalar(150.0),
        kp_rotation: three(150.0).add_scalar(150.0),
        damping_ratio: 1.0,
    };
    (Pose::from_parts(moved, turned), gains)
}

/// robosuite's Door scene under our control law.
struct RobosuiteDoor {
    model: Model,
    state: State,
    motors: Vec<ActuatorId>,
    fingers: [ActuatorId; 2],
    finger_joints: [JointId; 2],
    hinge: JointId,
    handle: SiteId,
    servo: ToolServo,
    places: ModelArm,
    arm: ArmState,
    rng: ChaCha8Rng,
    n_done: u32,
    /// The controls of the last step's physics steps, one after the other.
    controls: Vec<f64>,
}

impl RobosuiteDoor {
    fn new(file: &Path) -> Outcome<Self> {
        let model = Model::from_mjcf_file(file)?;
        let mut state = State::new(&model)?;
        state.forward()?;
        let joint = |i: usize| model.joint(&format!("robot0_joint{i}"));
        let motor = |i: usize| model.actuator(&format!("robot0_torq_j{i}"));
        let motors = (1..=7).map(motor).collect::<Result<Vec<_>, _>>()?;
        let most: Vec<f64> = motors
            .iter()
            .map(|&motor| {
                model
                    .actuator_ctrl_range(motor)
                    .map_or(0.0, |range| range[1])
            })
            .collect();
        let joints = (1..=7).map(joint).collect::<Result<Vec<_>, _>>()?;
        let tcp = model.site("gripper0_right_grip_site")?;
        let places = ModelArm::new(&model, joints, tcp);
        let mut door = Self {
            motors,
            fingers: [
                model.actuator("gripper0_right_gripper_finger_joint1")?,
                model.actuator("gripper0_right_gripper_finger_joint2")?,
            ],
            finger_joints: [
                model.joint("gripper0_right_finger_joint1")?,
                model.joint("gripper0_right_finger_joint2")?,
            ],
            hinge: model.joint("Door_hinge")?,
            handle: model.site("Door_handle")?,
            servo: ToolServo::new(&most, JointGuard::None, DVector::zeros(7)),
            arm: places.read(&state),
            places,
            rng: ChaCha8Rng::seed_from_u64(1),
            n_done: 0,
            controls: Vec::new(),
            state,
            model,
        };
        door.begin()?;
        Ok(door)
    }

    fn begin(&mut self) -> Outcome<()> {
        self.state.reset_to_keyframe(self.model.keyframe("home")?)?;
        self.state.forward()?;
        self.places.read_into(&self.state, &mut self.arm);
        self.servo.restart(&self.arm)?;
        Ok(())
    }

    fn begin_every_hundredth(&mut self) -> Outcome<()> {
        if self.n_done.is_multiple_of(100) {
            self.begin()?;
        }
        self.n_done += N_STEPS;
        Ok(())
    }

    /// Seconds that [`N_STEPS`] steps take.
    fn steps(&mut self) -> Outcome<f64> {
        self.begin_every_hundredth()?;
        let start = Instant::now();
        for _ in 0..N_STEPS {
            self.step()?;
        }
        Ok(start.elapsed().as_secs_f64())
    }

    /// How much longer a step takes than its physics alone, as a share of that: median of [`N_STEPS`].
    fn overhead(&mut self) -> Outcome<f64> {
        self.begin_every_hundredth()?;
        let mut shares = Vec::new();
        for _ in 0..N_STEPS {
            let before = self.state.snapshot();
            let start = processor_secs();
            self.step()?;
            let whole = processor_secs() - start;
            shares.push(whole / self.repeat(&before)? - 1.0);
        }
        Ok(median(&shares))
    }

    /// One environment step.
    fn step(&mut self) -> Outcome<()> {
        self.controls.clear();
        let tcp = self.state.world_from_site(self.places.tcp());
        let (target, gains) = draw(&mut self.rng, &tcp);
        let target = ToolTarget::at_rest(target);
        for _ in 0..N_SUBSTEPS {
            self.state.step1()?;
            self.places.read_into(&self.state, &mut self.arm);
            let torques = self.servo.torques(&self.arm, &target, &gains, STEP_SECS)?;
            for (&motor, &torque) in self.motors.iter().zip(torques) {
                self.state.set_ctrl(motor, torque);
            }
            for (&finger, wide) in self.fingers.iter().zip([0.04, -0.04]) {
                self.state.set_ctrl(finger, wide);
            }
            self.controls.extend_from_slice(self.state.ctrl());
            self.state.step2()?;
        }
        self.state.forward_kinematics()?;
        black_box(self.observation());
        Ok(())
    }

    /// What robosuite tells a policy.
    fn observation(&self) -> Vec<f64> {
        let mut seen = Vec::with_capacity(51);
        for &joint in self.places.joints() {
            let q = self.state.joint_position(joint);
            seen.extend([q.cos(), q.sin(), self.state.joint_velocity(joint)]);
        }
        let tcp = self.state.world_from_site(self.places.tcp());
        let handle = self.state.world_from_site(self.handle).translation.vector;
        seen.extend(tcp.translation.vector.iter());
        seen.extend(tcp.rotation.coords.iter());
        for &joint in &self.finger_joints {
            seen.extend([
                self.state.joint_position(joint),
                self.state.joint_velocity(joint),
            ]);
        }
        seen.extend(handle.iter());
        seen.extend((handle - tcp.translation.vector).iter());
        seen.push(self.state.joint_position(self.hinge));
        seen
    }

    /// Processor seconds that the physics steps of the last step take alone, from the state before it.
    fn repeat(&mut self, before: &Snapshot) -> Outcome<f64> {
        let after = self.state.snapshot();
        self.state.restore(before)?;
        let start = processor_secs();
        for controls in self.controls.chunks_exact(self.model.n_u()) {
            self.state.ctrl_mut().copy_from_slice(controls);
            self.state.step()?;
        }
        let secs = processor_secs() - start;
        self.state.restore(&after)?;
        self.state.forward()?;
        Ok(secs)
    }
}

/// Our door task on its rig.
struct OwnDoor {
    rig: TaskRig,
    placing: Placing,
    rng: ChaCha8Rng,
    n_done: u32,
}

impl OwnDoor {
    fn new() -> Outcome<Self> {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let task = TaskSpec::load(&assets.join("tasks/door.toml"))?;
        let rig = TaskRig::new(&task)?;
        let placing = Placing {
            base_from_object: task.placement.at([0.5; 4]),
            object_joint: task.start,
            q: rig.anatomy().robot.q_ready(),
            opening: 1.0,
        };
        Ok(Self {
            rig,
            placing,
            rng: ChaCha8Rng::seed_from_u64(1),
            n_done: 0,
        })
    }

    /// Seconds that [`N_STEPS`] steps take.
    fn steps(&mut self) -> Outcome<f64> {
        if self.n_done.is_multiple_of(100) {
            self.rig.place(&self.placing)?;
        }
        self.n_done += N_STEPS;
        let start = Instant::now();
        for _ in 0..N_STEPS {
            let (base_from_tcp, impedance) = draw(&mut self.rng, &self.rig.reading().base_from_tcp);
            self.rig.step(&RigCommand {
                base_from_tcp,
                impedance,
                opening: 1.0,
            })?;
            black_box(self.rig.reading());
        }
        Ok(start.elapsed().as_secs_f64())
    }
}
