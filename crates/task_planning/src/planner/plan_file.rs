//! The plan files planners write: one `(action object ...)` a line, comments from `;`.

use super::PlannerError;
use crate::operator::GroundAction;

/// Reads a plan file; some planners put a step number `0:` first or leave the parentheses out.
pub(super) fn read_plan(planner: &str, text: &str) -> Result<Vec<GroundAction>, PlannerError> {
    let mut steps = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = line.split(';').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let step = read_step(content).ok_or_else(|| PlannerError::PlanFile {
            planner: planner.to_owned(),
            line: i + 1,
            expected: "`(action object ...)`".to_owned(),
            got: line.to_owned(),
        })?;
        steps.push(step);
    }
    Ok(steps)
}

fn read_step(content: &str) -> Option<GroundAction> {
    let content = match content.split_once(':') {
        Some((number, rest)) if number.trim().parse::<f64>().is_ok() => rest.trim(),
        _ => content,
    };
    let inner = match content.strip_prefix('(') {
        Some(rest) => rest.strip_suffix(')')?,
        None => content,
    };
    if inner.contains(['(', ')']) {
        return None;
    }
    let mut words = inner.split_whitespace();
    Some(GroundAction::new(words.next()?, words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plan_files_of_several_planners_read_alike() {
        let wanted = vec![
            GroundAction::new("go", ["a", "b"]),
            GroundAction::new("stop", [] as [&str; 0]),
        ];
        for text in [
            "(go a b)\n(stop)\n; cost = 2 (unit cost)\n",
            "0: (go a b)\n1: (stop)\n",
            "go a b\n\n  stop  \n",
        ] {
            assert_eq!(read_plan("p", text).unwrap(), wanted, "{text}");
        }
    }

    #[test]
    fn a_line_that_is_no_step_is_named() {
        let error = read_plan("p", "(go a b)\n(go (a) b)\n").unwrap_err();
        insta::assert_snapshot!(error, @"planner `p` wrote a plan that cannot be read: line 2: expected `(action object ...)`, got `(go (a) b)`");
    }
}
