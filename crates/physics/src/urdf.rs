//! URDF, rewritten so that MuJoCo reads all of it.
//!
//! MuJoCo's URDF reader knows neither `package://` nor `file://`, by default strips folders from mesh
//! names, drops visual shapes and fuses links that do not move, and takes meshes whose files have the
//! same stem for one, as `visual/arm.stl` and `collision/arm.stl` have. The rewritten text names each
//! mesh by an alias of its own, whose file is set after reading, and carries a
//! `<mujoco><compiler .../></mujoco>` section that turns the rest off.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::error::PhysicsError;
use crate::scene::escaped;
use crate::spec::Spec;

/// How a URDF is read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UrdfOptions {
    /// Folders that hold packages, or are one: `package://name/rest` is looked for as `dir/name/rest`
    /// and as `dir/rest` where `dir` is called `name`. The folders above the file are tried last.
    pub package_dirs: Vec<PathBuf>,
}

/// Reads a URDF and writes it as MJCF, with meshes by their full paths.
///
/// # Errors
/// [`PhysicsError::File`], [`PhysicsError::Parse`] for broken XML, [`PhysicsError::MeshNotFound`],
/// [`PhysicsError::MeshFormat`] for a COLLADA mesh, [`PhysicsError::Compile`].
pub fn urdf_to_mjcf(path: &Path, options: &UrdfOptions) -> Result<String, PhysicsError> {
    let mut spec = urdf_spec(path, options)?;
    spec.compile()?;
    spec.to_xml()
}

/// Reads a URDF, ready to be attached or compiled.
pub(crate) fn urdf_spec(path: &Path, options: &UrdfOptions) -> Result<Spec, PhysicsError> {
    let text = std::fs::read_to_string(path).map_err(|error| PhysicsError::File {
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    let origin = path.display().to_string();
    let parse_error = |message: String| PhysicsError::Parse {
        origin: origin.clone(),
        message,
    };
    let document = Document::parse(&text).map_err(|error| parse_error(error.to_string()))?;
    let root = document.root_element();
    if !root.has_tag_name("robot") {
        return Err(parse_error(format!(
            "the root element is <{}>, expected <robot>",
            root.tag_name().name()
        )));
    }
    let (mut edits, aliases) = mesh_edits(path, root, options)?;
    edits.extend(compiler_edits(root, &text));
    let mut spec = Spec::from_text(&origin, &apply(&text, edits))?;
    for (name, file) in &aliases.file_by_name {
        spec.set_mesh_file(name, file)?;
    }
    Ok(spec)
}

/// Names of our own for meshes: one for each file and scale.
#[derive(Debug, Default)]
struct Aliases {
    name_by_use: BTreeMap<(PathBuf, String), String>,
    file_by_name: BTreeMap<String, PathBuf>,
    taken: BTreeSet<String>,
}

impl Aliases {
    /// The alias of a mesh, without extension: its stem, with a number where another has it.
    fn name(&mut self, file: &Path, scale: &str) -> String {
        let key = (file.to_owned(), scale.to_owned());
        if let Some(name) = self.name_by_use.get(&key) {
            return name.clone();
        }
        // MuJoCo ends the name at the first or at the last dot; leave none.
        let stem = file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .replace('.', "_");
        let numbered = (2..).map(|i: u32| format!("{stem}_{i}"));
        let name = std::iter::once(stem.clone())
            .chain(numbered)
            .find(|name| !self.taken.contains(name))
            .unwrap_or(stem);
        self.taken.insert(name.clone());
        self.name_by_use.insert(key, name.clone());
        self.file_by_name.insert(name.clone(), file.to_owned());
        name
    }
}

/// A piece of the text and what takes its place.
#[derive(Debug)]
struct Edit {
    range: std::ops::Range<usize>,
    text: String,
}

fn apply(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| edit.range.start);
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(&text[at..edit.range.start]);
        out.push_str(&edit.text);
        at = edit.range.end;
    }
    out.push_str(&text[at..]);
    out
}

const COMPILER: &str =
    "<compiler fusestatic=\"false\" strippath=\"false\" discardvisual=\"false\"/>";

/// Puts our compiler settings after the file's own, which they override where they disagree.
fn compiler_edits(root: Node<'_, '_>, text: &str) -> Vec<Edit> {
    let own = root.children().find(|node| node.has_tag_name("mujoco"));
    let Some(own) = own else {
        let end = closing_tag(root, text);
        return vec![Edit {
            range: end..end,
            text: format!("<mujoco>{COMPILER}</mujoco>"),
        }];
    };
    let Some(compiler) = own.children().find(|node| node.has_tag_name("compiler")) else {
        return vec![Edit {
            range: own.range(),
            text: format!("<mujoco>{COMPILER}{}</mujoco>", inner(own, text)),
        }];
    };
    // Keep the file's own attributes but for the three we set, and meshdir, which full paths replace.
    let kept: String = compiler
        .attributes()
        .filter(|attribute| {
            !["fusestatic", "strippath", "discardvisual", "meshdir"].contains(&attribute.name())
        })
        .map(|attribute| format!(" {}=\"{}\"", attribute.name(), escaped(attribute.value())))
        .collect();
    vec![Edit {
        range: compiler.range(),
        text: COMPILER.replacen("<compiler", &format!("<compiler{kept}"), 1),
    }]
}

