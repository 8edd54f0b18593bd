//! Reading TOML that people edit: unknown keys are errors that name the nearest known one.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::DescriptionError;

/// Reads a TOML file into `T`.
///
/// `T` should carry `#[serde(deny_unknown_fields)]`, so that a misspelt key is refused instead of ignored.
///
/// # Errors
/// [`DescriptionError::Io`] if the file cannot be read, [`DescriptionError::UnknownKey`] for a key `T` does not know,
/// [`DescriptionError::Syntax`] for everything else that is not of the wanted form.
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T, DescriptionError> {
    let text = std::fs::read_to_string(path).map_err(|source| DescriptionError::Io {
        path: path.to_owned(),
        source,
    })?;
    parse_toml(&text, path)
}

/// Reads TOML text into `T`; `path` is the file that errors name.
///
/// # Errors
/// Those of [`read_toml`], but for `Io`.
pub fn parse_toml<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, DescriptionError> {
    toml::from_str(text).map_err(|error| explain(path, text, &error))
}

/// The candidate most like `name`, if any is near enough to be a slip of the keyboard.
pub fn nearest_name<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    /// Below this Jaro-Winkler similarity a suggestion confuses more than it helps.
    const SIMILARITY_MIN: f64 = 0.7;
    candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(similarity, _)| *similarity >= SIMILARITY_MIN)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// Turns serde's complaint into ours. serde reports an unknown key only as text:
/// "unknown field `x`, expected one of `a`, `b`".
fn explain(path: &Path, text: &str, error: &toml::de::Error) -> DescriptionError {
    let line = error
        .span()
        .map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
    let message = error.message();
    if let Some(rest) = message.strip_prefix("unknown field ") {
        let mut quoted = rest.split('`').skip(1).step_by(2);
        let key = quoted.next().unwrap_or_default().to_owned();
        let nearest = nearest_name(&key, quoted).map(str::to_owned);
        return DescriptionError::UnknownKey {
            path: path.to_owned(),
            line,
            key,
            nearest,
        };
    }
    let place = line
        .map(|line| format!("line {line}: "))
        .unwrap_or_default();
    DescriptionError::Syntax {
        path: path.to_owned(),
        message: format!("{place}{message}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Raw {
        #[expect(dead_code, reason = "only its name matters here")]
        footprint_radius_m: f64,
    }

    fn error_of(text: &str) -> String {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("robot.toml");
        std::fs::write(&path, text).unwrap();
        let error = read_toml::<Raw>(&path).unwrap_err().to_string();
        error.replace(&path.display().to_string(), "robot.toml")
    }

    #[test]
    fn a_misspelt_key_names_the_nearest() {
        insta::assert_snapshot!(error_of("\nfootprint_radius = 0.3\n"),
            @"`robot.toml`:2: unknown key `footprint_radius`; did you mean `footprint_radius_m`?");
    }

    #[test]
    fn a_wrong_type_says_line_found_and_wanted() {
        insta::assert_snapshot!(error_of("footprint_radius_m = \"wide\"\n"),
            @r#"`robot.toml`: line 1: invalid type: string "wide", expected f64"#);
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = read_toml::<Raw>(Path::new("no/such/robot.toml")).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("cannot read `no/such/robot.toml`"),
            "{error}"
        );
    }
}
