//! `factotum studio`: look at a stored home in the browser, and at skills while they are learned.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use factotum_agent::{Settings, ground_home};
use factotum_experiments::training_watch::TrainingWatch;
use factotum_geometry::Pose2;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_studio::{Studio, StudioConfig, StudioHandle};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;

use crate::belief::BeliefScene;
use crate::console::{Answer, Console, now};
use crate::home;
use crate::robot;
use crate::watch::StopFlag;
use crate::wire_view::{aosm_of, map_of};

/// How often the skill folders are looked at.
const LOOK: Duration = Duration::from_secs(1);

/// Arguments of `factotum studio`.
#[derive(Debug, Args)]
pub(crate) struct StudioArgs {
    /// The home folder to show.
    #[arg(long)]
    home: PathBuf,
    /// Robot whose places to stand are shown: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    robot: PathBuf,
    /// Folder with skill folders, as `factotum skill train` makes them: their learning curves are shown as they grow.
    #[arg(long, value_name = "DIR", default_value = "skills")]
    skills: PathBuf,
}

/// Runs `factotum studio`: shows map, objects and actions of a home, and what is learned, until Ctrl-C or the page's
/// Stop.
pub(crate) fn studio(args: &StudioArgs, console: &Console) -> anyhow::Result<Answer> {
    let (name, aosm) = home::read(&args.home)?;
    let stop = StopFlag::on_interrupt()?;
    let studio = Studio::start(StudioConfig::default())?;
    let world_from_map = Pose2::identity();
    let robot = robot::load(&args.robot)?;
    let graph = ground_home(
        &aosm,
        robot.description().footprint_radius_m(),
        &Settings::default(),
        &mut ChaCha8Rng::seed_from_u64(0),
    );
    studio.publish(ServerMessage::Status(wire::Status {
        goal: format!("look at {name}"),
        activity: wire::Activity::Finished,
        paused: false,
        takes_driving: false,
    }));
    studio.publish(ServerMessage::Map(map_of(&aosm, &world_from_map)?));
    studio.publish(ServerMessage::Aosm(aosm_of(&aosm, &graph, &world_from_map)));
    let belief = BeliefScene::new(aosm.classes.values());
    studio.publish(ServerMessage::Scene(belief.scene(&aosm, &world_from_map)));
    console.say(format_args!(
        "{name} at {} until Ctrl-C or its Stop",
        studio.url()
    ));
    let commands = studio.commands();
    let mut trainings = TrainingWatch::new(&args.skills);
    let mut looked: Option<Instant> = None;
    while !stop.is_raised() {
        if looked.is_none_or(|at| at.elapsed() >= LOOK) {
            looked = Some(Instant::now());
            show_trainings(&mut trainings, &studio);
        }
        if commands.next_within(Duration::from_millis(200)) == Some(wire::ClientMessage::Stop) {
            break;
        }
    }
    studio.shutdown();
    Ok(Answer::Yes)
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
