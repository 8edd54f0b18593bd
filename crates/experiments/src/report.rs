//! The report of a run: one HTML page that needs nothing beside it, to read on a phone, print or send on.
//!
//! It shows the judge's word, the map with objects, navigation regions and the way driven, the plan and what came of
//! each step with reasons, where the time went, and what happened. Texts are escaped; there is no script.

mod html;
mod map_drawing;

use factotum_protocol::{Aosm, Event, EventLevel, OccupancyMap, Plan, StepState};

use html::Markup;
pub(crate) use html::escape;

/// What a report tells. Whatever is empty is left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// What the run was for, such as the goal in words.
    pub title: String,
    /// What the judge said.
    pub verdict: Verdict,
    /// What was done, and why not when it was not: a sentence or two.
    pub summary: String,
    /// What was run: scene, seed, command, version.
    pub facts: Vec<Fact>,
    /// The occupancy grid.
    pub map: Option<OccupancyMap>,
    /// Objects and navigation regions.
    pub aosm: Aosm,
    /// Where the base was, in the map's frame, metres, in the order of time.
    pub way_driven: Vec<[f64; 2]>,
    /// The last plan.
    pub plan: Plan,
    /// Everything that was executed, in order, failed tries included.
    pub executed: Vec<ExecutedStep>,
    /// Where the time went.
    pub timings: Vec<Timing>,
    /// Figures of the run: sizes, distances, memory.
    pub figures: Vec<Fact>,
    /// What happened.
    pub events: Vec<Event>,
}

/// What the judge said of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Verdict {
    /// The goal is achieved.
    Achieved,
    /// It is not.
    NotAchieved,
    /// Nobody judged, or the run was stopped before.
    #[default]
    Unjudged,
}

/// A name and what it stands for, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Its name.
    pub name: String,
    /// Its value, with the unit.
    pub value: String,
}

impl Fact {
    /// A fact from name and value.
    #[must_use]
    pub fn new(name: &str, value: impl ToString) -> Self {
        Self {
            name: name.to_owned(),
            value: value.to_string(),
        }
    }
}

/// A step that was executed.
#[derive(Debug, Clone, PartialEq)]
pub struct ExecutedStep {
    /// Name of the action.
    pub action: String,
    /// What it was done with.
    pub args: Vec<String>,
    /// Whether it was done.
    pub is_done: bool,
    /// Why it failed, or how it went; may be empty.
    pub reason: String,
    /// Tries of this step so far, this one included.
    pub attempts: u32,
    /// Robot time it took, seconds.
    pub robot_secs: f64,
}

/// A span of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// What it was spent on.
    pub name: String,
    /// How long it took, seconds.
    pub secs: f64,
}

const STYLE: &str = include_str!("report/style.css");

