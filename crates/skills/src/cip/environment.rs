//! A contact task as something to learn on: the head ends in a grasp, then π_c acts until β_c or B.

use std::borrow::Cow;

use factotum_descriptions::{PlacementRange, TaskSpec};
use factotum_geometry::Pose;
use factotum_learning::action::ActionError;
use factotum_learning::environment::{Environment, Step};
use factotum_learning::replay::Ending;
use factotum_motion::{MotionError, PlanningScene};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::action::{CLOSING_STEPS, CLOSING_STROKE, HOLD, N_ACTION, opening_around};
use super::configuration::configurations;
use super::ending::{FailureClassifier, FailureKind, FailureMemory, SuccessIndicator};
use super::guide::{Guide, GuideParams};
use super::hand_motion::HandMotion;
use super::initiation::{GraspChoice, GraspInitiation};
use super::observation::{n_observation, observe_into};
use super::perturbation::Perturbation;
use super::reward::Advance;
use super::rig::{Placing, Reading, Rig};
use super::setting::CipSetting;

/// Configurations tried for a grasp before it counts as one that cannot be taken.
const CONFIGURATIONS_TRIED: usize = 3;

/// Grasps tried before an episode cannot begin.
const GRASPS_TRIED: usize = 30;

/// Why an episode cannot be begun or gone on with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CipError<E: std::error::Error + 'static> {
    /// The rig.
    #[error(transparent)]
    Rig(E),
    /// The robot's kinematics.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The guide.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// No grasp can be taken where the object stands.
    #[error(
        "none of {n_tried} grasps can be taken with the object at ({x_m:.3}, {y_m:.3}, {z_m:.3}) m in the robot's base \
         frame: {n_unreachable} out of reach, {n_touching} with the arm in contact, {n_missed} closed on nothing; move \
         `placement` nearer, or check `grasp_region`"
    )]
    NoGrasp {
        /// Grasps tried.
        n_tried: usize,
        /// Those without a configuration.
        n_unreachable: usize,
        /// Those in which the arm touches something.
        n_touching: usize,
        /// Those in which the fingers met nothing.
        n_missed: usize,
        /// Where the object stands.
        x_m: f64,
        /// Where the object stands.
        y_m: f64,
        /// Where the object stands.
        z_m: f64,
    },
    /// A setting with a head needs grasps.
    #[error("the setting begins in a grasp, but there are no grasps")]
    NoInitiation,
}

/// What time is spent on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// Beginning an episode: inverse kinematics, placing, closing the fingers.
    Reset,
    /// Steps of the policy.
    Steps,
    /// Updates of the learner.
    Updates,
    /// Evaluation, with its own resets and steps.
    Evaluation,
}

/// Whoever wants to know when a phase begins, such as to take the time: nothing here reads a clock.
pub type PhaseWatch = Box<dyn FnMut(Phase) + Send>;

/// Whether an episode is one to learn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Grasps are explored, and what comes of them is kept.
    Learn,
    /// The best grasp is taken, and nothing is kept.
    Evaluate,
}

/// What came of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summary {
    /// Grasp that it began from.
    pub grasp: Option<usize>,
    /// Steps of the policy.
    pub n_steps: u32,
    /// Whether it ended in β_c.
    pub success: bool,
    /// Whether a joint came too near to its limit.
    pub violation: bool,
    /// What B said.
    pub failure: Option<FailureKind>,
    /// Largest contact force on a finger since the fingers began to close, N.
    pub peak_force_n: f64,
    /// Time that the policy took, seconds.
    pub secs: f64,
}

/// A rig with a task and a setting.
pub struct CipEnvironment<R> {
    rig: R,
    setting: CipSetting,
    placement: PlacementRange,
    success: SuccessIndicator,
    failure: FailureClassifier,
    initiation: Option<GraspInitiation>,
    motion: HandMotion,
    guide: Option<Guide>,
    /// The object's own motion, to be shown.
    planned: Guide,
    scene: PlanningScene,
    mode: Mode,
    perturbation: Perturbation,
    /// Of the episode: where the object is, from where it is believed to be.
    believed_from_true: Pose,
    memory: FailureMemory,
    best_progress: f64,
    opening: f64,
    summary: Summary,
    watch: Option<PhaseWatch>,
}

impl<R: std::fmt::Debug> std::fmt::Debug for CipEnvironment<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CipEnvironment")
            .field("rig", &self.rig)
            .field("setting", &self.setting)
            .finish_non_exhaustive()
    }
}

