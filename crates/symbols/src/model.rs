//! The whole way: from transitions to a model to plan with.
//!
//! | stage | what it makes | from |
//! |---|---|---|
//! | partition | [`Partition`]s of the options | masks, end states, start states |
//! | preconditions | a [`Precondition`] for each partition | states it ran from and states it could not run from |
//! | effects | the [`Vocabulary`]: a density for each outcome and factor | end states |
//! | operators | [`LearnedOperator`]s | preconditions on draws from the symbols |
//! | goal | the symbols of the goal | end states where the goal was reached |
//!
//! With [`SpatialParams`], the variables of the base's pose are projected out first, and the preconditions' stage also
//! tests spatial independence; navigation symbols are learned with the operators.
//!
//! The start symbols come first in the vocabulary. A model is kept as a [`ModelRecord`], which becomes PPDDL by
//! [`ModelRecord::domain`] and [`ModelRecord::problem`], and PDDL with costs of -log p by
//! [`determinise`](factotum_task_planning::pddl::determinise).

mod explain;
mod pddl;
mod record;
#[cfg(test)]
mod tests;

pub use explain::{Explanation, OutcomeExplanation};
pub use record::{
    GoalRecord, IndependenceRecord, LeftOutRecord, ModelRecord, NameError, OperatorRecord,
    OutcomeRecord, PartitionRecord, PlaceRecord, SymbolRecord,
};

use std::collections::BTreeMap;

use rand::Rng;

use crate::density::BandwidthGrid;
use crate::factors::Factors;
use crate::operators::{
    Combination, LearnedOperator, OperatorParams, OperatorParts, SymbolDraws, build_operators,
    combinations,
};
use crate::partition::{LeftOut, Partition, PartitionParams, partition};
use crate::precondition::{Precondition, PreconditionParams, learn_classifier, samples_of};
use crate::spatial::{SpatialData, SpatialModel, SpatialParams};
use crate::subgoal::{SubgoalCheck, SubgoalParams, check_subgoal};
use crate::transitions::Transitions;
use crate::vocabulary::{EqualityParams, Vocabulary, VocabularyBuilder};

/// All that learning can be told; every default is the reference's or the dissertation's.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LearnParams {
    /// How options are divided.
    pub partition: PartitionParams,
    /// How preconditions, and the goal, are learned.
    pub precondition: PreconditionParams,
    /// The bandwidths of effect densities.
    pub bandwidths: BandwidthGrid,
    /// What tells symbols apart.
    pub equality: EqualityParams,
    /// When symbols make a precondition.
    pub operator: OperatorParams,
    /// How it is checked that ends do not depend on starts.
    pub subgoal: SubgoalParams,
    /// Learn where the base must be apart from the rest, as in 5.3; without it, its pose is a variable like any other.
    pub spatial: Option<SpatialParams>,
}

/// The stages of learning, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Options are divided.
    Partition,
    /// Preconditions are learned.
    Preconditions,
    /// Effects are learned and become symbols.
    Effects,
    /// Symbols become operators.
    Operators,
    /// The goal's symbols are found.
    Goal,
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Partition => "partition",
            Self::Preconditions => "preconditions",
            Self::Effects => "effects",
            Self::Operators => "operators",
            Self::Goal => "goal",
        })
    }
}

/// A model in numbers, as programs report it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Symbols in the vocabulary.
    pub symbols: usize,
    /// Operators.
    pub operators: usize,
    /// The variables of each factor, as the recording counts them.
    pub factors: Vec<Vec<usize>>,
    /// Wall time of each stage by its name; the caller's clock, since learning has none.
    pub stage_secs: BTreeMap<String, f64>,
}

/// The symbols of the goal.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedGoal {
    /// One symbol for each factor the goal hangs on.
    pub symbols: Vec<usize>,
    /// How likely the goal is reached where they hold.
    pub probability: f64,
    /// What tells states with the goal reached from others.
    pub condition: Precondition,
}

