//! `factotum doctor`: what is installed, what is missing, how to get it.

use factotum_physics::Model;
use factotum_task_planning::planner::FastDownward;
use serde_json::json;

use crate::assets;
use crate::console::{Answer, Console};
use crate::plan::fast_downward_places;

struct Finding {
    what: &'static str,
    /// What was found, or what to do.
    found: Result<String, String>,
    is_needed: bool,
}

/// Runs `factotum doctor`.
pub(crate) fn doctor(console: &Console) -> anyhow::Result<Answer> {
    let findings = [
        Finding {
            what: "MuJoCo",
            found: Model::from_mjcf_str("<mujoco/>")
                .map(|_| {
                    format!(
                        "{} loads and compiles models",
                        factotum_physics::engine_version()
                    )
                })
                .map_err(|error| format!("{error}; run `cargo x setup`")),
            is_needed: true,
        },
        Finding {
            what: "models",
            found: assets::dir()
                .map(|dir| dir.display().to_string())
                .map_err(|error| error.to_string()),
            is_needed: true,
        },
        Finding {
            what: "page",
            found: if factotum_studio::is_page_built() {
                Ok("built in".to_owned())
            } else {
                Err(
                    "not built; with Node.js installed, run `cargo x setup` and build again"
                        .to_owned(),
                )
            },
            is_needed: false,
        },
        Finding {
            what: "planner ferroplan",
            found: Ok("built in".to_owned()),
            is_needed: true,
        },
        Finding {
            what: "planner Fast Downward",
            found: FastDownward::discover(&fast_downward_places())
                .map(|_| "found".to_owned())
                .map_err(|_not_found| {
                    "not found; `cargo x setup` or `pip install up-fast-downward` gets it"
                        .to_owned()
                }),
            is_needed: false,
        },
    ];
    let is_well = findings
        .iter()
        .all(|finding| finding.found.is_ok() || !finding.is_needed);
    let document: Vec<_> = findings
        .iter()
        .map(|finding| {
            json!({"what": finding.what, "ok": finding.found.is_ok(), "needed": finding.is_needed,
                    "found": match &finding.found { Ok(text) | Err(text) => text }})
        })
        .collect();
    console.answer(&json!({"ok": is_well, "findings": document}), || {
        let line = |finding: &Finding| match &finding.found {
            Ok(text) => format!("ok       {:<22} {text}", finding.what),
            Err(text) if finding.is_needed => format!("MISSING  {:<22} {text}", finding.what),
            Err(text) => format!("optional {:<22} {text}", finding.what),
        };
        findings.iter().map(line).collect::<Vec<_>>().join("\n")
    })?;
    Ok(Answer::from(is_well))
}
