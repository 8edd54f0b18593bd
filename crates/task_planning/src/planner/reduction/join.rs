//! Finding the arguments of actions by joining their preconditions with reached facts.

use std::collections::HashMap;

use super::FactId;
use super::facts::Row;

/// An argument of a precondition atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arg {
    /// A parameter, by its index.
    Parameter(usize),
    /// An object, by its index.
    Object(u32),
}

/// A positive precondition atom.
#[derive(Debug, Clone)]
pub(super) struct Pattern {
    pub(super) predicate: u32,
    pub(super) args: Vec<Arg>,
}

/// The facts reached so far, in the order they were reached, with indices for the join.
#[derive(Debug, Default)]
pub(super) struct Reached {
    /// Rows with their fact's index.
    rows: Vec<(Row, FactId)>,
    by_predicate: HashMap<u32, Vec<usize>>,
    by_argument: HashMap<(u32, usize, u32), Vec<usize>>,
}

impl Reached {
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn push(&mut self, row: Row, id: FactId) {
        let at = self.rows.len();
        self.by_predicate.entry(row[0]).or_default().push(at);
        for (position, object) in row[1..].iter().enumerate() {
            self.by_argument
                .entry((row[0], position, *object))
                .or_default()
                .push(at);
        }
        self.rows.push((row, id));
    }

    /// The shortest list of facts that could match the pattern.
    fn candidates(&self, pattern: &Pattern, binding: &[Option<u32>]) -> &[usize] {
        let none: &[usize] = &[];
        let all = self
            .by_predicate
            .get(&pattern.predicate)
            .map_or(none, Vec::as_slice);
        let bound = pattern
            .args
            .iter()
            .enumerate()
            .filter_map(|(position, arg)| {
                let object = match arg {
                    Arg::Object(object) => Some(*object),
                    Arg::Parameter(parameter) => binding[*parameter],
                }?;
                let key = (pattern.predicate, position, object);
                Some(self.by_argument.get(&key).map_or(none, Vec::as_slice))
            });
        bound
            .chain([all])
            .min_by_key(|list| list.len())
            .unwrap_or(none)
    }
}

/// One operator's join.
#[derive(Debug)]
pub(super) struct Join<'a> {
    pub(super) patterns: &'a [Pattern],
    pub(super) reached: &'a Reached,
    /// Facts from this one on are new in this round.
    pub(super) first_new: usize,
}

impl Join<'_> {
    /// Calls `found` for every binding that matches all patterns and uses a new fact; parameters that
    /// no pattern mentions stay unbound. Stops when `found` returns false.
    pub(super) fn run(
        &self,
        n_parameters: usize,
        found: &mut impl FnMut(&[Option<u32>]) -> bool,
    ) -> bool {
        // The first new fact among the patterns is at `pivot`: so each binding comes up once.
        (0..self.patterns.len()).all(|pivot| {
            let binding = vec![None; n_parameters];
            let mut left: Vec<usize> = (0..self.patterns.len()).collect();
            self.extend(pivot, pivot, &mut left, &binding, found)
        })
    }

    /// Matches pattern `next`, then the rest.
    fn extend(
        &self,
        pivot: usize,
        next: usize,
        left: &mut Vec<usize>,
        binding: &[Option<u32>],
        found: &mut impl FnMut(&[Option<u32>]) -> bool,
    ) -> bool {
        let pattern = &self.patterns[next];
        left.retain(|i| *i != next);
        let range = match next.cmp(&pivot) {
            std::cmp::Ordering::Less => 0..self.first_new,
            std::cmp::Ordering::Equal => self.first_new..usize::MAX,
            std::cmp::Ordering::Greater => 0..usize::MAX,
        };
        for &at in self.reached.candidates(pattern, binding) {
            if !range.contains(&at) {
                continue;
            }
            let mut extended = binding.to_vec();
            if !matches(pattern, &self.reached.rows[at].0, &mut extended) {
                continue;
            }
            let go_on = match self.most_bound(left, &extended) {
                None => found(&extended),
                Some(then) => self.extend(pivot, then, &mut left.clone(), &extended, found),
            };
            if !go_on {
                return false;
            }
        }
        true
    }

    /// The pattern with the fewest candidates.
    fn most_bound(&self, left: &[usize], binding: &[Option<u32>]) -> Option<usize> {
        left.iter()
            .copied()
            .min_by_key(|i| self.reached.candidates(&self.patterns[*i], binding).len())
    }
}

fn matches(pattern: &Pattern, row: &Row, binding: &mut [Option<u32>]) -> bool {
    pattern
        .args
        .iter()
        .zip(&row[1..])
        .all(|(arg, object)| match arg {
            Arg::Object(wanted) => wanted == object,
            Arg::Parameter(parameter) => *binding[*parameter].get_or_insert(*object) == *object,
        })
}