/// What was learned from transitions.
#[derive(Debug, Clone, PartialEq)]
pub struct SymbolicModel {
    variables: Vec<String>,
    /// The variables as the recording counts them.
    recorded_as: Vec<usize>,
    /// The names of the variables of the base's pose, if space was learned apart.
    spatial_variables: Vec<String>,
    options: Vec<String>,
    partitions: Vec<Partition>,
    left_out: Vec<LeftOut>,
    preconditions: Vec<Precondition>,
    factors: Factors,
    vocabulary: Vocabulary,
    operators: Vec<LearnedOperator>,
    start: Vec<usize>,
    goal: Option<LearnedGoal>,
    space: Option<SpatialModel>,
    subgoals: Vec<Vec<Option<SubgoalCheck>>>,
}

impl SymbolicModel {
    /// Learns from transitions; `on_stage` is told of each stage when it is done.
    ///
    /// Few or poor data give a small model, down to one without operators or without a goal.
    pub fn learn(
        transitions: &Transitions,
        params: &LearnParams,
        rng: &mut dyn Rng,
        on_stage: &mut dyn FnMut(Stage),
    ) -> Self {
        let spatial_variables = (params.spatial.iter().flat_map(|s| &s.variables))
            .map(|&v| transitions.variables()[v].clone())
            .collect();
        let spatial = (params.spatial.as_ref()).map(|s| SpatialData::new(transitions, s));
        let transitions = spatial.as_ref().map_or(transitions, SpatialData::rest);
        let (partitions, left_out, apart) = match &spatial {
            None => {
                let (partitions, left_out) = partition(transitions, &params.partition);
                (partitions, left_out, Vec::new())
            }
            Some(data) => data.partition(&params.partition, &params.precondition, rng),
        };
        on_stage(Stage::Partition);
        let precondition = |i: usize| {
            let (positive, mut negative) = samples_of(transitions, &partitions, i);
            if let Some(data) = &spatial {
                negative = data.unexplained(&positive, negative);
            }
            let states = transitions.states();
            learn_classifier(states, positive, negative, &params.precondition, rng)
        };
        let preconditions: Vec<_> = (0..partitions.len()).map(precondition).collect();
        let factors = Factors::new(&partitions, transitions.variables().len());
        let places = (spatial.as_ref())
            .map(|data| data.places(&partitions, &apart, &factors, &params.precondition, rng));
        on_stage(Stage::Preconditions);
        let mut builder = VocabularyBuilder::new(&factors, &params.bandwidths, params.equality);
        let start = start_symbols(transitions, &factors, &mut builder, rng);
        let effects = effect_symbols(transitions, &partitions, &factors, &mut builder, rng);
        let vocabulary = builder.finish(rng);
        on_stage(Stage::Effects);
        let draws = SymbolDraws::new(&vocabulary, params.operator.n_draws, rng);
        let none_named = vec![Vec::new(); partitions.len()];
        let parts = OperatorParts {
            transitions,
            partitions: &partitions,
            preconditions: &preconditions,
            named_factors: places.as_ref().map_or(&none_named, |p| &p.named_factors),
            effects: &effects,
            factors: &factors,
            vocabulary: &vocabulary,
        };
        let mut operators = build_operators(&parts, &draws, &params.operator);
        let space = spatial.as_ref().zip(places).map(|(data, places)| {
            let params = (&params.precondition, &params.operator);
            places.learn(data, &partitions, &mut operators, &vocabulary, params, rng)
        });
        on_stage(Stage::Operators);
        let goal = learn_goal(transitions, &factors, &vocabulary, &draws, params, rng);
        let check = |partition: &Partition| {
            let outcomes = partition.outcomes.iter();
            outcomes
                .map(|outcome| check_subgoal(transitions, outcome, &params.subgoal, rng))
                .collect()
        };
        let subgoals = partitions.iter().map(check).collect();
        on_stage(Stage::Goal);
        Self {
            variables: transitions.variables().to_vec(),
            recorded_as: match &spatial {
                Some(data) => data.rest_variables().to_vec(),
                None => (0..transitions.variables().len()).collect(),
            },
            spatial_variables,
            options: transitions.options().to_vec(),
            partitions,
            left_out,
            preconditions,
            factors,
            vocabulary,
            operators,
            start,
            goal,
            space,
            subgoals,
        }
    }

