//! `factotum home`: look at a home folder.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use factotum_semantic_map::{Aosm, Home, HomeCheck, Location, home_folder};
use serde_json::json;

use crate::console::{Answer, Console, usage};

/// Arguments of `factotum home`.
#[derive(Debug, Subcommand)]
pub(crate) enum HomeCommand {
    /// Print what a home folder holds.
    Show {
        /// The folder.
        dir: PathBuf,
    },
    /// Check a home folder: files, names, states, journal, and that it makes a planning domain. Changes nothing.
    Check {
        /// The folder.
        dir: PathBuf,
    },
}

/// Runs `factotum home`.
pub(crate) fn home(command: &HomeCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        HomeCommand::Show { dir } => {
            let (name, aosm) = read(dir)?;
            console.answer(&document(&name, &aosm), || text(&name, &aosm))?;
        }
        HomeCommand::Check { dir } => {
            let check = Home::check(dir).map_err(usage)?;
            let domain = check.aosm.domain().map_err(usage)?;
            let n_operators = domain.operators().len();
            console.answer(
                &json!({"home": check.name, "ok": true, "operators": n_operators,
                        "journal_entries": check.n_entries, "changed_outside": check.changed}),
                || in_words(&check, n_operators),
            )?;
        }
    }
    Ok(Answer::Yes)
}

fn in_words(check: &HomeCheck, n_operators: usize) -> String {
    let journal = check.n_entries.map_or_else(
        || "no journal yet".to_owned(),
        |n_entries| format!("journal of {n_entries} entries"),
    );
    let mut text = format!(
        "{}: in order; {} objects, {n_operators} operators, {journal}",
        check.name,
        check.aosm.objects.len()
    );
    if !check.changed.is_empty() {
        let changed = check.changed.join("`, `");
        text.push_str(&format!(
            "\nchanged outside the journal, to be taken in when the home is next used: `{changed}`"
        ));
    }
    text
}

/// Reads a home folder; what is wrong with it is the user's to mend.
pub(crate) fn read(dir: &Path) -> anyhow::Result<(String, Aosm)> {
    home_folder::read(dir).map_err(usage)
}

fn document(name: &str, aosm: &Aosm) -> serde_json::Value {
    let objects: Vec<_> = aosm
        .objects
        .values()
        .map(|object| {
            let [x, y, z] = object.map_from_object.translation.vector.into();
            let inside = match &object.location {
                Location::In(container) => Some(container),
                Location::Loose | Location::Held => None,
            };
            json!({"name": object.name, "class": object.class, "xyz": [x, y, z], "states": aosm.states_of(object), "inside": inside})
        })
        .collect();
    let [free, occupied, unknown] = aosm.grid.count_states();
    json!({
        "home": name,
        "map": {"width": aosm.grid.width(), "height": aosm.grid.height(), "resolution_m": aosm.grid.resolution_m(),
                 "free": free, "occupied": occupied, "unknown": unknown},
        "classes": aosm.classes.keys().collect::<Vec<_>>(),
        "objects": objects,
        "options": aosm.options().iter().map(|option| option.step.to_string()).collect::<Vec<_>>(),
    })
}

fn text(name: &str, aosm: &Aosm) -> String {
    let grid = &aosm.grid;
    let area_m2 = grid.count_states()[0] as f64 * grid.resolution_m().powi(2);
    let mut lines = vec![
        format!("{name}"),
        format!(
            "  map      {} x {} cells of {} m, {area_m2:.1} m² free",
            grid.width(),
            grid.height(),
            grid.resolution_m()
        ),
        format!(
            "  classes  {}",
            aosm.classes.keys().cloned().collect::<Vec<_>>().join(", ")
        ),
    ];
    for object in aosm.objects.values() {
        let at = object.map_from_object.translation.vector;
        let states = aosm.states_of(object).join(", ");
        lines.push(format!(
            "  {:<16} at ({:.2}, {:.2}, {:.2}) m  {states}",
            object.name, at.x, at.y, at.z
        ));
    }
    lines.push("  options".to_owned());
    lines.extend(
        aosm.options()
            .iter()
            .map(|option| format!("    {}", option.step)),
    );
    lines.join("\n")
}
