//! Operators: for each partition, the symbols it can run from and those it leaves behind.
//!
//! A precondition classifier looks at some factors. Each choice of one symbol per such factor is an operator if the
//! classifier, on draws from these symbols, says that the partition can run with a mean probability above `low`.
//! Below `high` the operator may fail, with the rest of the probability. An outcome
//! adds the symbols of the factors it changes and deletes the others of these factors: all of them where the
//! precondition does not look at the factor, else the one it asks for. So exactly one symbol of each factor
//! holds in every state. (build_pddl.py of skills-to-symbols; dissertation 2.1.3 and 5.4.)

use rand::Rng;

use crate::factors::Factors;
use crate::partition::Partition;
use crate::precondition::Precondition;
use crate::samples::Samples;
use crate::support_vector::SupportVectorClassifier;
use crate::transitions::Transitions;
use crate::vocabulary::Vocabulary;

/// When symbols make a precondition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorParams {
    /// Probability above which symbols are a precondition; default 0.1 (the reference's `low_threshold`).
    pub probability_low: f64,
    /// Probability from which failure is not worth a word; default 0.95 (the reference's `high_threshold`).
    pub probability_high: f64,
    /// Draws from each symbol; default 100 (the reference's `estimator_samples`).
    pub n_draws: usize,
}

impl Default for OperatorParams {
    fn default() -> Self {
        Self {
            probability_low: 0.1,
            probability_high: 0.95,
            n_draws: 100,
        }
    }
}

impl OperatorParams {
    /// A probability as planners are told it.
    pub(crate) fn as_told(&self, probability: f64) -> f64 {
        if probability < self.probability_high {
            probability
        } else {
            1.0
        }
    }
}

/// A partition from certain symbols.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedOperator {
    /// Its name in PDDL.
    pub name: String,
    /// The partition, as its index.
    pub partition: usize,
    /// The symbols it needs, one a factor.
    pub precondition: Vec<usize>,
    /// How likely it can run where they hold, as the classifier has it.
    pub probability: f64,
    /// How likely as PPDDL has it: 1 from [`OperatorParams::probability_high`] on.
    pub run_probability: f64,
    /// Where the base must be, as a place in [`SpatialModel::places`](crate::spatial::SpatialModel::places); `None` if
    /// space is a variable like any other.
    pub place: Option<usize>,
    /// What may come of it; as many as the partition has.
    pub outcomes: Vec<LearnedOutcome>,
}

/// What may come of an operator that runs.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedOutcome {
    /// How likely, among the outcomes.
    pub probability: f64,
    /// The symbols that hold after it.
    pub adds: Vec<usize>,
    /// The symbols that may have held before and do not after.
    pub deletes: Vec<usize>,
    /// Whether the base may be elsewhere after it; always false if space is a variable like any other.
    pub moves_base: bool,
    /// What it cost on average, if rewards were recorded: the reward's negative, or 0 where it paid.
    pub cost: Option<f64>,
}

/// Symbols with how likely a classifier holds where they do.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Combination {
    /// One symbol a factor.
    pub(crate) symbols: Vec<usize>,
    pub(crate) probability: f64,
}

/// Draws from every symbol, made once.
#[derive(Debug)]
pub(crate) struct SymbolDraws {
    draws: Vec<Samples>,
}

impl SymbolDraws {
    pub(crate) fn new(vocabulary: &Vocabulary, n_draws: usize, rng: &mut dyn Rng) -> Self {
        let draw = |symbol: &crate::vocabulary::Symbol| symbol.density.sample(n_draws, rng);
        Self {
            draws: vocabulary.symbols().iter().map(draw).collect(),
        }
    }
}

