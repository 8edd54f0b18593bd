//! Reading transitions from a table: CSV as it is or packed by gzip.
//!
//! | column | holds |
//! |---|---|
//! | `episode` | a whole number; a new one starts an episode |
//! | `option` | the name of the option that ran |
//! | `sNAME`, `nNAME` | variable NAME before and after, finite numbers |
//! | `initNAME` | `1` if option NAME could have run before, else `0` |
//! | `mask` (optional) | the changed variables as indices in the order of the `s` columns, apart by blanks |
//! | `reward`, `goal_achieved` (optional) | a number; `1` or `0` |
//! | `done`, `next_options` (optional) | not used |
//!
//! NAME may follow a `:` or `_` (`s:player_x`, `init_go_left`). Fields are not quoted.

use std::io::{BufRead, BufReader, Read};

use super::{ReadError, Transition, Transitions};

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

const FIXED: [&str; 7] = [
    "episode",
    "option",
    "mask",
    "reward",
    "goal_achieved",
    "done",
    "next_options",
];

/// Reads a table of transitions; gzip is recognised by its first bytes.
///
/// # Errors
/// [`ReadError`], with row, column, what was found and what was wanted.
pub fn read_csv(source: impl Read) -> Result<Transitions, ReadError> {
    let mut source = BufReader::new(source);
    if source.fill_buf()?.starts_with(&GZIP_MAGIC) {
        read_table(BufReader::new(flate2::bufread::MultiGzDecoder::new(source)))
    } else {
        read_table(source)
    }
}

fn read_table(mut source: impl BufRead) -> Result<Transitions, ReadError> {
    let mut line = String::new();
    source.read_line(&mut line)?;
    let columns = Columns::parse(line.trim_end())?;
    let mut transitions = Transitions::new(columns.variables.clone(), columns.options.clone());
    let mut row_buffers = RowBuffers::default();
    for row in 2.. {
        line.clear();
        if source.read_line(&mut line)? == 0 {
            break;
        }
        let text = line.trim_end_matches(['\r', '\n']);
        if !text.is_empty() {
            columns.read_row(row, text, &mut row_buffers, &mut transitions)?;
        }
    }
    Ok(transitions)
}

/// Where each thing stands in a row.
#[derive(Debug)]
struct Columns {
    names: Vec<String>,
    variables: Vec<String>,
    options: Vec<String>,
    states: Vec<usize>,
    next_states: Vec<usize>,
    executable: Vec<usize>,
    episode: usize,
    option: usize,
    mask: Option<usize>,
    reward: Option<usize>,
    goal_achieved: Option<usize>,
}

/// The columns of one family, as (NAME, place).
type Family = Vec<(String, usize)>;

impl Columns {
    fn parse(header: &str) -> Result<Self, ReadError> {
        let header = header.trim_start_matches('\u{feff}');
        if header.is_empty() {
            return Err(ReadError::Empty {
                wanted: "`episode`, `option`, `s0`, `n0`, `init0`",
            });
        }
        let names: Vec<String> = header.split(',').map(|n| n.trim().to_owned()).collect();
        let [mut states, mut next_states, mut executable] = [const { Family::new() }; 3];
        for (place, name) in names.iter().enumerate() {
            if names[..place].contains(name) {
                return Err(ReadError::DuplicateColumn {
                    column: name.clone(),
                });
            }
            if FIXED.contains(&name.as_str()) {
                continue;
            }
            // `init` before `s` and `n`: the longest prefix wins.
            if let Some(option) = member(name, "init") {
                executable.push((option, place));
            } else if let Some(variable) = member(name, "s") {
                states.push((variable, place));
            } else if let Some(variable) = member(name, "n") {
                next_states.push((variable, place));
            } else {
                return Err(ReadError::UnknownColumn {
                    column: name.clone(),
                    hint: nearest_hint(name),
                });
            }
        }
        let find = |wanted: &str| names.iter().position(|name| name == wanted);
        let need = |wanted: &str| find(wanted).ok_or_else(|| missing(wanted, &names));
        if states.is_empty() {
            return Err(missing("s0", &names));
        }
        if executable.is_empty() {
            return Err(missing("init0", &names));
        }
        let after = |(variable, _): &(String, usize)| {
            let found = next_states.iter().find(|(name, _)| name == variable);
            found
                .map(|(_, place)| *place)
                .ok_or_else(|| missing(&format!("n:{variable}"), &names))
        };
        let paired = states.iter().map(after).collect::<Result<_, _>>()?;
        if let Some((variable, _)) =
            (next_states.iter()).find(|(name, _)| !states.iter().any(|(s, _)| s == name))
        {
            return Err(missing(&format!("s:{variable}"), &names));
        }
        Ok(Self {
            next_states: paired,
            episode: need("episode")?,
            option: need("option")?,
            mask: find("mask"),
            reward: find("reward"),
            goal_achieved: find("goal_achieved"),
            states: states.iter().map(|(_, place)| *place).collect(),
            executable: executable.iter().map(|(_, place)| *place).collect(),
            variables: states.into_iter().map(|(name, _)| name).collect(),
            options: executable.into_iter().map(|(name, _)| name).collect(),
            names,
        })
    }

