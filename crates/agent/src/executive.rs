//! The executive itself: a chore from goal to report.

use factotum_control::Robot;
use factotum_geometry::{Pose, Pose2};
use factotum_motion::RobotModel;
use factotum_semantic_map::{Aosm, ChoreGoal, MapError, TopologicalGraph};
use factotum_skills::cip::Primitive;
use factotum_task_planning::operator::{Condition, GroundAction};
use factotum_task_planning::planner::{Limits, PlanOutcome, Planner};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::senses::Senses;
use crate::viewed::Viewed;
use crate::{AgentError, LogLevel, Observer, RunReport, Settings, Stage, StepView};

/// Does chores with a robot, from what it believes of the home.
pub struct Executive<'a> {
    pub(crate) robot: &'a mut dyn Robot,
    pub(crate) model: RobotModel,
    pub(crate) aosm: Aosm,
    pub(crate) graph: TopologicalGraph,
    pub(crate) senses: Senses,
    /// What the camera has had in view.
    pub(crate) viewed: Viewed,
    /// Objects that nothing could be done at as they were known, and where the robot went to see them better.
    pub(crate) vantages: Vec<(String, Pose2)>,
    pub(crate) tcp_from_held: Option<Pose>,
    /// Skills that were learned, each used for the option that it does.
    pub(crate) learned: Vec<Primitive>,
    pub(crate) planner: &'a dyn Planner,
    pub(crate) observer: &'a mut dyn Observer,
    pub(crate) settings: Settings,
    pub(crate) rng: ChaCha8Rng,
    pub(crate) steps: Vec<StepView>,
    pub(crate) report: RunReport,
    pub(crate) stage: Stage,
    /// When the chore began, on the robot's clock.
    pub(crate) chore_began_secs: f64,
}

impl std::fmt::Debug for Executive<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Executive")
            .field("robot", &self.model.description().name)
            .field("n_objects", &self.aosm.objects.len())
            .finish_non_exhaustive()
    }
}

impl<'a> Executive<'a> {
    /// An executive for a robot that stands at `map_from_odom` times its odometry, with what is known of the home.
    ///
    /// # Errors
    /// [`AgentError::Motion`] if the robot's models cannot be loaded for planning.
    pub fn new(
        robot: &'a mut dyn Robot,
        aosm: Aosm,
        map_from_odom: Pose2,
        planner: &'a dyn Planner,
        observer: &'a mut dyn Observer,
        settings: Settings,
        seed: u64,
    ) -> Result<Self, AgentError> {
        let model = RobotModel::load(robot.description())?;
        let odom_from_base = robot.state()?.odom_from_base;
        let map = (aosm.grid.count_states()[0] > 0).then_some(&aosm.grid);
        let senses = Senses::new(
            aosm.classes.values(),
            map_from_odom,
            &odom_from_base,
            map,
            &aosm.cloud,
        )?;
        Ok(Self {
            robot,
            model,
            aosm,
            graph: TopologicalGraph::default(),
            senses,
            viewed: Viewed::default(),
            vantages: Vec::new(),
            tcp_from_held: None,
            learned: Vec::new(),
            planner,
            observer,
            settings,
            rng: ChaCha8Rng::seed_from_u64(seed),
            steps: Vec::new(),
            report: RunReport::default(),
            stage: Stage::Between,
            chore_began_secs: 0.0,
        })
    }

    /// What the robot believes of the home.
    pub fn aosm(&self) -> &Aosm {
        &self.aosm
    }

    /// Ends the executive and hands back what it believes.
    pub fn into_aosm(self) -> Aosm {
        Aosm {
            cloud: self.senses.seen(),
            ..self.aosm
        }
    }

    /// The chore under way, as far as it has got; none between chores.
    pub fn under_way(&self) -> Option<&RunReport> {
        (self.stage != Stage::Between).then_some(&self.report)
    }

    /// The topological graph as last grounded.
    pub fn graph(&self) -> &TopologicalGraph {
        &self.graph
    }

