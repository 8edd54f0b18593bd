//! What can go wrong in physics.

use std::path::PathBuf;

/// An error of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhysicsError {
    /// The MuJoCo library is not the one this program was built for.
    #[error("MuJoCo is version {found}, expected {expected}; `cargo x setup` fetches it")]
    Version {
        /// Version of the library.
        found: String,
        /// Version of the bindings.
        expected: String,
    },
    /// MuJoCo raised a fatal error inside a call; the state it worked on is lost.
    #[error("MuJoCo failed in {call}: {message}")]
    Engine {
        /// The call, by its MuJoCo name.
        call: &'static str,
        /// MuJoCo's own words.
        message: String,
    },
    /// The state was discarded by an earlier fatal error and can only be dropped.
    #[error("this state was discarded after an earlier failure ({cause}); make a new one")]
    Discarded {
        /// The failure that discarded it.
        cause: Box<PhysicsError>,
    },
    /// The state holds a number that is not finite, or too large to go on with.
    #[error("bad number in {quantity} of {owner} at {time_secs} s; reset or restore the state")]
    Diverged {
        /// `qpos`, `qvel`, `qacc` or `ctrl`.
        quantity: &'static str,
        /// Joint or actuator, with its name.
        owner: String,
        /// Simulated time.
        time_secs: f64,
    },
    /// The mass matrix cannot be factored.
    #[error("the inertia at {owner} is singular or nearly so at {time_secs} s")]
    SingularInertia {
        /// Joint, with its name.
        owner: String,
        /// Simulated time.
        time_secs: f64,
    },
    /// MuJoCo dropped contacts or constraints for want of memory.
    #[error(
        "no room for more {what} at {time_secs} s, found {found}; raise <size memory=\"...\"/>"
    )]
    Full {
        /// `contacts` or `constraints`.
        what: &'static str,
        /// How many there were.
        found: usize,
        /// Simulated time.
        time_secs: f64,
    },
    /// A model text could not be read.
    #[error("model {origin} cannot be read: {message}")]
    Parse {
        /// File, or what the text is.
        origin: String,
        /// MuJoCo's or the XML reader's own words.
        message: String,
    },
    /// A model was read but is not consistent.
    #[error("model {origin} does not compile: {message}")]
    Compile {
        /// File, or what the text is.
        origin: String,
        /// MuJoCo's own words.
        message: String,
    },
    /// A part could not be attached.
    #[error("part {part} cannot be attached to {target}: {message}")]
    Attach {
        /// The part's file.
        part: String,
        /// Site, or the world.
        target: String,
        /// MuJoCo's own words.
        message: String,
    },
    /// A file is missing or unreadable.
    #[error("file {} cannot be read: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's own words.
        message: String,
    },
    /// A name that the model does not have.
    #[error(
        "{kind} `{name}` is not in model `{model}`; available: {}",
        list(available)
    )]
    UnknownName {
        /// Kind of part, as `joint`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The model's name.
        model: String,
        /// The names it has.
        available: Vec<String>,
    },
    /// A mesh that a URDF names was not found.
    #[error(
        "URDF {} names `{reference}`, which was not found; looked in: {}",
        urdf.display(),
        list_paths(searched)
    )]
    MeshNotFound {
        /// The URDF file.
        urdf: PathBuf,
        /// What the URDF says.
        reference: String,
        /// Where it was looked for.
        searched: Vec<PathBuf>,
    },
    /// A mesh in a format that MuJoCo does not read.
    #[error(
        "mesh `{mesh}` of {} is in the format `{format}`, expected STL or OBJ; \
         convert it, for example with `blender` or `assimp export {mesh} out.obj`",
        origin.display()
    )]
    MeshFormat {
        /// The file that names the mesh.
        origin: PathBuf,
        /// The mesh, as named.
        mesh: String,
        /// Its extension.
        format: String,
    },
    /// A value of the wrong size.
    #[error("{what} has {found} values, expected {expected}")]
    Size {
        /// What was given.
        what: &'static str,
        /// Values given.
        found: usize,
        /// Values wanted.
        expected: usize,
    },
    /// A snapshot of another model.
    #[error("the snapshot is of model `{found}`, expected `{expected}`")]
    SnapshotModel {
        /// Model of the snapshot.
        found: String,
        /// Model of the state.
        expected: String,
    },
    /// An argument out of its range.
    #[error("{what} is {found}, expected {expected}")]
    Argument {
        /// Name of the argument.
        what: &'static str,
        /// Value given.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
}

/// Names, quoted; a long list is cut.
fn list(names: &[String]) -> String {
    const N_SHOWN: usize = 40;
    if names.is_empty() {
        return "none".to_owned();
    }
    let mut text = names
        .iter()
        .take(N_SHOWN)
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > N_SHOWN {
        text.push_str(&format!(" and {} more", names.len() - N_SHOWN));
    }
    text
}

fn list_paths(paths: &[PathBuf]) -> String {
    paths
        .iter()
        .map(|path| path.display().to_string())
        .collect::<Vec<_>>()
        .join(", ")
}
