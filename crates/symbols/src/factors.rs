//! Factors: the state variables in groups that always change together.
//!
//! Two variables are of one factor if the same outcomes of the same partitions change them (Konidaris,
//! Kaelbling & Lozano-Perez, JAIR 61, 2018). Then a state is one value of each factor, a symbol is about one factor,
//! and an outcome replaces the symbols of the factors it changes. What nothing changes is one factor too.

use std::collections::BTreeMap;

use crate::partition::Partition;

/// The factors, by their first variables; each is ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Factors {
    variables: Vec<Vec<usize>>,
    factor_of: Vec<usize>,
}

impl Factors {
    /// Groups `n_variables` variables by what changes them.
    pub fn new(partitions: &[Partition], n_variables: usize) -> Self {
        let mut changed_by: Vec<Vec<usize>> = vec![Vec::new(); n_variables];
        for (i, outcome) in partitions.iter().flat_map(|p| &p.outcomes).enumerate() {
            for &variable in &outcome.mask {
                changed_by[variable].push(i);
            }
        }
        let mut known: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        let mut variables: Vec<Vec<usize>> = Vec::new();
        let mut factor_of = Vec::with_capacity(n_variables);
        for (variable, changed_by) in changed_by.into_iter().enumerate() {
            let factor = *known.entry(changed_by).or_insert_with(|| {
                variables.push(Vec::new());
                variables.len() - 1
            });
            variables[factor].push(variable);
            factor_of.push(factor);
        }
        Self {
            variables,
            factor_of,
        }
    }

    /// The variables of each factor.
    pub fn variables(&self) -> &[Vec<usize>] {
        &self.variables
    }

    /// The factors that hold any of the variables, ascending.
    pub fn of_variables(&self, variables: &[usize]) -> Vec<usize> {
        let mut factors: Vec<usize> = variables.iter().map(|&v| self.factor_of[v]).collect();
        factors.sort_unstable();
        factors.dedup();
        factors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partition::OutcomeSamples;

    #[test]
    fn variables_that_change_together_are_one_factor() {
        let outcome = |mask: &[usize]| OutcomeSamples {
            mask: mask.to_vec(),
            rows: vec![0],
        };
        let partitions = [
            Partition {
                option: 0,
                outcomes: vec![outcome(&[0]), outcome(&[0, 3, 4])],
            },
            Partition {
                option: 1,
                outcomes: vec![outcome(&[1])],
            },
        ];
        let factors = Factors::new(&partitions, 6);
        assert_eq!(
            factors.variables(),
            [vec![0], vec![1], vec![2, 5], vec![3, 4]]
        );
        assert_eq!(factors.of_variables(&[4, 0, 3]), [0, 3]);
        assert!(factors.of_variables(&[]).is_empty());
    }
}
