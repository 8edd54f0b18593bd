//! The YAML side of a map: a flat list of `key: value`, with the origin as a list of three numbers.
//!
//! Only this subset of YAML is read (comments, quotes, inline and block lists included), which is all that
//! map_server files use; anything else is an error that names its line.

use crate::Pose2;
use std::path::PathBuf;

const KEYS: [&str; 7] = [
    "image",
    "resolution",
    "origin",
    "negate",
    "occupied_thresh",
    "free_thresh",
    "mode",
];

/// How pixels stand for occupancy; see the [module](super) for the formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapMode {
    /// Free, occupied or unknown.
    Trinary,
    /// As trinary, with degrees between the thresholds.
    Scale,
    /// The pixel is the occupancy in percent.
    Raw,
}

impl MapMode {
    const ALL: [Self; 3] = [Self::Trinary, Self::Scale, Self::Raw];

    /// Name in the YAML file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Trinary => "trinary",
            Self::Scale => "scale",
            Self::Raw => "raw",
        }
    }
}

/// What a map's YAML file says.
#[derive(Debug, Clone, PartialEq)]
pub struct MapMetadata {
    /// Image file, relative to the YAML file's folder unless absolute.
    pub image: PathBuf,
    /// Edge of a cell (m).
    pub resolution_m: f64,
    /// x (m), y (m) and yaw (rad) of the lower left corner of the lower left pixel.
    pub origin: [f64; 3],
    /// Whether white is occupied and black free.
    pub negate: bool,
    /// Occupancy (0 to 1) from which a cell is occupied.
    pub occupied_thresh: f64,
    /// Occupancy (0 to 1) up to which a cell is free.
    pub free_thresh: f64,
    /// How pixels stand for occupancy.
    pub mode: MapMode,
    /// Whether the file names its mode; old files do not, and stay so.
    pub has_mode_key: bool,
}

/// A YAML file that describes no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MetadataError {
    /// A line that is no `key: value`.
    #[error("line {line} is `{found}`, expected `key: value`")]
    Syntax {
        /// Number of the line, from 1.
        line: usize,
        /// The line.
        found: String,
    },
    /// A key that maps do not have.
    #[error("unknown key `{key}` in line {line}; did you mean `{nearest}`?")]
    UnknownKey {
        /// Number of the line, from 1.
        line: usize,
        /// The key.
        key: String,
        /// The most similar known key.
        nearest: &'static str,
    },
    /// A key given twice.
    #[error("key `{key}` in line {line} is given twice")]
    RepeatedKey {
        /// Number of the line, from 1.
        line: usize,
        /// The key.
        key: &'static str,
    },
    /// A key that must be there is not.
    #[error("key `{key}` is missing")]
    MissingKey {
        /// The key.
        key: &'static str,
    },
    /// A value of the wrong kind.
    #[error("`{key}` is `{found}`, expected {wanted}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value found.
        found: String,
        /// What was expected.
        wanted: &'static str,
    },
    /// Thresholds that leave no room between them.
    #[error("`free_thresh` {free_thresh} is not below `occupied_thresh` {occupied_thresh}")]
    Thresholds {
        /// Free up to here.
        free_thresh: f64,
        /// Occupied from here.
        occupied_thresh: f64,
    },
}

impl MapMetadata {
    /// Reads the text of a YAML file.
    ///
    /// # Errors
    /// [`MetadataError`] naming the line, key or value that is wrong.
    pub fn parse(text: &str) -> Result<Self, MetadataError> {
        let entries = Entries::parse(text)?;
        let number = |key, wanted, accept: fn(f64) -> bool| {
            let found = entries.required(key)?;
            let value = parse_number(found).filter(|v| accept(*v));
            value.ok_or_else(|| MetadataError::Value {
                key,
                found: found.to_owned(),
                wanted,
            })
        };
        let is_ratio = |v: f64| (0.0..=1.0).contains(&v);
        let free_thresh = number("free_thresh", "a number from 0 to 1", is_ratio)?;
        let occupied_thresh = number("occupied_thresh", "a number from 0 to 1", is_ratio)?;
        if free_thresh >= occupied_thresh {
            return Err(MetadataError::Thresholds {
                free_thresh,
                occupied_thresh,
            });
        }
        let (mode, has_mode_key) = parse_mode(entries.get("mode"))?;
        let image = entries.required("image")?;
        if image.is_empty() {
            let (key, wanted) = ("image", "the name of a PGM file");
            return Err(MetadataError::Value {
                key,
                found: String::new(),
                wanted,
            });
        }
        Ok(Self {
            image: PathBuf::from(image),
            resolution_m: number("resolution", "a positive number of metres", |v| v > 0.0)?,
            origin: parse_origin(entries.required("origin")?)?,
            negate: parse_negate(entries.required("negate")?)?,
            occupied_thresh,
            free_thresh,
            mode,
            has_mode_key,
        })
    }