/// All choices of a symbol for each factor the condition looks at, with a probability above `low`.
///
/// The kernel of a sum of squares is a product over factors. So the kernel between a symbol's draws and the
/// support vectors is computed once for each symbol, and a combination is a product of these; a beginning
/// that no continuation can bring above `low` is left.
pub(crate) fn combinations(
    condition: &Precondition,
    factors: &Factors,
    vocabulary: &Vocabulary,
    draws: &SymbolDraws,
    low: f64,
) -> Vec<Combination> {
    let Some(classifier) = &condition.classifier else {
        return vec![Combination {
            symbols: Vec::new(),
            probability: 1.0,
        }];
    };
    let choices: Vec<Vec<SymbolKernel>> = factors
        .of_variables(&condition.variables)
        .into_iter()
        .map(|factor| {
            let symbols = vocabulary.of_factor(factor).into_iter();
            let kernel = |symbol| {
                SymbolKernel::new(
                    symbol,
                    vocabulary,
                    &draws.draws[symbol],
                    condition,
                    classifier,
                )
            };
            symbols.map(kernel).collect()
        })
        .collect();
    let n_support = classifier.support().len();
    let n_draws = draws.draws.first().map_or(0, Samples::len);
    let mut search = CombinationSearch {
        classifier,
        choices: &choices,
        low,
        n_support,
        found: Vec::new(),
    };
    search.extend(&mut Vec::new(), &vec![1.0; n_draws * n_support]);
    search.found
}

/// The kernel between the draws from a symbol and the support vectors, in the variables of one factor.
struct SymbolKernel {
    symbol: usize,
    /// By draws.
    values: Vec<f64>,
}

impl SymbolKernel {
    fn new(
        symbol: usize,
        vocabulary: &Vocabulary,
        draws: &Samples,
        condition: &Precondition,
        classifier: &SupportVectorClassifier,
    ) -> Self {
        let own = vocabulary.symbols()[symbol].density.variables();
        // (column in the draws, column in the support vectors) of the variables that both have.
        let columns: Vec<(usize, usize)> = (condition.variables.iter().enumerate())
            .filter_map(|(column, v)| Some((own.binary_search(v).ok()?, column)))
            .collect();
        let gamma = classifier.params().gamma;
        let mut values = Vec::with_capacity(draws.len() * classifier.support().len());
        for draw in draws.rows() {
            for vector in classifier.support().rows() {
                let squared: f64 = columns
                    .iter()
                    .map(|&(from, to)| (draw[from] - vector[to]).powi(2))
                    .sum();
                values.push((-gamma * squared).exp());
            }
        }
        Self { symbol, values }
    }
}

struct CombinationSearch<'a> {
    classifier: &'a SupportVectorClassifier,
    choices: &'a [Vec<SymbolKernel>],
    low: f64,
    n_support: usize,
    found: Vec<Combination>,
}

impl CombinationSearch<'_> {
    /// Goes on with every symbol of the next factor; `kernel` is the product so far.
    fn extend(&mut self, chosen: &mut Vec<usize>, kernel: &[f64]) {
        let choices = self.choices;
        let Some(symbols) = choices.get(chosen.len()) else {
            return;
        };
        let is_last = chosen.len() + 1 == choices.len();
        for choice in symbols {
            let product: Vec<f64> = kernel
                .iter()
                .zip(&choice.values)
                .map(|(a, b)| a * b)
                .collect();
            let probability = self.probability(&product, is_last);
            if probability <= self.low {
                continue;
            }
            chosen.push(choice.symbol);
            if is_last {
                self.found.push(Combination {
                    symbols: chosen.clone(),
                    probability,
                });
            } else {
                self.extend(chosen, &product);
            }
            chosen.pop();
        }
    }

    /// The mean probability over the draws; before the last factor, the most that it can become: the
    /// negative support vectors may yet lose their say, and the positive ones gain none.
    fn probability(&self, kernel: &[f64], is_last: bool) -> f64 {
        let coefficients = self.classifier.coefficients();
        let draws = kernel.chunks_exact(self.n_support);
        let n_draws = draws.len() as f64;
        let of_draw = |row: &[f64]| {
            let terms = row.iter().zip(coefficients);
            let sum: f64 = if is_last {
                terms.map(|(k, c)| k * c).sum()
            } else {
                terms.map(|(k, c)| k * c.max(0.0)).sum()
            };
            self.classifier.probability_of_sum(sum)
        };
        draws.map(of_draw).sum::<f64>() / n_draws
    }
}

