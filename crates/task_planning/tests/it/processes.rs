//! Planners that are processes: limits, failures, and commands of every kind.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use factotum_task_planning::planner::{
    ExternalCommand, Limit, Limits, PlanOutcome, Planner as _, PlannerError,
};

use crate::tasks::coffee;

const COFFEE_PLAN: &str = "(pickup watercup counter)\n(pour watercup coffeemachine)\n\
    (place watercup counter)\n(pickup coffeegrinds counter)\n(pour coffeegrinds coffeemachine)\n\
    (place coffeegrinds counter)\n(closelid coffeemachine)\n(pushbutton coffeemachine)\n";

/// A planner that is a line of shell; `$1` is the domain, `$2` the problem, `$3` the plan file.
fn shell(script: &str) -> ExternalCommand {
    let args = ["-c", script, "sh", "{domain}", "{problem}", "{plan}"];
    ExternalCommand {
        name: "shell".to_owned(),
        program: PathBuf::from("/bin/sh"),
        args: args.map(str::to_owned).to_vec(),
        unsolvable_exit_codes: vec![11],
    }
}

fn solve(script: &str, limits: &Limits) -> Result<PlanOutcome, PlannerError> {
    let (domain, problem) = coffee();
    shell(script).solve(&domain, &problem, limits)
}

#[test]
fn a_command_gets_the_task_and_its_plan_is_judged() {
    let script =
        format!("grep -q PushButton $1 && grep -q WaterCup $2 && echo '{COFFEE_PLAN}' > $3");
    let outcome = solve(&script, &Limits::default()).unwrap();
    let plan = outcome.plan().unwrap();
    assert_eq!(plan.cost, 8.0);
    assert_eq!(plan.steps[0].to_string(), "(PickUp WaterCup counter)");
}

#[test]
fn exit_codes_without_a_plan_are_told_apart() {
    let limits = Limits::default();
    assert!(matches!(
        solve("exit 11", &limits),
        Ok(PlanOutcome::Unsolvable { .. })
    ));
    assert!(matches!(
        solve("exit 0", &limits),
        Ok(PlanOutcome::Exhausted { .. })
    ));
    let error = solve("echo out of luck; exit 3", &limits).unwrap_err();
    insta::assert_snapshot!(error, @"planner `shell` failed: exit status: 3: out of luck");
}

#[test]
fn a_plan_that_does_not_work_is_refused() {
    let script = "echo '(pushbutton coffeemachine)' > $3";
    let error = solve(script, &Limits::default()).unwrap_err();
    let source = std::error::Error::source(&error).unwrap();
    insta::assert_snapshot!(error, @"planner `shell` returned a plan that does not solve the problem");
    insta::assert_snapshot!(source, @"step 1 (PushButton CoffeeMachine) cannot run: (has-water CoffeeMachine) and (has-grounds CoffeeMachine) and (not (lid-open CoffeeMachine)) does not hold");
}

/// The limit ends the command and what it started: the grandchild would write a file after 1 s.
#[test]
fn time_is_a_limit_for_grandchildren_too() {
    let dir = tempfile::tempdir().unwrap();
    let late = dir.path().join("late");
    let script = format!("(sleep 1; touch {}) & sleep 60", late.display());
    let started = Instant::now();
    let limits = Limits {
        time: Duration::from_millis(200),
        ..Limits::default()
    };
    let outcome = solve(&script, &limits).unwrap();
    assert_eq!(outcome, PlanOutcome::LimitReached { limit: Limit::Time });
    assert!(
        started.elapsed() < Duration::from_secs(5),
        "{:?}",
        started.elapsed()
    );
    std::thread::sleep(Duration::from_millis(1500));
    assert!(!late.exists(), "the grandchild outlived its limit");
}

#[test]
fn memory_is_limited() {
    let limits = Limits {
        memory_mib: 512,
        ..Limits::default()
    };
    let script = "ulimit -v | grep -qx 524288 && exit 11; exit 3";
    assert!(matches!(
        solve(script, &limits),
        Ok(PlanOutcome::Unsolvable { .. })
    ));
}

#[test]
fn a_program_that_is_not_there_is_missing() {
    let (domain, problem) = coffee();
    let command = ExternalCommand {
        program: PathBuf::from("/nowhere/planner"),
        ..shell("")
    };
    let error = command
        .solve(&domain, &problem, &Limits::default())
        .unwrap_err();
    insta::assert_snapshot!(error, @"planner `shell` not found; looked at `/nowhere/planner`; correct the configured program");
}