impl Report {
    /// The page.
    ///
    /// # Errors
    /// [`factotum_protocol::MapError`] when the map's runs do not fill it.
    pub fn to_html(&self) -> Result<String, factotum_protocol::MapError> {
        let map = self
            .map
            .as_ref()
            .map(|map| map_drawing::draw(map, &self.aosm, &self.way_driven))
            .transpose()?;
        let mut page = Markup::new();
        page.raw("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
        page.raw("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
        page.raw(&format!(
            "<title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n",
            escape(&self.title)
        ));
        self.heading(&mut page);
        if let Some(map) = map {
            page.section("Map", |page| page.raw(&map));
        }
        self.plan_table(&mut page);
        self.executed_table(&mut page);
        self.timing_table(&mut page);
        facts_table(&mut page, "Figures", &self.figures);
        self.event_list(&mut page);
        facts_table(&mut page, "Run", &self.facts);
        page.raw("</body>\n</html>\n");
        Ok(page.into_string())
    }

    fn heading(&self, page: &mut Markup) {
        let (class, words) = match self.verdict {
            Verdict::Achieved => ("achieved", "achieved"),
            Verdict::NotAchieved => ("failed", "not achieved"),
            Verdict::Unjudged => ("unjudged", "not judged"),
        };
        page.raw("<header>\n");
        page.element("h1", &self.title);
        page.raw(&format!("<p class=\"verdict {class}\">{words}</p>\n"));
        if !self.summary.is_empty() {
            page.element("p", &self.summary);
        }
        page.raw("</header>\n");
    }

    fn plan_table(&self, page: &mut Markup) {
        if self.plan.steps.is_empty() {
            return;
        }
        page.section("Plan", |page| {
            match self.plan.replans {
                0 => {}
                1 => page.element("p", "Planned anew once; this is the last plan."),
                n => page.element(
                    "p",
                    &format!("Planned anew {n} times; this is the last plan."),
                ),
            }
            page.table(&["", "Step", "State", "Tries", "Why"], |page| {
                for step in &self.plan.steps {
                    let (class, state) = state_words(step.state);
                    page.row(&[
                        ("number", &(step.index + 1).to_string()),
                        ("step", &step_words(&step.action, &step.args)),
                        (class, state),
                        ("number", &step.attempts.to_string()),
                        ("why", &step.reason),
                    ]);
                }
            });
        });
    }

    fn executed_table(&self, page: &mut Markup) {
        if self.executed.is_empty() {
            return;
        }
        page.section("Executed", |page| {
            page.table(&["", "Step", "Outcome", "Try", "Time", "Why"], |page| {
                for (number, step) in (1..).zip(&self.executed) {
                    let number: u32 = number;
                    let (class, outcome) = if step.is_done {
                        ("achieved", "done")
                    } else {
                        ("failed", "failed")
                    };
                    page.row(&[
                        ("number", &number.to_string()),
                        ("step", &step_words(&step.action, &step.args)),
                        (class, outcome),
                        ("number", &step.attempts.to_string()),
                        ("number", &secs_words(step.robot_secs)),
                        ("why", &step.reason),
                    ]);
                }
            });
        });
    }

    fn timing_table(&self, page: &mut Markup) {
        let longest = self
            .timings
            .iter()
            .map(|timing| timing.secs)
            .fold(0.0, f64::max);
        if longest <= 0.0 {
            return;
        }
        page.section("Timings", |page| {
            page.raw("<table class=\"timings\">\n<tbody>\n");
            for timing in &self.timings {
                let percent = 100.0 * (timing.secs / longest).clamp(0.0, 1.0);
                page.raw(&format!(
                    "<tr><th>{}</th><td class=\"number\">{}</td><td class=\"bar\"><span style=\"width:{percent:.1}%\"></span></td></tr>\n",
                    escape(&timing.name),
                    secs_words(timing.secs),
                ));
            }
            page.raw("</tbody>\n</table>\n");
        });
    }

    fn event_list(&self, page: &mut Markup) {
        if self.events.is_empty() {
            return;
        }
        page.section("What happened", |page| {
            page.raw("<ol class=\"events\">\n");
            for event in &self.events {
                let class = match event.level {
                    EventLevel::Info => "info",
                    EventLevel::Warning => "warning",
                    EventLevel::Error => "failed",
                };
                let (time, text) = (secs_words(event.time_secs), escape(&event.text));
                page.raw(&format!(
                    "<li class=\"{class}\"><time>{time}</time> {text}</li>\n"
                ));
            }
            page.raw("</ol>\n");
        });
    }
}

fn facts_table(page: &mut Markup, title: &str, facts: &[Fact]) {
    if facts.is_empty() {
        return;
    }
    page.section(title, |page| {
        page.raw("<table class=\"facts\">\n<tbody>\n");
        for fact in facts {
            page.raw(&format!(
                "<tr><th>{}</th><td>{}</td></tr>\n",
                escape(&fact.name),
                escape(&fact.value)
            ));
        }
        page.raw("</tbody>\n</table>\n");
    });
}

fn state_words(state: StepState) -> (&'static str, &'static str) {
    match state {
        StepState::Pending => ("pending", "not begun"),
        StepState::Running => ("running", "under way"),
        StepState::Done => ("achieved", "done"),
        StepState::Failed => ("failed", "failed"),
        StepState::Skipped => ("pending", "skipped"),
    }
}

/// `pick bottle table`, as in the plan.
fn step_words(action: &str, args: &[String]) -> String {
    std::iter::once(action)
        .chain(args.iter().map(String::as_str))
        .collect::<Vec<_>>()
        .join(" ")
}

fn secs_words(secs: f64) -> String {
    format!("{secs:.1} s")
}

#[cfg(test)]
mod tests;