    /// The model in numbers, with the time that each stage took.
    pub fn summary(&self, stage_secs: &[(Stage, f64)]) -> Summary {
        let recorded = |factor: &Vec<usize>| factor.iter().map(|&v| self.recorded_as[v]).collect();
        let stage = |(stage, secs): &(Stage, f64)| (stage.to_string(), *secs);
        Summary {
            symbols: self.vocabulary.symbols().len(),
            operators: self.operators.len(),
            factors: self.factors.variables().iter().map(recorded).collect(),
            stage_secs: stage_secs.iter().map(stage).collect(),
        }
    }

    /// The parts of the options.
    pub fn partitions(&self) -> &[Partition] {
        &self.partitions
    }

    /// The transitions that were of no use, and why.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// The precondition of each partition.
    pub fn preconditions(&self) -> &[Precondition] {
        &self.preconditions
    }

    /// The state variables that change together.
    pub fn factors(&self) -> &Factors {
        &self.factors
    }

    /// The symbols.
    pub fn vocabulary(&self) -> &Vocabulary {
        &self.vocabulary
    }

    /// The operators.
    pub fn operators(&self) -> &[LearnedOperator] {
        &self.operators
    }

    /// The symbols that hold at the start, one a factor.
    pub fn start(&self) -> &[usize] {
        &self.start
    }

    /// What was learned about space, if that was to be learned apart.
    pub fn space(&self) -> Option<&SpatialModel> {
        self.space.as_ref()
    }

    /// For each partition and outcome, whether its end depends on its start; `None` where too little was seen.
    pub fn subgoals(&self) -> &[Vec<Option<SubgoalCheck>>] {
        &self.subgoals
    }

    /// The goal; `None` if it was never reached or no symbols stand for it.
    pub fn goal(&self) -> Option<&LearnedGoal> {
        self.goal.as_ref()
    }
}

/// How the episodes start, one symbol a factor.
fn start_symbols(
    transitions: &Transitions,
    factors: &Factors,
    builder: &mut VocabularyBuilder<'_>,
    rng: &mut dyn Rng,
) -> Vec<usize> {
    let starts = transitions.starts();
    if starts.is_empty() {
        return Vec::new();
    }
    (0..factors.variables().len())
        .map(|factor| builder.symbol(factor, transitions.states(), &starts, rng))
        .collect()
}

/// For each partition and outcome, the symbols it leaves behind, one for each factor it changes.
fn effect_symbols(
    transitions: &Transitions,
    partitions: &[Partition],
    factors: &Factors,
    builder: &mut VocabularyBuilder<'_>,
    rng: &mut dyn Rng,
) -> Vec<Vec<Vec<usize>>> {
    let mut effects = Vec::with_capacity(partitions.len());
    for partition in partitions {
        let mut of_partition = Vec::with_capacity(partition.outcomes.len());
        for outcome in &partition.outcomes {
            let symbols: Vec<usize> = (factors.of_variables(&outcome.mask).into_iter())
                .map(|f| builder.symbol(f, transitions.next_states(), &outcome.rows, rng))
                .collect();
            of_partition.push(symbols);
        }
        effects.push(of_partition);
    }
    effects
}

/// The symbols that stand for the goal best.
fn learn_goal(
    transitions: &Transitions,
    factors: &Factors,
    vocabulary: &Vocabulary,
    draws: &SymbolDraws,
    params: &LearnParams,
    rng: &mut dyn Rng,
) -> Option<LearnedGoal> {
    let (reached, not_reached): (Vec<usize>, Vec<usize>) =
        (0..transitions.len()).partition(|&i| transitions.goal_achieved(i));
    let condition = learn_classifier(
        transitions.next_states(),
        reached,
        not_reached,
        &params.precondition,
        rng,
    );
    condition.classifier.as_ref()?;
    let found = combinations(&condition, factors, vocabulary, draws, 0.0);
    let mut best: Option<Combination> = None;
    for combination in found {
        if best
            .as_ref()
            .is_none_or(|b| combination.probability > b.probability)
        {
            best = Some(combination);
        }
    }
    best.map(|best| LearnedGoal {
        symbols: best.symbols,
        probability: best.probability,
        condition,
    })
}
