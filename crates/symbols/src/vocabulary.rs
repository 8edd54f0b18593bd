//! The vocabulary: symbols, each a density over one factor, each but once.
//!
//! A symbol is what an outcome leaves a factor in, or what episodes start with. Two densities over the same
//! factor are the same symbol if in each variable their means differ by less than 0.1 and their ranges
//! overlap (the measure of the original paper, as in build_pddl.py of skills-to-symbols, where however the mean is
//! taken over all variables at once). Ranges reach 2.5 bandwidths beyond the samples, the expected extremes of
//! a hundred draws, with which the reference compares; we need none. The samples of equal symbols are pooled.

use rand::Rng;

use crate::density::{BandwidthGrid, KernelDensity};
use crate::factors::Factors;
use crate::samples::Samples;

/// What tells symbols apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EqualityParams {
    /// Difference of means from which two symbols differ; default 0.1, as in the reference.
    pub mean_difference_max: f64,
    /// How far ranges reach beyond the samples; default 2.5 bandwidths.
    pub reach_bandwidths: f64,
}

impl Default for EqualityParams {
    fn default() -> Self {
        Self {
            mean_difference_max: 0.1,
            reach_bandwidths: 2.5,
        }
    }
}

impl EqualityParams {
    /// Whether two densities over the same factor are the same symbol.
    pub fn are_equal(&self, a: &KernelDensity, b: &KernelDensity) -> bool {
        let near = |(a, b): (f64, f64)| (a - b).abs() < self.mean_difference_max;
        let (Some(range_a), Some(range_b)) =
            (a.samples().points.bounds(), b.samples().points.bounds())
        else {
            return false;
        };
        let reach = self.reach_bandwidths * (a.bandwidth() + b.bandwidth());
        let overlap = |v: usize| {
            range_a.min[v] - range_b.max[v] <= reach && range_b.min[v] - range_a.max[v] <= reach
        };
        a.variables() == b.variables()
            && a.mean().into_iter().zip(b.mean()).all(near)
            && (0..a.variables().len()).all(overlap)
    }
}

/// A proposition about one factor: its variables are as this density has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Symbol {
    /// Its name in PDDL.
    pub name: String,
    /// The factor it is about.
    pub factor: usize,
    /// How the factor's variables are spread where it holds.
    pub density: KernelDensity,
}

/// All symbols, in the order they were found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vocabulary {
    symbols: Vec<Symbol>,
}

impl Vocabulary {
    /// The symbols.
    pub fn symbols(&self) -> &[Symbol] {
        &self.symbols
    }

    /// The symbols about a factor, as indices.
    pub fn of_factor(&self, factor: usize) -> Vec<usize> {
        (0..self.symbols.len())
            .filter(|&s| self.symbols[s].factor == factor)
            .collect()
    }
}

/// Collects symbols; equal ones become one.
#[derive(Debug)]
pub(crate) struct VocabularyBuilder<'a> {
    factors: &'a Factors,
    grid: &'a BandwidthGrid,
    equality: EqualityParams,
    symbols: Vec<Symbol>,
    /// All samples of each symbol; its density is of the first of them until the end.
    pooled: Vec<Samples>,
}

impl<'a> VocabularyBuilder<'a> {
    pub(crate) fn new(
        factors: &'a Factors,
        grid: &'a BandwidthGrid,
        equality: EqualityParams,
    ) -> Self {
        Self {
            factors,
            grid,
            equality,
            symbols: Vec::new(),
            pooled: Vec::new(),
        }
    }

    /// The symbol for how these rows of a table of states have a factor.
    pub(crate) fn symbol(
        &mut self,
        factor: usize,
        states: &Samples,
        rows: &[usize],
        rng: &mut dyn Rng,
    ) -> usize {
        let variables = &self.factors.variables()[factor];
        let samples = states.project_rows(rows.iter().copied(), variables);
        let density = KernelDensity::fit(variables, &samples, self.grid, rng);
        let is_equal =
            |s: &Symbol| s.factor == factor && self.equality.are_equal(&s.density, &density);
        if let Some(known) = self.symbols.iter().position(is_equal) {
            samples.rows().for_each(|row| self.pooled[known].push(row));
            return known;
        }
        self.symbols.push(Symbol {
            name: format!("symbol_{}", self.symbols.len()),
            factor,
            density,
        });
        self.pooled.push(samples);
        self.symbols.len() - 1
    }

    /// Fits each symbol to all of its samples.
    pub(crate) fn finish(mut self, rng: &mut dyn Rng) -> Vocabulary {
        for (symbol, samples) in self.symbols.iter_mut().zip(&self.pooled) {
            if samples.len() > symbol.density.samples().n_rows() {
                let variables = &self.factors.variables()[symbol.factor];
                symbol.density = KernelDensity::fit(variables, samples, self.grid, rng);
            }
        }
        Vocabulary {
            symbols: self.symbols,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Two variables, each a factor of its own.
    fn builder_of<'a>(factors: &'a Factors, grid: &'a BandwidthGrid) -> VocabularyBuilder<'a> {
        VocabularyBuilder::new(factors, grid, EqualityParams::default())
    }

    fn states(values: impl IntoIterator<Item = f64>) -> Samples {
        Samples::from_rows(1, values.into_iter().map(|x| [x]))
    }

    #[test]
    fn like_densities_are_one_symbol_with_all_samples() {
        let factors = Factors::new(&[], 1);
        let grid = BandwidthGrid::default();
        let mut builder = builder_of(&factors, &grid);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let spread = |centre: f64| states((0..20).map(move |i| centre + 0.001 * f64::from(i)));
        let rows: Vec<usize> = (0..20).collect();
        let here = builder.symbol(0, &spread(0.3), &rows, &mut rng);
        let near = builder.symbol(0, &spread(0.31), &rows, &mut rng);
        let apart = builder.symbol(0, &spread(0.36), &rows, &mut rng);
        assert_eq!((here, near, apart), (0, 0, 1));
        let vocabulary = builder.finish(&mut rng);
        let n_rows: Vec<_> = vocabulary
            .symbols()
            .iter()
            .map(|s| s.density.samples().n_rows())
            .collect();
        assert_eq!(n_rows, [40, 20]);
        assert_eq!(vocabulary.of_factor(0), [0, 1]);
        assert!(vocabulary.of_factor(1).is_empty());
    }

    #[test]
    fn means_far_apart_differ_even_where_ranges_overlap() {
        let factors = Factors::new(&[], 1);
        let grid = BandwidthGrid::default();
        let mut builder = builder_of(&factors, &grid);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let wide = states((0..30).map(|i| 0.02 * f64::from(i)));
        let low = states((0..30).map(|i| 0.003 * f64::from(i)));
        let rows: Vec<usize> = (0..30).collect();
        assert_eq!(builder.symbol(0, &wide, &rows, &mut rng), 0);
        assert_eq!(builder.symbol(0, &low, &rows, &mut rng), 1);
    }
}
