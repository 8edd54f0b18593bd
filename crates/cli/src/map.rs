//! `factotum map`: occupancy grids in and out, and ways on them.

use std::path::PathBuf;

use clap::Subcommand;
use factotum_geometry::grid::map_server::StoredMap;
use factotum_semantic_map::{Aosm, home_folder};
use serde_json::json;

use crate::console::{Answer, Console, usage};
use crate::explore::{ExploreArgs, explore};
use crate::map_path::{PathArgs, path};

/// Arguments of `factotum map`.
#[derive(Debug, Subcommand)]
pub(crate) enum MapCommand {
    /// Let a robot explore a simulated home, and keep what it found as a home folder.
    Explore(ExploreArgs),
    /// Make a home folder from a ROS map_server map.
    Import {
        /// The map's YAML file.
        yaml: PathBuf,
        /// Folder to make.
        #[arg(long)]
        out: PathBuf,
        /// Name of the home; the file's name if absent.
        #[arg(long)]
        name: Option<String>,
    },
    /// Plan a path of the base in a home's map.
    Path(PathArgs),
    /// Write a home's map as ROS map_server files.
    Export {
        /// The home folder.
        home: PathBuf,
        /// YAML file to write; the image goes beside it.
        #[arg(long)]
        out: PathBuf,
    },
}

/// Runs `factotum map`.
pub(crate) fn map(command: &MapCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        MapCommand::Explore(args) => return explore(args, console),
        MapCommand::Path(args) => return path(args, console),
        MapCommand::Import { yaml, out, name } => {
            let stored = StoredMap::read(yaml).map_err(usage)?;
            let grid = stored.checked_grid().map_err(usage)?;
            if out.join("home.toml").exists() {
                return Err(usage(format!(
                    "`{}` is a home folder already; nothing was written",
                    out.display()
                )));
            }
            let name = name.clone().unwrap_or_else(|| {
                yaml.file_stem().map_or_else(
                    || "home".to_owned(),
                    |stem| stem.to_string_lossy().into_owned(),
                )
            });
            let (width, height) = (grid.width(), grid.height());
            home_folder::write(out, &name, &Aosm::new([], grid)).map_err(usage)?;
            // The map keeps its own pixels and thresholds: an export gives back what was imported.
            stored.write(&out.join("map.yaml")).map_err(usage)?;
            console.answer(
                &json!({"home": name, "width": width, "height": height}),
                || format!("{name}: {width} x {height} cells in `{}`", out.display()),
            )?;
        }
        MapCommand::Export { home, out } => {
            let mut stored = StoredMap::read(&home.join("map.yaml")).map_err(usage)?;
            let image = out.with_extension("pgm");
            if image == *out {
                return Err(usage(format!(
                    "--out is `{}`; expected the name of the YAML file, the image goes beside it",
                    out.display()
                )));
            }
            if let Some(file) = [out, &image].into_iter().find(|file| file.exists()) {
                return Err(usage(format!(
                    "`{}` exists already; nothing was written",
                    file.display()
                )));
            }
            stored.metadata.image = image.file_name().map(PathBuf::from).unwrap_or_default();
            stored.write(out).map_err(usage)?;
            console.answer(&json!({"map": out}), || {
                format!("wrote `{}`", out.display())
            })?;
        }
    }
    Ok(Answer::Yes)
}