    fn read_row(
        &self,
        row: usize,
        text: &str,
        buffers: &mut RowBuffers,
        transitions: &mut Transitions,
    ) -> Result<(), ReadError> {
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        if fields.len() != self.names.len() {
            return Err(ReadError::Ragged {
                row,
                found: fields.len(),
                wanted: self.names.len(),
            });
        }
        let reader = RowReader {
            row,
            fields: &fields,
            names: &self.names,
        };
        reader.numbers(&self.states, &mut buffers.state)?;
        reader.numbers(&self.next_states, &mut buffers.next_state)?;
        buffers.executable.clear();
        for &place in &self.executable {
            buffers.executable.push(reader.flag(place)?);
        }
        let option = (self.options.iter().position(|o| o == fields[self.option]))
            .ok_or_else(|| reader.wanted(self.option, &one_of(&self.options)))?;
        let mask = match self.mask {
            Some(place) => Some(reader.mask(place, self.variables.len())?),
            None => None,
        };
        let transition = Transition {
            state: &buffers.state,
            option,
            next_state: &buffers.next_state,
            mask: mask.as_deref(),
            executable: &buffers.executable,
            episode: (fields[self.episode].parse().ok())
                .ok_or_else(|| reader.wanted(self.episode, "a whole number"))?,
            reward: self.reward.map(|place| reader.number(place)).transpose()?,
            goal_achieved: match self.goal_achieved {
                Some(place) => reader.flag(place)?,
                None => false,
            },
        };
        transitions
            .push(&transition)
            .map_err(|error| reader.wanted(self.option, &error.to_string()))
    }
}

#[derive(Debug, Default)]
struct RowBuffers {
    state: Vec<f64>,
    next_state: Vec<f64>,
    executable: Vec<bool>,
}

/// One row, with what its errors need.
struct RowReader<'a> {
    row: usize,
    fields: &'a [&'a str],
    names: &'a [String],
}

impl RowReader<'_> {
    fn wanted(&self, place: usize, wanted: &str) -> ReadError {
        ReadError::Field {
            row: self.row,
            column: self.names[place].clone(),
            found: self.fields[place].to_owned(),
            wanted: wanted.to_owned(),
        }
    }

    fn number(&self, place: usize) -> Result<f64, ReadError> {
        let number = self.fields[place].parse().ok();
        // + 0.0 makes -0 the same point as 0.
        number
            .filter(|x: &f64| x.is_finite())
            .map(|x| x + 0.0)
            .ok_or_else(|| self.wanted(place, "a finite number"))
    }

    fn numbers(&self, places: &[usize], out: &mut Vec<f64>) -> Result<(), ReadError> {
        out.clear();
        for &place in places {
            out.push(self.number(place)?);
        }
        Ok(())
    }

    fn flag(&self, place: usize) -> Result<bool, ReadError> {
        match self.fields[place] {
            "1" | "true" | "True" => Ok(true),
            "0" | "false" | "False" => Ok(false),
            _ => Err(self.wanted(place, "1 or 0")),
        }
    }

    fn mask(&self, place: usize, n_variables: usize) -> Result<Vec<usize>, ReadError> {
        let index = |text: &str| text.parse().ok().filter(|&v: &usize| v < n_variables);
        (self.fields[place].split_ascii_whitespace())
            .map(|text| {
                index(text).ok_or_else(|| {
                    let wanted = format!("indices below {n_variables}, apart by blanks");
                    self.wanted(place, &wanted)
                })
            })
            .collect()
    }
}

/// NAME of a column `prefixNAME`, `prefix:NAME` or `prefix_NAME`; digits may follow the prefix as they are.
fn member(column: &str, prefix: &str) -> Option<String> {
    let rest = column.strip_prefix(prefix)?;
    let name = match rest.strip_prefix([':', '_']) {
        Some(name) => name,
        None if rest.starts_with(|c: char| c.is_ascii_digit()) => rest,
        None => return None,
    };
    (!name.is_empty()).then(|| name.to_owned())
}

fn missing(wanted: &str, names: &[String]) -> ReadError {
    ReadError::MissingColumn {
        wanted: wanted.to_owned(),
        found: one_of(names),
    }
}

fn one_of(names: &[String]) -> String {
    const N_SHOWN: usize = 12;
    let mut shown: Vec<_> = names
        .iter()
        .take(N_SHOWN)
        .map(|n| format!("`{n}`"))
        .collect();
    if names.len() > N_SHOWN {
        shown.push("...".to_owned());
    }
    shown.join(", ")
}

/// `; did you mean ...`, for a name near to a known one.
fn nearest_hint(name: &str) -> String {
    const DISTANCE_MAX: usize = 3;
    let nearest = FIXED
        .iter()
        .map(|known| (strsim::levenshtein(name, known), known))
        .min();
    match nearest {
        Some((distance, known)) if distance <= DISTANCE_MAX => format!("; did you mean `{known}`?"),
        _ => "; known families: `s0`, `n0`, `init0`".to_owned(),
    }
}