    /// The text of a YAML file that reads back as exactly these metadata.
    #[must_use]
    pub fn to_yaml(&self) -> String {
        let [x, y, yaw] = self.origin;
        let image = self.image.to_string_lossy();
        // Quoted where a plain scalar would end early or change type.
        let needs_quotes = image.contains([':', '#', '\'', '"', '[', '{']) || image.trim() != image;
        let image = if needs_quotes {
            format!("'{}'", image.replace('\'', "''"))
        } else {
            image.into_owned()
        };
        let mode = if self.has_mode_key {
            format!("mode: {}\n", self.mode.name())
        } else {
            String::new()
        };
        format!(
            "image: {image}\n{mode}resolution: {:?}\norigin: [{x:?}, {y:?}, {yaw:?}]\nnegate: {}\n\
             occupied_thresh: {:?}\nfree_thresh: {:?}\n",
            self.resolution_m,
            u8::from(self.negate),
            self.occupied_thresh,
            self.free_thresh,
        )
    }
}

/// x, y and yaw of a grid's origin, as the YAML file has it.
pub(super) fn origin_of(world_from_grid: &Pose2) -> [f64; 3] {
    let t = world_from_grid.translation.vector;
    [t.x, t.y, world_from_grid.rotation.angle()]
}

/// Values by key; a block list is joined into an inline one.
struct Entries(Vec<(&'static str, String)>);

impl Entries {
    fn parse(text: &str) -> Result<Self, MetadataError> {
        let mut entries: Vec<(&'static str, String)> = Vec::new();
        for (i, raw) in text.lines().enumerate() {
            let line = i + 1;
            let content = without_comment(raw).trim();
            if content.is_empty() || content == "---" || content == "..." {
                continue;
            }
            let syntax = || MetadataError::Syntax {
                line,
                found: raw.to_owned(),
            };
            if let Some(item) = content.strip_prefix("- ") {
                let (_, list) = entries.last_mut().ok_or_else(syntax)?;
                append_item(list, item.trim()).ok_or_else(syntax)?;
                continue;
            }
            let (key, value) = content.split_once(':').ok_or_else(syntax)?;
            let key = known_key(key.trim(), line)?;
            if entries.iter().any(|(known, _)| *known == key) {
                return Err(MetadataError::RepeatedKey { line, key });
            }
            entries.push((key, unquoted(value.trim())));
        }
        Ok(Self(entries))
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.0
            .iter()
            .find(|(known, _)| *known == key)
            .map(|(_, value)| value.as_str())
    }

    fn required(&self, key: &'static str) -> Result<&str, MetadataError> {
        self.get(key).ok_or(MetadataError::MissingKey { key })
    }
}

fn append_item(list: &mut String, item: &str) -> Option<()> {
    let inner = match list.strip_suffix(']') {
        Some(inner) => format!("{inner}, "),
        None if list.is_empty() => "[".to_owned(),
        None => return None, // a scalar cannot also be a list
    };
    *list = format!("{inner}{item}]");
    Some(())
}

fn known_key(key: &str, line: usize) -> Result<&'static str, MetadataError> {
    if let Some(known) = KEYS.iter().find(|known| **known == key) {
        return Ok(known);
    }
    let likeness = |known: &&&str| (strsim::jaro_winkler(known, key) * 1e6) as u64;
    let nearest = KEYS.iter().max_by_key(likeness).copied().unwrap_or(KEYS[0]);
    Err(MetadataError::UnknownKey {
        line,
        key: key.to_owned(),
        nearest,
    })
}

/// The line up to a `#` that starts a comment: outside quotes, at the start or after a blank.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    for (at, c) in line.char_indices() {
        match quote {
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None if c == '\'' || c == '"' => quote = Some(c),
            None if c == '#' && before.is_whitespace() => return &line[..at],
            None => {}
        }
        before = c;
    }
    line
}

fn unquoted(value: &str) -> String {
    let inner = |quote| {
        value
            .strip_prefix(quote)
            .and_then(|v: &str| v.strip_suffix(quote))
    };
    if let Some(inner) = inner('\'') {
        inner.replace("''", "'")
    } else if let Some(inner) = inner('"') {
        inner.replace("\\\"", "\"").replace("\\\\", "\\")
    } else {
        value.to_owned()
    }
}

fn parse_number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|v| v.is_finite())
}

fn parse_origin(found: &str) -> Result<[f64; 3], MetadataError> {
    let numbers: Option<Vec<f64>> = found
        .strip_prefix('[')
        .and_then(|v| v.strip_suffix(']'))
        .and_then(|inner| {
            inner
                .split(',')
                .map(|item| parse_number(item.trim()))
                .collect()
        });
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| MetadataError::Value {
            key: "origin",
            found: found.to_owned(),
            wanted: "a list of three numbers, [x, y, yaw]",
        })
}

fn parse_negate(found: &str) -> Result<bool, MetadataError> {
    match found {
        "0" | "false" | "False" | "no" => Ok(false),
        "1" | "true" | "True" | "yes" => Ok(true),
        _ => Err(MetadataError::Value {
            key: "negate",
            found: found.to_owned(),
            wanted: "0, 1, false or true",
        }),
    }
}

fn parse_mode(found: Option<&str>) -> Result<(MapMode, bool), MetadataError> {
    let Some(found) = found else {
        return Ok((MapMode::Trinary, false));
    };
    let mode = MapMode::ALL.into_iter().find(|mode| mode.name() == found);
    mode.map(|mode| (mode, true))
        .ok_or_else(|| MetadataError::Value {
            key: "mode",
            found: found.to_owned(),
            wanted: "trinary, scale or raw",
        })
}