/// How a try to begin from a grasp ended.
enum Begun {
    Holding,
    Unreachable,
    Touching,
    Missed,
}

impl<R: Rig> CipEnvironment<R> {
    /// An environment; settings with a head need an `initiation` set before an episode can begin.
    ///
    /// # Errors
    /// [`CipError`] if setting and robot contradict each other.
    pub fn new(
        mut rig: R,
        task: &TaskSpec,
        setting: CipSetting,
        initiation: Option<GraspInitiation>,
    ) -> Result<Self, CipError<R::Error>> {
        rig.set_guard(setting.guard_spec()).map_err(CipError::Rig)?;
        let anatomy = rig.anatomy();
        let mut scene = PlanningScene::new(&anatomy.robot, &[], None)?;
        scene.set_gripper(1.0);
        let motion = HandMotion::of(&anatomy.object_joint, task);
        let guide = setting.guide_along(&motion, task)?;
        let planned = Guide::new(
            GuideParams::default(),
            motion.clone(),
            task.start,
            task.goal,
        )?;
        Ok(Self {
            placement: task.placement,
            success: SuccessIndicator::of(task),
            failure: setting.failure_classifier(task),
            rig,
            setting,
            initiation,
            motion,
            guide,
            planned,
            scene,
            mode: Mode::Learn,
            perturbation: Perturbation::default(),
            believed_from_true: Pose::identity(),
            memory: FailureMemory::default(),
            best_progress: 0.0,
            opening: 1.0,
            summary: Summary::default(),
            watch: None,
        })
    }

    /// The rig.
    pub fn rig(&self) -> &R {
        &self.rig
    }

    /// The rig, to look at it in another way.
    pub fn rig_mut(&mut self) -> &mut R {
        &mut self.rig
    }

    /// The setting.
    pub fn setting(&self) -> &CipSetting {
        &self.setting
    }

    /// Tells `watch` of every phase from now on.
    pub fn set_watch(&mut self, watch: PhaseWatch) {
        self.watch = Some(watch);
    }

    pub(crate) fn enter(&mut self, phase: Phase) {
        if let Some(watch) = &mut self.watch {
            watch(phase);
        }
    }

    /// β_c.
    pub fn success(&self) -> SuccessIndicator {
        self.success
    }

    /// Gives it I_c.
    pub fn set_initiation(&mut self, initiation: GraspInitiation) {
        self.initiation = Some(initiation);
    }

    /// I_c, if the setting has a head.
    pub fn initiation(&self) -> Option<&GraspInitiation> {
        self.initiation.as_ref()
    }

    /// The action that goes along with the object's own motion from here.
    pub fn planned_action(&self) -> [f32; N_ACTION] {
        self.planned.action(&self.believed(), &self.setting.ranges)
    }

