//! `factotum studio`: look at a stored home in the browser and teach it, and see skills while they are learned.

mod lan;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use factotum_agent::{Settings, ground_home};
use factotum_experiments::training_watch::TrainingWatch;
use factotum_geometry::Pose2;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_semantic_map::{MapError, TopologicalGraph};
use factotum_studio::{Commands, Studio, StudioConfig, StudioHandle};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;

use crate::console::{Answer, Console, now};
use crate::robot;
use crate::studio::lan::{ServeArgs, show_new_links};
use crate::teach::Desk;
use crate::watch::StopFlag;
use crate::wire_view::{aosm_of, map_of};

/// Name of the log of who did what, in the home folder.
const AUDIT_NAME: &str = "audit.jsonl";
/// How often the skill folders are looked at.
const LOOK: Duration = Duration::from_secs(1);
/// Longest wait for an edit before Ctrl-C is looked for.
const WAIT: Duration = Duration::from_millis(100);
/// Where the robot can stand is found when nobody has edited for so long: it takes longer than an edit.
const QUIET: Duration = Duration::from_millis(400);

/// Arguments of `factotum studio`.
#[derive(Debug, Args)]
pub(crate) struct StudioArgs {
    /// The home folder to show and to teach.
    #[arg(long)]
    home: PathBuf,
    /// Robot whose places to stand are shown: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    robot: PathBuf,
    /// Folder with skill folders, as `factotum skill train` makes them: their learning curves are shown as they grow.
    #[arg(long, value_name = "DIR", default_value = "skills")]
    skills: PathBuf,
    #[command(flatten)]
    serve: ServeArgs,
}

/// Runs `factotum studio`: shows map, objects and actions of a home, takes what a person teaches of them, and shows what
/// is learned, until Ctrl-C.
pub(crate) fn studio(args: &StudioArgs, console: &Console) -> anyhow::Result<Answer> {
    let robot = robot::load(&args.robot)?;
    let robot = robot.description();
    let aperture_max_m = robot
        .gripper
        .as_ref()
        .map_or(0.0, |grip| grip.aperture_max_m);
    let desk = Desk::open(&args.home, aperture_max_m, unix_secs())?;
    let stop = StopFlag::on_interrupt()?;
    let studio = Studio::start(StudioConfig {
        takes_edits: true,
        audit: Some(args.home.join(AUDIT_NAME)),
        ..args.serve.config()?
    })?;
    let name = desk.name().to_owned();
    studio.publish(ServerMessage::Status(wire::Status {
        goal: format!("look at {name}"),
        activity: wire::Activity::Finished,
        paused: false,
        takes_driving: false,
    }));
    studio.publish(ServerMessage::Map(map_of(desk.aosm(), &Pose2::identity())?));
    let mut shown = ShownHome {
        desk,
        studio: &studio,
        graph: TopologicalGraph::default(),
        footprint_radius_m: robot.footprint_radius_m(),
    };
    shown.ground();
    shown.show()?;
    if let Some(why) = shown.desk.closed() {
        console.say(format_args!("{name} can only be looked at: {why}"));
    }
    console.say(format_args!("{name} at {} until Ctrl-C", studio.url()));
    show_new_links(&studio, console);
    let (commands, edits) = (studio.commands(), studio.edits());
    let mut trainings = TrainingWatch::new(&args.skills);
    let mut looked: Option<Instant> = None;
    let mut edited: Option<Instant> = None;
    while !stop.is_raised() {
        if looked.is_none_or(|at| at.elapsed() >= LOOK) {
            looked = Some(Instant::now());
            show_trainings(&mut trainings, &studio);
        }
        tell_that_no_robot_is_here(&commands, &studio);
        show_new_links(&studio, console);
        if let Some(asked) = edits.next_within(WAIT) {
            let outcome = shown.desk.answer(asked.request(), unix_secs());
            if let wire::EditOutcome::Accepted { entry: Some(_), .. } = &outcome {
                shown.show()?;
                edited = Some(Instant::now());
            }
            asked.answer(outcome);
        } else if edited.is_some_and(|at| at.elapsed() >= QUIET) {
            edited = None;
            shown.ground();
            shown.show_map();
        }
    }
    studio.shutdown();
    Ok(Answer::Yes)
}

/// Commands are for a robot: of whatever role, nobody ends with them what others are teaching.
fn tell_that_no_robot_is_here(commands: &Commands, studio: &StudioHandle) {
    while commands.try_next().is_some() {
        studio.publish(ServerMessage::Event(wire::Event {
            level: wire::EventLevel::Warning,
            text: "no robot is at work here; the studio ends with Ctrl-C where it was started"
                .to_owned(),
            time_secs: 0.0,
        }));
    }
}

/// A home that is edited while pages show it. Its map is the world of the pages.
struct ShownHome<'s> {
    desk: Desk,
    studio: &'s StudioHandle,
    /// Where the robot can stand, as found last.
    graph: TopologicalGraph,
    footprint_radius_m: f64,
}

impl ShownHome<'_> {
    /// Finds where the robot can stand for the actions that there are now.
    fn ground(&mut self) {
        self.graph = ground_home(
            self.desk.aosm(),
            self.footprint_radius_m,
            &Settings::default(),
            &mut ChaCha8Rng::seed_from_u64(0),
        );
    }

    /// Shows all that an edit can change.
    fn show(&mut self) -> Result<(), MapError> {
        let belief = self.desk.belief();
        let scene = belief.scene(self.desk.aosm(), &Pose2::identity());
        self.studio.publish(ServerMessage::Scene(scene));
        self.show_map();
        let teaching = self.desk.teaching()?;
        self.studio.publish(ServerMessage::Teaching(teaching));
        Ok(())
    }

    fn show_map(&self) {
        // What was found for an object or an action that is gone is not shown.
        let aosm = self.desk.aosm();
        let graph = self
            .graph
            .filtered(|node| aosm.option(&node.option).is_ok());
        let aosm = aosm_of(aosm, &graph, &Pose2::identity());
        self.studio.publish(ServerMessage::Aosm(aosm));
    }
}

fn unix_secs() -> f64 {
    now().unix_secs() as f64
}

/// Tells the page what is new of the trainings, and of a folder that cannot be read.
fn show_trainings(watch: &mut TrainingWatch, studio: &StudioHandle) {
    let look = watch.look(now());
    for trouble in look.troubles {
        studio.publish(ServerMessage::Event(wire::Event {
            level: wire::EventLevel::Warning,
            text: format!("{:#}", anyhow::Error::from(trouble)),
            time_secs: 0.0,
        }));
    }
    if let Some(trainings) = look.changed {
        studio.publish(ServerMessage::Trainings(trainings));
    }
}
