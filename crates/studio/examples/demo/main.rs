//! A job for the page to show, without any physics: a drawn home, a robot on rails, and a story
//! with exploration, a plan, a grasp that slips and three chores.
//!
//! `cargo run -p factotum-studio --example demo -- [--port P] [--speed X] [--start SECS] [--drive SECS]`
//!
//! Prints the address to open. `--start` tells the story up to then at once, for a screenshot. `--drive` lets the story
//! wait from then on for a person who drives.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program for developers"
)]

mod home;
mod robot;
mod story;

use std::net::{Ipv4Addr, SocketAddr};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use factotum_protocol::ClientMessage;
use factotum_studio::{Studio, StudioConfig};

use crate::story::Story;

const FRAME: Duration = Duration::from_millis(16);

fn main() -> ExitCode {
    match Options::parse(std::env::args().skip(1)).and_then(run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::from(2)
        }
    }
}

struct Options {
    port: u16,
    speed: f64,
    start_secs: f64,
    drive_secs: f64,
}

impl Options {
    fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut options = Self {
            port: 0,
            speed: 2.0,
            start_secs: 0.0,
            drive_secs: f64::INFINITY,
        };
        while let Some(name) = arguments.next() {
            let value = arguments.next().unwrap_or_default();
            let known = match name.as_str() {
                "--port" => value.parse().map(|port| options.port = port).is_ok(),
                "--speed" => value.parse().map(|speed| options.speed = speed).is_ok(),
                "--start" => value.parse().map(|secs| options.start_secs = secs).is_ok(),
                "--drive" => value.parse().map(|secs| options.drive_secs = secs).is_ok(),
                _ => false,
            };
            if !known {
                return Err(format!(
                    "unknown argument `{name} {value}`; there are --port P, --speed X, --start SECS, --drive SECS"
                ));
            }
        }
        Ok(options)
    }
}

fn run(mut options: Options) -> Result<(), String> {
    let studio = Studio::start(StudioConfig {
        bind: SocketAddr::from((Ipv4Addr::LOCALHOST, options.port)),
        ..StudioConfig::default()
    })
    .map_err(|error| error.to_string())?;
    let commands = studio.commands();
    let mut story = Story::begin(&studio);
    while story.time_secs() < options.start_secs && !story.is_over() {
        story.advance(FRAME.as_secs_f64(), &studio);
    }
    story.show(0.0, &studio);
    println!("{}", studio.url());

    let mut paused = false;
    loop {
        if story.time_secs() >= options.drive_secs {
            options.drive_secs = f64::INFINITY;
            story.take_driving(true, &studio);
        }
        let frame_start = Instant::now();
        while let Some(command) = commands.try_next() {
            match command {
                ClientMessage::Pause => paused = true,
                ClientMessage::Resume => paused = false,
                ClientMessage::Stop => story.stop(&studio),
                ClientMessage::Drive(drive) => story.drive_by_hand(drive, &studio),
                ClientMessage::DriveDone => story.take_driving(false, &studio),
                ClientMessage::Edit(_) => {}
            }
            story.set_paused(paused, &studio);
        }
        if paused || story.is_over() {
            story.show(0.0, &studio);
        } else {
            story.advance(FRAME.as_secs_f64() * options.speed, &studio);
            story.show(options.speed, &studio);
        }
        std::thread::sleep(FRAME.saturating_sub(frame_start.elapsed()));
    }
}