/// What operators are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OperatorParts<'a> {
    pub(crate) transitions: &'a Transitions,
    pub(crate) partitions: &'a [Partition],
    /// The precondition of each partition.
    pub(crate) preconditions: &'a [Precondition],
    /// For each partition, factors of which an operator names a symbol even if the precondition does not look at them.
    pub(crate) named_factors: &'a [Vec<usize>],
    /// For each partition and outcome, the symbols it leaves behind.
    pub(crate) effects: &'a [Vec<Vec<usize>>],
    pub(crate) factors: &'a Factors,
    pub(crate) vocabulary: &'a Vocabulary,
}

/// The operators of all partitions.
pub(crate) fn build_operators(
    parts: &OperatorParts<'_>,
    draws: &SymbolDraws,
    params: &OperatorParams,
) -> Vec<LearnedOperator> {
    let OperatorParts {
        transitions,
        partitions,
        factors,
        vocabulary,
        ..
    } = *parts;
    let mut operators = Vec::new();
    for (index, (partition, precondition)) in partitions.iter().zip(parts.preconditions).enumerate()
    {
        let mut looked_at = factors.of_variables(&precondition.variables);
        let mut found = combinations(
            precondition,
            factors,
            vocabulary,
            draws,
            params.probability_low,
        );
        for &factor in &parts.named_factors[index] {
            if !looked_at.contains(&factor) {
                found = with_each_symbol_of(&vocabulary.of_factor(factor), &found);
                looked_at.push(factor);
            }
        }
        let number = partitions[..index]
            .iter()
            .filter(|p| p.option == partition.option)
            .count();
        let option = pddl_name(&transitions.options()[partition.option]);
        for (i, combination) in found.into_iter().enumerate() {
            let outcome = |o: usize| {
                let adds = parts.effects[index][o].clone();
                let mut deletes = Vec::new();
                for factor in factors.of_variables(&partition.outcomes[o].mask) {
                    let is_looked_at = looked_at.contains(&factor);
                    deletes.extend(vocabulary.of_factor(factor).into_iter().filter(|s| {
                        !adds.contains(s) && (!is_looked_at || combination.symbols.contains(s))
                    }));
                }
                LearnedOutcome {
                    probability: partition.probability(o),
                    adds,
                    deletes,
                    moves_base: false,
                    cost: mean_cost(transitions, &partition.outcomes[o].rows),
                }
            };
            operators.push(LearnedOperator {
                name: format!("{option}-partition-{number}-{i}"),
                partition: index,
                outcomes: (0..partition.outcomes.len()).map(outcome).collect(),
                precondition: combination.symbols,
                probability: combination.probability,
                run_probability: params.as_told(combination.probability),
                place: None,
            });
        }
    }
    operators
}

/// Each combination with each of the symbols besides.
fn with_each_symbol_of(symbols: &[usize], combinations: &[Combination]) -> Vec<Combination> {
    let with = |(combination, symbol): (&Combination, &usize)| {
        let mut combination = combination.clone();
        combination.symbols.push(*symbol);
        combination
    };
    (combinations.iter())
        .flat_map(|c| symbols.iter().map(move |s| (c, s)))
        .map(with)
        .collect()
}

/// The mean of what was paid, if every transition has a reward.
fn mean_cost(transitions: &Transitions, rows: &[usize]) -> Option<f64> {
    let rewards: Option<Vec<f64>> = rows.iter().map(|&i| transitions.reward(i)).collect();
    let rewards = rewards.filter(|r| !r.is_empty())?;
    Some((-rewards.iter().sum::<f64>() / rewards.len() as f64).max(0.0))
}

/// The name with what PDDL cannot write replaced.
pub(crate) fn pddl_name(name: &str) -> String {
    let allowed = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' || c == '_' {
            c
        } else {
            '_'
        }
    };
    let name: String = name.chars().map(allowed).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name
    } else {
        format!("option-{name}")
    }
}
