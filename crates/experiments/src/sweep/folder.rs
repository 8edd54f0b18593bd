//! The folder of a sweep: of which command its results are, and the results, a line each.

use std::io;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::SweepError;
use crate::storage::{self, StorageError};

/// Name of the file of results in a sweep's folder.
pub const RESULTS_NAME: &str = "results.jsonl";

/// Name of the file that says of which command the results are.
pub(super) const COMMAND_NAME: &str = "sweep.json";

/// The command of a sweep, but for what differs from run to run. The program is left out: it may have been built anew, or moved.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepCommand {
    arguments: Vec<String>,
}

/// Makes the folder a sweep's with these arguments, or checks that it is one, and returns the results in it.
pub(super) fn open<O: DeserializeOwned>(
    folder: &Path,
    arguments: &[String],
) -> Result<Vec<O>, SweepError> {
    std::fs::create_dir_all(folder).map_err(|error| StorageError::writing(folder, error))?;
    let results_file = folder.join(RESULTS_NAME);
    let command_file = folder.join(COMMAND_NAME);
    match read_if_there(&command_file)? {
        Some(text) => {
            let there: SweepCommand =
                serde_json::from_str(&text).map_err(|source| SweepError::Command {
                    file: command_file,
                    source,
                })?;
            if there.arguments != arguments {
                let (there, here) = difference(&there.arguments, arguments);
                return Err(SweepError::OtherCommand {
                    folder: folder.to_path_buf(),
                    there: there.to_vec(),
                    here: here.to_vec(),
                });
            }
        }
        None if results_file.exists() => {
            return Err(SweepError::NoCommand {
                folder: folder.to_path_buf(),
            });
        }
        None => {
            let command = SweepCommand {
                arguments: arguments.to_vec(),
            };
            let bytes = serde_json::to_vec_pretty(&command)
                .map_err(|error| StorageError::writing(&command_file, error.into()))?;
            storage::write_atomically(&command_file, &bytes)?;
        }
    }
    storage::keep_whole_lines(&results_file)?;
    if results_file.exists() {
        read_results(&results_file)
    } else {
        Ok(Vec::new())
    }
}

/// The results in a file of them, a line each.
///
/// # Errors
/// [`SweepError::Storage`] if it cannot be read, and [`SweepError::Result`] for a line that is not such a result.
pub fn read_results<O: DeserializeOwned>(file: &Path) -> Result<Vec<O>, SweepError> {
    let text = std::fs::read_to_string(file).map_err(|error| StorageError::reading(file, error))?;
    let parse = |(idx, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|source| SweepError::Result {
            file: file.to_path_buf(),
            line: idx + 1,
            source,
        })
    };
    text.lines().enumerate().map(parse).collect()
}

/// Appends a result.
pub(super) fn keep(folder: &Path, result: &impl Serialize) -> Result<(), StorageError> {
    let file = folder.join(RESULTS_NAME);
    let line = serde_json::to_string(result)
        .map_err(|error| StorageError::writing(&file, error.into()))?;
    storage::append_line(&file, &line)
}

fn read_if_there(file: &Path) -> Result<Option<String>, StorageError> {
    match std::fs::read_to_string(file) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(StorageError::reading(file, error)),
    }
}

/// What lies between the common beginning and the common end of two commands. The name of an option stays with its
/// value.
fn difference<'a>(there: &'a [String], here: &'a [String]) -> (&'a [String], &'a [String]) {
    let n_same = |pairs: &mut dyn Iterator<Item = (&String, &String)>| {
        pairs.take_while(|(there, here)| there == here).count()
    };
    let n_front = n_same(&mut there.iter().zip(here));
    let n_option = there[..n_front]
        .last()
        .filter(|word| word.starts_with("--"))
        .map_or(0, |_| 1);
    let (there_rest, here_rest) = (&there[n_front..], &here[n_front..]);
    let n_back = n_same(&mut there_rest.iter().rev().zip(here_rest.iter().rev()));
    (
        &there[n_front - n_option..there.len() - n_back],
        &here[n_front - n_option..here.len() - n_back],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_told_with_its_option() {
        let check = |there: &str, here: &str, wanted: (&str, &str)| {
            let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
            let (there, here) = (words(there), words(here));
            let (there, here) = difference(&there, &here);
            assert_eq!(
                (there.join(" "), here.join(" ")),
                (wanted.0.into(), wanted.1.into())
            );
        };
        check(
            "run --goal faucet --fault slip",
            "run --goal light --fault slip",
            ("--goal faucet", "--goal light"),
        );
        check("run a --fault slip", "run a", ("--fault slip", ""));
        check(
            "run a",
            "run a --fault slip --robot movo",
            ("", "--fault slip --robot movo"),
        );
        check("run a a", "run a", ("a", ""));
    }
}
