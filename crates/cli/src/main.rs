//! `factotum`: a mobile manipulator's household chores, from the command line.
//!
//! Exit codes: 0 done, 1 ran with a negative answer (no plan, chore not achieved), 2 usage or bad input, 3 internal
//! fault. With `--json` one JSON document goes to standard output and every message to standard error.

mod assets;
mod audience;
mod belief;
mod class_look;
mod console;
mod demo;
mod doctor;
mod experiment;
mod explore;
mod hand;
mod home;
mod keeper;
mod map;
mod map_path;
mod plan;
mod result;
mod resume;
mod robot;
mod run;
mod session;
mod skill;
mod snapshot;
mod studio;
mod symbols;
mod teach;
mod watch;
mod wire_view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::console::{Answer, Console, UsageError};

/// Gives a mobile manipulator the abstractions it needs to work in a home.
#[derive(Debug, Parser)]
#[command(name = "factotum", version, propagate_version = true, after_help = EXAMPLES)]
struct Cli {
    /// Print one JSON document on standard output; messages go to standard error.
    #[arg(long, global = true)]
    json: bool,
    /// Say less: errors only.
    #[arg(short, long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  factotum run                                       watch a robot do three chores in a simulated home
  factotum run --headless --goal turn-light-off      one chore, no page
  factotum run --resume runs/2026-11-22-household-0  go on with a run that crashed or was stopped
  factotum run --home home                           the next day: chores in a home that is known
  factotum plan domain.pddl problem.pddl             task planning alone
  factotum map explore --out home                    a home folder from a robot's own exploring
  factotum map import map.yaml --out home            a home folder from a ROS map_server map
  factotum experiment run chores --seeds 20          how often the chores succeed
  factotum experiment report cip-ablation            figures of how contact skills are learned
  factotum symbols learn transitions.csv --out model symbols and PDDL from what a robot tried
  factotum skill train door --ablation fast          learn to open a door, in 30 to 100 tries
  factotum robot check my-robot/                     is my robot.toml right?
  factotum doctor                                    what is installed, what is missing

Exit codes: 0 done, 1 negative answer, 2 usage or bad input, 3 internal fault.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Do chores in a simulated home: map it, plan, act, and be judged by physics.
    Run(run::RunArgs),
    /// Plan with a PDDL domain and problem.
    Plan(plan::PlanArgs),
    /// Look at a home folder.
    #[command(subcommand)]
    Home(home::HomeCommand),
    /// Occupancy grids: explore, import, export, and plan a path.
    #[command(subcommand)]
    Map(map::MapCommand),
    /// Look at a stored home in the browser.
    Studio(studio::StudioArgs),
    /// Experiments over many seeds.
    #[command(subcommand)]
    Experiment(experiment::ExperimentCommand),
    /// Symbols to plan with, learned from recorded transitions.
    #[command(subcommand)]
    Symbols(symbols::SymbolsCommand),
    /// Learn contact skills, and judge them.
    #[command(subcommand)]
    Skill(skill::SkillCommand),
    /// Motions made by hand, to begin a motor skill with.
    #[command(subcommand)]
    Demo(demo::DemoCommand),
    /// Check a robot of your own.
    #[command(subcommand)]
    Robot(robot::RobotCommand),
    /// Say what is installed, what is missing, and how to get it.
    Doctor,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let console = Console::new(cli.json, cli.quiet);
    let answer = match &cli.command {
        Command::Run(args) => run::run(args, &console),
        Command::Plan(args) => plan::plan(args, &console),
        Command::Home(command) => home::home(command, &console),
        Command::Map(command) => map::map(command, &console),
        Command::Studio(args) => studio::studio(args, &console),
        Command::Experiment(command) => experiment::experiment(command, &console),
        Command::Symbols(command) => symbols::symbols(command, &console),
        Command::Skill(command) => skill::skill(command, &console),
        Command::Demo(command) => demo::demo(command, &console),
        Command::Robot(command) => robot::robot(command, &console),
        Command::Doctor => doctor::doctor(&console),
    };
    match answer {
        Ok(Answer::Yes) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(error) => {
            console.error(&error);
            ExitCode::from(if error.downcast_ref::<UsageError>().is_some() {
                2
            } else {
                3
            })
        }
    }
}
