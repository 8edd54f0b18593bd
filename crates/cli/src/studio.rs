//! `factotum studio`: look at a stored home in the browser.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use factotum_agent::{Settings, ground_home};
use factotum_geometry::Pose2;
use factotum_protocol::{self as wire, ServerMessage};
use factotum_studio::{Studio, StudioConfig};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;

use crate::belief::BeliefScene;
use crate::console::{Answer, Console};
use crate::home;
use crate::robot;
use crate::watch::StopFlag;
use crate::wire_view::{aosm_of, map_of};

/// Arguments of `factotum studio`.
#[derive(Debug, Args)]
pub(crate) struct StudioArgs {
    /// The home folder to show.
    #[arg(long)]
    home: PathBuf,
    /// Robot whose places to stand are shown: a folder with `robot.toml`, or the name of a shipped one.
    #[arg(long, default_value = "movo")]
    robot: PathBuf,
}

/// Runs `factotum studio`: shows map, objects and actions of a home until Ctrl-C or the page's Stop.
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
    while !stop.is_raised() {
        if commands.next_within(Duration::from_millis(200)) == Some(wire::ClientMessage::Stop) {
            break;
        }
    }
    studio.shutdown();
    Ok(Answer::Yes)
}
