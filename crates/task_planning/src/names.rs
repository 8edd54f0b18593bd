//! PDDL names: what is allowed, how they compare, and the hint given for an unknown one.
//!
//! PDDL names do not differ by case. Names keep the spelling they were declared with, so that people
//! see `CoffeeMachine-60` where the file says so; look-ups fold ASCII case through [`fold`].

/// The name folded for comparison (ASCII lower case).
pub(crate) fn fold(name: &str) -> String {
    name.to_ascii_lowercase()
}

/// Whether `name` can be written as a PDDL name.
///
/// A letter or `_`, then letters, digits, `-` and `_`. PDDL's grammar starts names with a letter; the
/// underscore is accepted because learned files in the wild use it.
pub(crate) fn is_name(name: &str) -> bool {
    let mut chars = name.chars();
    chars
        .next()
        .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

/// `; did you mean ...` or `; known: ...`, to be appended to a message about an unknown name.
pub(crate) fn nearest_hint(name: &str, known: &[String]) -> String {
    const N_SHOWN: usize = 8;
    let nearest = known
        .iter()
        .map(|k| (edit_distance(&fold(name), &fold(k)), k))
        .min()
        .filter(|(distance, _)| *distance <= 2.max(name.len() / 3));
    if let Some((_, k)) = nearest {
        return format!("; did you mean `{k}`?");
    }
    if known.is_empty() {
        return "; none are declared".to_owned();
    }
    let shown: Vec<_> = known
        .iter()
        .take(N_SHOWN)
        .map(|k| format!("`{k}`"))
        .collect();
    let more = if known.len() > N_SHOWN { ", ..." } else { "" };
    format!("; declared: {}{more}", shown.join(", "))
}

/// Levenshtein distance over bytes, one row at a time.
fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.bytes().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_what_pddl_can_write() {
        for good in ["a", "type-1", "CounterTop-13", "symbol_0", "_x"] {
            assert!(is_name(good), "{good}");
        }
        for bad in ["", "1a", "-a", "a b", "?x", "a(b", "ä"] {
            assert!(!is_name(bad), "{bad}");
        }
    }

    #[test]
    fn an_unknown_name_gets_the_nearest_known_one() {
        let known = ["holding".to_owned(), "on-table".to_owned()];
        assert_eq!(nearest_hint("holdin", &known), "; did you mean `holding`?");
        assert_eq!(
            nearest_hint("zzzz", &known),
            "; declared: `holding`, `on-table`"
        );
        assert_eq!(nearest_hint("zzzz", &[]), "; none are declared");
    }
}