    /// Whether the next episodes are to learn from.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
    }

    /// What is otherwise from the next episode on; the joint's resistance is the rig's.
    pub fn set_perturbation(&mut self, perturbation: Perturbation) {
        self.perturbation = perturbation;
    }

    /// What came of the last episode.
    pub fn summary(&self) -> Summary {
        self.summary
    }

    /// Begins an episode without a grasp, in the home posture.
    fn begin_at_home(&mut self, base_from_object: Pose) -> Result<(), CipError<R::Error>> {
        let placing = Placing {
            base_from_object: base_from_object * self.believed_from_true,
            object_joint: self.success.start,
            q: self.rig.anatomy().robot.q_ready(),
            opening: 1.0,
        };
        self.rig.place(&placing).map_err(CipError::Rig)?;
        Ok(())
    }

    /// Begins an episode in a grasp of the setting's choice, or in another if that cannot be taken.
    fn begin_in_grasp(
        &mut self,
        base_from_object: Pose,
        rng: &mut ChaCha8Rng,
    ) -> Result<(), CipError<R::Error>> {
        let (mut n_unreachable, mut n_touching, mut n_missed) = (0, 0, 0);
        let ranked = match (self.mode, self.setting.grasps, &self.initiation) {
            (Mode::Evaluate, GraspChoice::Ucb, Some(initiation)) => initiation.ranked(),
            _ => Vec::new(),
        };
        for attempt in 0..GRASPS_TRIED {
            let Some(initiation) = &self.initiation else {
                return Err(CipError::NoInitiation);
            };
            let grasp = if ranked.is_empty() {
                initiation.explore(self.setting.grasps, rng)
            } else {
                ranked[attempt % ranked.len()]
            };
            match self.take(grasp, &base_from_object, rng)? {
                Begun::Holding => {
                    self.summary.grasp = Some(grasp);
                    return Ok(());
                }
                Begun::Unreachable => n_unreachable += 1,
                Begun::Touching => n_touching += 1,
                Begun::Missed => n_missed += 1,
            }
            // A grasp that cannot be taken is no grasp to succeed from.
            self.record(grasp, false);
        }
        let at = base_from_object.translation;
        Err(CipError::NoGrasp {
            n_tried: GRASPS_TRIED,
            n_unreachable,
            n_touching,
            n_missed,
            x_m: at.x,
            y_m: at.y,
            z_m: at.z,
        })
    }

    /// Tries to hold the object in a grasp.
    fn take(
        &mut self,
        grasp: usize,
        base_from_object: &Pose,
        rng: &mut ChaCha8Rng,
    ) -> Result<Begun, CipError<R::Error>> {
        let Some(initiation) = &self.initiation else {
            return Err(CipError::NoInitiation);
        };
        let grasp_from_tcp = self.perturbation.grasp_from_tcp(rng);
        let base_from_tcp = base_from_object * initiation.object_from_tcp(grasp) * grasp_from_tcp;
        let width_m = initiation.width_m(grasp);
        self.take_pose(base_from_object, &base_from_tcp, width_m, rng)
    }

    fn take_pose(
        &mut self,
        base_from_object: &Pose,
        base_from_tcp: &Pose,
        width_m: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Begun, CipError<R::Error>> {
        let motion = self
            .success
            .tool_motion(&self.motion, base_from_object, base_from_tcp);
        let choice = self.setting.configuration;
        let found = configurations(&mut self.scene, &motion, choice, rng);
        let mut outcome = Begun::Unreachable;
        let aperture_max_m = self.rig.anatomy().aperture_max_m;
        let opening = opening_around(width_m, aperture_max_m);
        for q in found.into_iter().take(CONFIGURATIONS_TRIED) {
            let placing = Placing {
                base_from_object: base_from_object * self.believed_from_true,
                object_joint: self.success.start,
                q,
                opening,
            };
            if !self.rig.place(&placing).map_err(CipError::Rig)? {
                outcome = Begun::Touching;
                continue;
            }
            self.opening = opening;
            self.summary = Summary::default();
            for _ in 0..CLOSING_STEPS {
                let opening = (self.opening - CLOSING_STROKE).max(0.0);
                self.act_opening(&HOLD, Some(opening))?;
            }
            let reading = self.rig.reading();
            if reading.touching && !self.summary.violation {
                return Ok(Begun::Holding);
            }
            outcome = Begun::Missed;
        }
        Ok(outcome)
    }

    /// Whether a grasp can be held, and holds while a random policy jiggles the gripper (thesis 3.2.1). It is tried at a
    /// random place of the object.
    ///
    /// # Errors
    /// [`CipError`] of the rig.
    pub fn is_stable(
        &mut self,
        object_from_tcp: &Pose,
        width_m: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<bool, CipError<R::Error>> {
        /// Largest component of a random action, as the thesis' code has it.
        const JIGGLE: f32 = 0.15;
        let base_from_object = self.placement.at(rng.random());
        let base_from_tcp = base_from_object * object_from_tcp;
        let begun = self.take_pose(&base_from_object, &base_from_tcp, width_m, rng)?;
        if !matches!(begun, Begun::Holding) {
            return Ok(false);
        }
        for _ in 0..self.setting.jiggle_steps {
            let mut action = HOLD;
            action[..12].fill_with(|| rng.random_range(-JIGGLE..=JIGGLE));
            self.act(&action)?;
            if self.summary.violation {
                return Ok(false);
            }
        }
        Ok(self.rig.reading().touching)
    }

    /// Does an action for one control period.
    fn act(&mut self, action: &[f32; N_ACTION]) -> Result<(), CipError<R::Error>> {
        self.act_opening(action, None)
    }

    /// Does an action for one control period, with another opening of the gripper if one is given.
    fn act_opening(
        &mut self,
        action: &[f32; N_ACTION],
        opening: Option<f64>,
    ) -> Result<(), CipError<R::Error>> {
        let period_secs = 1.0 / self.rig.anatomy().episode.control_hz;
        let mut command = self.setting.ranges.command(
            action,
            &self.rig.reading().base_from_tcp,
            self.opening,
            period_secs,
        );
        command.opening = opening.unwrap_or(command.opening);
        self.opening = command.opening;
        self.rig.step(&command).map_err(CipError::Rig)?;
        let reading = self.rig.reading();
        self.summary.peak_force_n = self.summary.peak_force_n.max(reading.peak_force_n);
        self.summary.violation |= self.failure.is_violated(reading);
        Ok(())
    }

    /// What is felt, with the object where it is believed to be.
    fn believed(&self) -> Cow<'_, Reading> {
        let reading = self.rig.reading();
        if self.believed_from_true == Pose::identity() {
            return Cow::Borrowed(reading);
        }
        let base_from_object = reading.base_from_object * self.believed_from_true.inverse();
        let shift = base_from_object * reading.base_from_object.inverse();
        Cow::Owned(Reading {
            base_from_object,
            region: shift * reading.region,
            ..reading.clone()
        })
    }

    fn observe(&self, observation: &mut [f32]) {
        observe_into(&self.believed(), observation);
    }

    fn record(&mut self, grasp: usize, success: bool) {
        if self.mode == Mode::Learn
            && let Some(initiation) = &mut self.initiation
        {
            initiation.record(grasp, success);
        }
    }

    /// What a step earned: `before` and `after` are progress, 0 at the start and 1 at the goal.
    fn reward(&self, before: f64, after: f64, ending: Ending) -> f64 {
        /// Contact force above which it costs something, N.
        const GENTLE_N: f64 = 60.0;
        let over = self.rig.reading().peak_force_n / GENTLE_N - 1.0;
        let cost = self.setting.force_cost * over.clamp(0.0, 1.0) + self.setting.step_cost;
        let advance = Advance {
            before,
            after,
            best: self.best_progress,
            is_success: self.summary.success,
            ending,
        };
        let way = (self.success.goal - self.success.start).abs();
        let discount = self.setting.td3.discount;
        self.setting.reward.earned(&advance, discount, way) - cost
    }
}

