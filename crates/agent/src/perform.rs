//! One step of a plan: drive to where it can be done, look, act, and try again from elsewhere.

use factotum_geometry::{Pose, Pose2};
use factotum_semantic_map::{MapError, OptionKind, OptionSpec};
use factotum_task_planning::operator::GroundAction;

use crate::learned::Chosen;
use crate::navigate::BaseChoice;
use crate::{AgentError, Executive, StepState};

/// What the tries of a step have shown so far.
#[derive(Debug, Default)]
struct Tries {
    /// Which try this is, from 1.
    n: usize,
    /// Where the robot stood or wished to stand.
    spent: Vec<Pose2>,
    /// Where what is sought was believed to be before the robot set off to it.
    believed_at: Option<Pose>,
}

/// How a try ended.
enum Ended {
    Done,
    /// From another place it may work.
    Again(String),
    /// The plan is no longer worth following.
    GivenUp(String),
}

impl Executive<'_> {
    /// One step of the plan, from as many base poses as the settings allow; the answer is why it was not done, if so.
    ///
    /// `view` is the place of its drive among the steps shown; the step itself follows.
    pub(crate) fn perform(
        &mut self,
        view: usize,
        step: &GroundAction,
    ) -> Result<Result<(), String>, AgentError> {
        let mut tries = Tries::default();
        let mut reason = String::new();
        while tries.n < self.settings.n_attempts_max {
            tries.n += 1;
            match self.try_step(view, step, &mut tries)? {
                Ended::Done => return Ok(Ok(())),
                Ended::Again(why) => reason = why,
                Ended::GivenUp(why) => return Ok(Err(why)),
            }
        }
        Ok(Err(reason))
    }

    fn try_step(
        &mut self,
        view: usize,
        step: &GroundAction,
        tries: &mut Tries,
    ) -> Result<Ended, AgentError> {
        let option = match self.aosm.option(step) {
            Ok(option) => option,
            Err(MapError::NoObject { name, .. }) => return Ok(Ended::GivenUp(is_gone(&name))),
            Err(error) => return Err(error.into()),
        };
        let sought = sought_by(&option);
        let known_at = self.aosm.object(sought)?.map_from_object;
        let known_at = *tries.believed_at.get_or_insert(known_at);
        self.mark(view, StepState::Running, None)?;
        let (map_from_base, in_the_way) = match self.choose_base(&option, &tries.spent)? {
            BaseChoice::Possible(pose) => (pose, None),
            // What was seen from afar may be wrong: a look from near, once, before giving up.
            BaseChoice::None {
                nearest: Some(pose),
                reason,
            } if tries.spent.is_empty() => (pose, Some(reason)),
            BaseChoice::None { reason, .. } => {
                self.mark(view, StepState::Failed, Some(reason.clone()))?;
                return Ok(Ended::GivenUp(reason));
            }
        };
        tries.spent.push(map_from_base);
        if in_the_way.is_some() {
            self.vantages.push((sought.to_owned(), map_from_base));
        }
        if let Err(why) = self.go_to(&map_from_base, sought, view, tries.n)? {
            let lost = match option.kind {
                OptionKind::Place { .. } => self.check_grip(&option.object)?.err(),
                OptionKind::Pick | OptionKind::Articulate { .. } => None,
            };
            return Ok(lost.map_or(Ended::Again(why), Ended::GivenUp));
        }
        if let Err(changed) = self.look_again_for(sought, &known_at, tries.n)? {
            tries.believed_at = None;
            if !self.aosm.objects.contains_key(sought) {
                return Ok(Ended::GivenUp(changed));
            }
        }
        if let Some(reason) = in_the_way {
            return Ok(Ended::Again(reason));
        }
        self.mark(view + 1, StepState::Running, None)?;
        let Chosen { skill, learned } = self.choose_skill(&option)?;
        let (outcome, robot_secs) = self.timed(|this| this.act(&option, skill.as_ref()))?;
        self.show_map()?;
        self.record(&step.name, &step.args, &outcome, tries.n, robot_secs);
        if let Some(record) = self.report.executed.last_mut() {
            record.learned = learned;
        }
        let Err(why) = outcome else {
            self.mark(view + 1, StepState::Done, None)?;
            return Ok(Ended::Done);
        };
        self.mark(view + 1, StepState::Failed, Some(why.clone()))?;
        self.tuck()?;
        Ok(if self.is_still_applicable(&option) {
            Ended::Again(why)
        } else {
            Ended::GivenUp(why)
        })
    }

    /// Drives to where an object can be acted on; the answer is why it is not there, if so.
    fn go_to(
        &mut self,
        map_from_base: &Pose2,
        object: &str,
        view: usize,
        attempt: usize,
    ) -> Result<Result<(), String>, AgentError> {
        let (outcome, robot_secs) = self.timed(|this| this.drive_to(map_from_base))?;
        self.record(
            "navigate",
            &[object.to_owned()],
            &outcome,
            attempt,
            robot_secs,
        );
        match &outcome {
            Ok(()) => self.mark(view, StepState::Done, None)?,
            Err(why) => self.mark(view, StepState::Failed, Some(why.clone()))?,
        }
        Ok(outcome)
    }

    /// Looks closely at what is to be acted on; the answer is what about it is not as it was known, if something is not.
    fn look_again_for(
        &mut self,
        object: &str,
        known_at: &Pose,
        attempt: usize,
    ) -> Result<Result<(), String>, AgentError> {
        let (found, robot_secs) = self.timed(|this| this.look_for(object, known_at))?;
        if found.is_err() {
            self.record("look", &[object.to_owned()], &found, attempt, robot_secs);
        }
        Ok(found)
    }

    /// Whether what the option needs still holds after a failed try: a dropped object must be picked again first.
    fn is_still_applicable(&self, option: &OptionSpec) -> bool {
        let is_held = self
            .aosm
            .held()
            .is_some_and(|held| held.name == option.object);
        match option.kind {
            OptionKind::Place { .. } => is_held,
            OptionKind::Pick | OptionKind::Articulate { .. } => self.aosm.held().is_none(),
        }
    }
}

/// The object that the robot must be at for an option.
pub(crate) fn sought_by(option: &OptionSpec) -> &str {
    match &option.kind {
        OptionKind::Place { target, .. } => target,
        OptionKind::Pick | OptionKind::Articulate { .. } => &option.object,
    }
}

/// What is said of an object that is not where it was believed to be.
pub(crate) fn is_gone(name: &str) -> String {
    format!("`{name}` is no longer where it was")
}
