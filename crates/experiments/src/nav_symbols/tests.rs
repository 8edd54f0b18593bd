use std::path::Path;

use factotum_worlds::action_map::ActionMap;

use super::*;
use crate::nav_symbols::trial::trial;
use crate::sweep::read_results;

/// A room of 3 by 3 m with mug and machine against walls; feasible is what faces them from within 0.9 m.
fn kitchen(name: &str, mug: [f64; 2], machine: [f64; 2], folder: &Path) -> Kitchen {
    let cells: Vec<[f64; 2]> = (0..169)
        .map(|i| [f64::from(i % 13) * 0.25, f64::from(i / 13) * 0.25])
        .collect();
    let poses = |[ox, oz]: [f64; 2]| {
        let mut poses = Vec::new();
        for [x, z] in &cells {
            let (dx, dz) = (ox - x, oz - z);
            let quarters = (dx.atan2(dz).to_degrees() / 90.0).round().rem_euclid(4.0);
            if (0.1..0.9).contains(&dx.hypot(dz)) {
                poses.push([*x, 0.9, *z, 90.0 * quarters]);
            }
        }
        poses
    };
    let map = serde_json::json!({
        "scene": name,
        "grid": 0.25,
        "reachable": cells.iter().map(|[x, z]| [*x, 0.9, *z]).collect::<Vec<_>>(),
        "actions": {
            format!("Mug|{}|+00.90|{}", mug[0], mug[1]): {"PickupObject": poses(mug)},
            format!("CoffeeMachine|{}|+00.90|{}", machine[0], machine[1]): {
                "ToggleObjectOn": poses(machine), "PutObject": poses(machine),
            },
        },
    });
    let file = folder.join(format!("{name}.json"));
    std::fs::write(&file, map.to_string()).unwrap();
    Kitchen::new(ActionMap::read(&file).unwrap()).unwrap()
}

fn kitchens() -> Vec<Kitchen> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name, mug, machine| kitchen(name, mug, machine, folder.path());
    vec![
        at("a", [0.0, 1.5], [3.0, 0.1]),
        at("b", [1.1, 3.0], [0.4, 0.1]),
        at("c", [2.9, 2.0], [1.4, 3.0]),
    ]
}

fn n_tries(method: Method, setting: Setting) -> u32 {
    let kitchens = kitchens();
    (0..3)
        .flat_map(|seed| trial(&kitchens, method, setting, seed, 3).unwrap())
        .map(|one| one.n_tries())
        .sum()
}

/// Knowing the answers takes a try a step; learning them takes more, and proposing anywhere the most.
#[test]
fn knowing_less_takes_more_tries() {
    for setting in Setting::ALL {
        let tries = |method| n_tries(method, setting);
        assert_eq!(tries(Method::Oracle), 3 * 3 * 4, "{setting}");
        let (ours, heuristic) = (tries(Method::Ours), tries(Method::HeuristicObject));
        assert!(ours < heuristic, "{setting}: {ours} {heuristic}");
        assert!(heuristic < tries(Method::RandomGlobal), "{setting}");
    }
}

#[test]
fn the_same_seed_is_the_same_trial_and_another_is_not() {
    let kitchens = kitchens();
    let run = |seed| trial(&kitchens, Method::Ours, Setting::Multi, seed, 3).unwrap();
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
    let names = |method| -> Vec<String> {
        let completions = trial(&kitchens, method, Setting::Multi, 7, 3).unwrap();
        completions.into_iter().map(|one| one.kitchen).collect()
    };
    // All methods meet the same kitchens, and none twice before all were.
    assert_eq!(names(Method::Ours), names(Method::Oracle));
    let mut met = names(Method::Oracle);
    met.sort();
    assert_eq!(met, ["a", "b", "c"]);
}

#[test]
fn a_study_goes_on_where_it_was_and_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let study = |n_completions| NavStudy {
        kitchens: kitchens(),
        seeds: vec![3],
        n_completions,
        n_workers: 2,
        folder: folder.path().to_path_buf(),
    };
    let stop = StopWish::default();
    let results = study(2).run(&stop, |_, _| {}).unwrap();
    assert_eq!(results.len(), 2 * Method::ALL.len());
    let mut n_new = 0;
    assert_eq!(study(2).run(&stop, |_, _| n_new += 1).unwrap(), results);
    assert_eq!(n_new, 0);
    let error = study(3).run(&stop, |_, _| {}).unwrap_err();
    assert!(error.is_of_input(), "{error}");
    let file = folder.path().join(crate::sweep::RESULTS_NAME);
    let kept: Vec<TrialResult> = read_results(&file).unwrap();
    assert_eq!(kept.len(), results.len());

    let (table, files) = report(folder.path(), folder.path()).unwrap();
    assert_eq!(table.rows.len(), Method::ALL.len());
    let oracle = table.rows[0].multi.as_ref().unwrap();
    assert_eq!(oracle.n_tries.mean, 8.0);
    assert_eq!(oracle.ratio_to_oracle, Some(1.0));
    assert!(files.iter().all(|file| file.exists()));
    assert!(table.to_markdown().contains("| `random_global` |"));
    let empty = tempfile::tempdir().unwrap();
    assert!(
        report(empty.path(), empty.path())
            .unwrap_err()
            .is_of_input()
    );
}

/// Where nothing near the object is feasible, it is looked for everywhere; a kitchen without a mug is none.
#[test]
fn odd_kitchens_are_survived_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, actions: serde_json::Value| {
        let cells: Vec<[f64; 3]> = (0..4).map(|i| [0.25 * f64::from(i), 0.9, 0.0]).collect();
        let map = serde_json::json!({"scene": name, "grid": 0.25, "reachable": cells, "actions": actions});
        let file = folder.path().join(name);
        std::fs::write(&file, map.to_string()).unwrap();
        Kitchen::new(ActionMap::read(&file).unwrap())
    };
    let machine = serde_json::json!({"ToggleObjectOn": [[0.5, 0.9, 0.0, 0.0]], "PutObject": [[0.5, 0.9, 0.0, 0.0]]});
    let far = read(
        "far.json",
        serde_json::json!({
            "Mug|9|1|0": {"PickupObject": [[0.25, 0.9, 0.0, 270.0]]},
            "CoffeeMachine|0.5|1|0.5": machine.clone(),
        }),
    );
    for method in [Method::Ours, Method::HeuristicObject] {
        let completions = trial(&[far.clone().unwrap()], method, Setting::Single, 1, 2).unwrap();
        assert_eq!(completions.len(), 2, "{method}");
        assert!(completions.iter().all(|one| !one.is_stuck), "{method}");
    }
    let without = |mug: serde_json::Value| {
        let actions =
            serde_json::json!({"Mug|9|1|0": mug, "CoffeeMachine|0.5|1|0.5": machine.clone()});
        read("without.json", actions).unwrap_err().class
    };
    assert_eq!(without(serde_json::json!({})), "Mug");
    assert_eq!(without(serde_json::json!({"PickupObject": []})), "Mug");
}

#[test]
fn names_in_files_are_those_in_answers() {
    for method in Method::ALL {
        let word = serde_json::to_value(method).unwrap();
        assert_eq!(word, method.name());
    }
}