impl<R: Rig> Environment for CipEnvironment<R> {
    type Error = CipError<R::Error>;

    fn n_observation(&self) -> usize {
        n_observation(self.rig.anatomy())
    }

    fn n_action(&self) -> usize {
        N_ACTION
    }

    fn reset_into(
        &mut self,
        rng: &mut ChaCha8Rng,
        observation: &mut [f32],
    ) -> Result<(), Self::Error> {
        if self.mode == Mode::Learn {
            self.enter(Phase::Reset);
        }
        self.memory = FailureMemory::default();
        self.best_progress = 0.0;
        self.summary = Summary::default();
        self.opening = 1.0;
        let base_from_object = self.placement.at(rng.random());
        let middle = self.initiation.as_ref().map(GraspInitiation::middle);
        self.believed_from_true = self
            .perturbation
            .believed_from_true(middle.unwrap_or_default(), rng);
        if self.setting.head {
            self.begin_in_grasp(base_from_object, rng)?;
        } else {
            self.begin_at_home(base_from_object)?;
        }
        self.observe(observation);
        if self.mode == Mode::Learn {
            self.enter(Phase::Steps);
        }
        Ok(())
    }

    fn step_into(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Step, Self::Error> {
        let before = self.success.progress(self.rig.reading());
        let mut whole = [0.0; N_ACTION];
        let n = action.len().min(N_ACTION);
        whole[..n].copy_from_slice(&action[..n]);
        if let Some(guide) = &self.guide {
            whole = guide.corrected(&self.believed(), &self.setting.ranges, action)?;
        }
        self.act(&whole)?;
        self.summary.n_steps += 1;
        self.summary.secs = f64::from(self.summary.n_steps) / self.rig.anatomy().episode.control_hz;
        let reading = self.rig.reading();
        let progress = self.success.progress(reading);
        self.summary.failure = self.failure.judge(&mut self.memory, reading, progress);
        self.summary.success = self.success.holds(reading) && !self.summary.violation;
        let ending = match self.summary.failure {
            _ if self.summary.success => Ending::Terminal,
            Some(FailureKind::TimeOut) => Ending::Cut,
            Some(_) => Ending::Terminal,
            None => Ending::Goes,
        };
        if self.summary.success {
            self.summary.failure = None;
        }
        self.observe(observation);
        let reward = self.reward(before, progress, ending) as f32;
        self.best_progress = self.best_progress.max(progress);
        if ending.is_over()
            && let Some(grasp) = self.summary.grasp
        {
            self.record(grasp, self.summary.success);
        }
        Ok(Step { reward, ending })
    }
}
