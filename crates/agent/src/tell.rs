//! Telling the observer, and doing what it wishes.

use crate::{
    AgentError, Event, ExecutedStep, Executive, LogLevel, StepKind, StepState, StepView, Wish,
};
use factotum_task_planning::operator::GroundAction;

impl Executive<'_> {
    pub(crate) fn log(&mut self, level: LogLevel, text: String) -> Result<(), AgentError> {
        let time_secs = self.robot.state()?.time_secs;
        let wish = self.observer.observe(&Event::Log {
            time_secs,
            level,
            text,
        });
        self.heed(wish)
    }

    pub(crate) fn show_map(&mut self) -> Result<(), AgentError> {
        let map_from_base = self.map_from_base()?;
        let wish = self.observer.observe(&Event::Map {
            aosm: &self.aosm,
            graph: &self.graph,
            map_from_base,
        });
        self.heed(wish)
    }

    /// Shows a plan of which the first `n_done` steps are done: before each manipulation stands the drive to it, two views
    /// a step.
    pub(crate) fn show_plan(
        &mut self,
        plan: &[GroundAction],
        n_done: usize,
    ) -> Result<(), AgentError> {
        let view = |action: &str, args: &[String], kind| StepView {
            action: action.to_owned(),
            args: args.to_vec(),
            kind,
            state: StepState::Pending,
            attempts: 0,
            reason: None,
        };
        self.steps = plan
            .iter()
            .flat_map(|step| {
                let place = step
                    .args
                    .last()
                    .map(std::slice::from_ref)
                    .unwrap_or_default();
                [
                    view("navigate", place, StepKind::Navigate),
                    view(&step.name, &step.args, StepKind::Manipulate),
                ]
            })
            .collect();
        for step in self.steps.iter_mut().take(2 * n_done) {
            step.state = StepState::Done;
        }
        self.show_steps()
    }

    pub(crate) fn mark(
        &mut self,
        index: usize,
        state: StepState,
        reason: Option<String>,
    ) -> Result<(), AgentError> {
        if let Some(step) = self.steps.get_mut(index) {
            step.attempts += usize::from(state == StepState::Running);
            step.state = state;
            step.reason = reason;
        }
        self.show_steps()
    }

    pub(crate) fn mark_rest_skipped(&mut self, from: usize) -> Result<(), AgentError> {
        for step in self
            .steps
            .iter_mut()
            .skip(from)
            .filter(|step| step.state == StepState::Pending)
        {
            step.state = StepState::Skipped;
        }
        self.show_steps()
    }

    fn show_steps(&mut self) -> Result<(), AgentError> {
        let wish = self.observer.observe(&Event::Plan { steps: &self.steps });
        self.heed(wish)
    }

    pub(crate) fn heed(&mut self, wish: Wish) -> Result<(), AgentError> {
        match wish {
            Wish::GoOn => Ok(()),
            Wish::Stop => {
                self.robot.stop()?;
                Err(AgentError::Stopped)
            }
        }
    }

    /// Runs something and tells how long it took on the robot's clock, seconds.
    pub(crate) fn timed<T>(
        &mut self,
        run: impl FnOnce(&mut Self) -> Result<T, AgentError>,
    ) -> Result<(T, f64), AgentError> {
        let started_secs = self.robot.state()?.time_secs;
        let result = run(self)?;
        Ok((result, self.robot.state()?.time_secs - started_secs))
    }

    pub(crate) fn record(
        &mut self,
        action: &str,
        args: &[String],
        outcome: &Result<(), String>,
        attempts: usize,
        robot_secs: f64,
    ) {
        self.report.executed.push(ExecutedStep {
            action: action.to_owned(),
            args: args.to_vec(),
            learned: None,
            outcome: outcome
                .as_ref()
                .err()
                .cloned()
                .unwrap_or_else(|| "done".to_owned()),
            is_done: outcome.is_ok(),
            attempts,
            robot_secs,
        });
    }
}