    /// Plans and does a chore, or goes on with the one under way. That it cannot be done is part of the report, not an error.
    ///
    /// # Errors
    /// [`AgentError`] for faults of the robot, the planner or the map, and [`AgentError::Stopped`] when the observer
    /// wished to stop.
    pub fn do_chore(&mut self, goal: &ChoreGoal) -> Result<RunReport, AgentError> {
        if self.stage == Stage::Between {
            self.report = RunReport::default();
            self.stage = Stage::Planning;
            self.vantages.clear();
        }
        self.chore_began_secs = self.robot.state()?.time_secs - self.report.robot_secs;
        let reason = self.pursue(goal)?;
        self.stage = Stage::Between;
        self.report.is_believed_done = reason.is_none();
        if let Some(reason) = &reason {
            self.log(LogLevel::Error, reason.clone())?;
        }
        self.report.reason = reason;
        self.report.robot_secs = self.robot.state()?.time_secs - self.chore_began_secs;
        Ok(self.report.clone())
    }

    /// Plans and acts until the goal is believed to hold; returns why not otherwise.
    fn pursue(&mut self, goal: &ChoreGoal) -> Result<Option<String>, AgentError> {
        if self.stage == Stage::Planning {
            self.tuck()?;
        }
        // A chore that goes on has its plan, or has had one.
        let is_anew = self.stage == Stage::Planning && !self.report.plan.is_empty();
        for n_plans in self.report.n_replans + usize::from(is_anew)..=self.settings.n_replans_max {
            let n_done = match self.stage {
                Stage::Acting { n_steps_done } => n_steps_done,
                Stage::Between | Stage::Planning => {
                    self.report.plan = match self.make_plan(goal)? {
                        Ok(steps) => steps,
                        Err(reason) => return Ok(Some(reason)),
                    };
                    0
                }
            };
            self.report.n_replans = n_plans;
            self.ground_graph()?;
            if self.report.plan.is_empty() {
                return Ok(None);
            }
            match self.execute(n_done)? {
                None => return Ok(None),
                Some(reason) if n_plans == self.settings.n_replans_max => return Ok(Some(reason)),
                Some(reason) => self.log(LogLevel::Warning, format!("planning anew: {reason}"))?,
            }
        }
        Ok(Some("the plan was made anew too often".to_owned()))
    }

    /// The steps of manipulation that lead from what is believed to the goal, or why there are none.
    fn make_plan(
        &mut self,
        goal: &ChoreGoal,
    ) -> Result<Result<Vec<GroundAction>, String>, AgentError> {
        let Some(condition) = self.find_what_it_takes(goal)? else {
            let missing = goal.condition(&self.aosm).err();
            return Ok(Err(
                missing.map_or_else(String::new, |error| error.to_string())
            ));
        };
        let domain = self.aosm.domain()?;
        let problem = self.aosm.problem(&domain, condition)?;
        Ok(
            match self.planner.solve(&domain, &problem, &Limits::default())? {
                PlanOutcome::Solved { plan, .. } => Ok(plan.steps),
                PlanOutcome::Unsolvable { reason } => Err(format!("no plan exists: {reason}")),
                PlanOutcome::Exhausted { reason } => Err(format!("no plan was found: {reason}")),
                PlanOutcome::LimitReached { limit } => {
                    Err(format!("planning reached its {limit:?} limit").to_lowercase())
                }
            },
        )
    }

    /// The goal over known objects; explores while one of its classes has not been found.
    fn find_what_it_takes(&mut self, goal: &ChoreGoal) -> Result<Option<Condition>, AgentError> {
        if let Err(MapError::NothingOfClass { class, .. }) = goal.condition(&self.aosm) {
            self.log(LogLevel::Info, format!("looking for a {class}"))?;
            self.viewed.clear();
            let wanted = goal.clone();
            self.explore(&mut |aosm| wanted.condition(aosm).is_ok())?;
        }
        match goal.condition(&self.aosm) {
            Ok(condition) => Ok(Some(condition)),
            Err(MapError::NothingOfClass { .. } | MapError::NotOfClass { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Executes the plan's steps after the first `n_done`; returns why it is no longer worth following, if so.
    fn execute(&mut self, n_done: usize) -> Result<Option<String>, AgentError> {
        let plan = self.report.plan.clone();
        self.show_plan(&plan, n_done)?;
        for (index, step) in plan.iter().enumerate().skip(n_done) {
            let outcome = self.perform(2 * index, step)?;
            self.stage = match outcome {
                Ok(()) => Stage::Acting {
                    n_steps_done: index + 1,
                },
                Err(_) => Stage::Planning,
            };
            self.checkpoint()?;
            if let Err(reason) = outcome {
                self.mark_rest_skipped(2 * index + 1)?;
                return Ok(Some(reason));
            }
        }
        Ok(None)
    }
}