/// Where the closing tag of an element begins.
fn closing_tag(node: Node<'_, '_>, text: &str) -> usize {
    let range = node.range();
    text[range.clone()]
        .rfind("</")
        .map_or(range.end, |at| range.start + at)
}

/// The text between an element's tags.
fn inner<'t>(node: Node<'_, '_>, text: &'t str) -> &'t str {
    match (node.first_child(), node.last_child()) {
        (Some(first), Some(last)) => &text[first.range().start..last.range().end],
        _ => "",
    }
}

fn mesh_edits(
    path: &Path,
    root: Node<'_, '_>,
    options: &UrdfOptions,
) -> Result<(Vec<Edit>, Aliases), PhysicsError> {
    let own_mesh_dir = root
        .descendants()
        .filter(|node| node.has_tag_name("compiler"))
        .find_map(|node| node.attribute("meshdir"));
    let mut edits = Vec::new();
    let mut aliases = Aliases::default();
    for mesh in root.descendants().filter(|node| node.has_tag_name("mesh")) {
        let Some(attribute) = mesh.attribute_node("filename") else {
            continue;
        };
        let reference = attribute.value();
        let found = resolve(path, reference, own_mesh_dir, options)?;
        let extension = mesh_extension(path, reference)?;
        let name = aliases.name(&found, mesh.attribute("scale").unwrap_or_default());
        edits.push(Edit {
            range: attribute.range_value(),
            text: escaped(&format!("{name}.{extension}")),
        });
    }
    Ok((edits, aliases))
}

/// The extension of a mesh, if MuJoCo reads it.
fn mesh_extension(path: &Path, reference: &str) -> Result<String, PhysicsError> {
    let extension = Path::new(reference)
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    if matches!(extension.as_str(), "stl" | "obj" | "msh") {
        return Ok(extension);
    }
    Err(PhysicsError::MeshFormat {
        origin: path.to_owned(),
        mesh: reference.to_owned(),
        format: extension,
    })
}

/// The file that a mesh reference means.
fn resolve(
    urdf: &Path,
    reference: &str,
    own_mesh_dir: Option<&str>,
    options: &UrdfOptions,
) -> Result<PathBuf, PhysicsError> {
    let dir = urdf.parent().unwrap_or(Path::new(""));
    let searched = if let Some(rest) = reference
        .strip_prefix("package://")
        .or_else(|| reference.strip_prefix("model://"))
    {
        package_candidates(dir, rest, options)
    } else if let Some(rest) = reference.strip_prefix("file://") {
        vec![dir.join(rest)]
    } else {
        let mut candidates = vec![dir.join(reference)];
        if let Some(mesh_dir) = own_mesh_dir {
            candidates.push(dir.join(mesh_dir).join(reference));
        }
        candidates.extend(
            options
                .package_dirs
                .iter()
                .map(|package| package.join(reference)),
        );
        candidates
    };
    let found = searched.iter().find(|candidate| candidate.is_file());
    let Some(found) = found else {
        return Err(PhysicsError::MeshNotFound {
            urdf: urdf.to_owned(),
            reference: reference.to_owned(),
            searched,
        });
    };
    // A full path stands whatever folder MuJoCo counts from.
    std::path::absolute(found).map_err(|error| PhysicsError::File {
        path: found.clone(),
        message: error.to_string(),
    })
}

/// Where `package/rest` may be: in the given folders, then in those above the file.
fn package_candidates(dir: &Path, reference: &str, options: &UrdfOptions) -> Vec<PathBuf> {
    let (package, rest) = reference.split_once('/').unwrap_or((reference, ""));
    let above = std::path::absolute(dir).unwrap_or_else(|_| dir.to_owned());
    let dirs = options
        .package_dirs
        .iter()
        .map(PathBuf::as_path)
        .chain(above.ancestors());
    let mut candidates = Vec::new();
    for dir in dirs {
        candidates.push(dir.join(package).join(rest));
        if dir.file_name().is_some_and(|name| name == package) {
            candidates.push(dir.join(rest));
        }
    }
    // Some packages ship without the folder that the reference names.
    candidates.extend(above.ancestors().take(2).map(|dir| dir.join(rest)));
    candidates
}
