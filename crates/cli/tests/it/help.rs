//! What the program says of itself.

use crate::factotum;

#[test]
fn help_names_commands_examples_and_exit_codes() {
    let said = factotum(&["--help"]);
    assert_eq!(said.code, Some(0));
    insta::assert_snapshot!(said.stdout);
}

#[test]
fn help_of_run_names_its_options() {
    let said = factotum(&["run", "--help"]);
    assert_eq!(said.code, Some(0));
    insta::assert_snapshot!(said.stdout);
}

#[test]
fn an_unknown_command_is_a_usage_error() {
    assert_eq!(factotum(&["dance"]).code, Some(2));
}

#[test]
fn experiments_are_listed() {
    let said = factotum(&["experiment", "list", "--json"]);
    assert_eq!(said.code, Some(0));
    let document = said.json();
    let names: Vec<&str> = document
        .as_array()
        .unwrap()
        .iter()
        .map(|experiment| experiment["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "bootstrap-matrix",
            "bootstrap-noise",
            "bootstrap-sim",
            "chores",
            "cip-ablation",
            "cip-compose",
            "cip-robustness",
            "nav-symbols"
        ]
    );
}
