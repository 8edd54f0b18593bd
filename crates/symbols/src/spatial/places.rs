//! Navigation symbols from transitions, and which operator needs which.

use std::collections::BTreeMap;

use rand::Rng;

use super::independence::{PlaceSamples, learn_on};
use super::{Independence, SpatialModel, SpatialParams, Verdict};
use crate::factors::Factors;
use crate::operators::{LearnedOperator, OperatorParams, pddl_name};
use crate::partition::{
    LeftOut, LeftOutReason, OutcomeSamples, Partition, PartitionParams, partition_unless,
};
use crate::precondition::{Precondition, PreconditionParams};
use crate::samples::{Distinct, Samples, distance_squared_up_to};
use crate::transitions::Transitions;
use crate::vocabulary::Vocabulary;

/// A navigation symbol σ^o over the variables of the base's pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Its name in PDDL.
    pub name: String,
    /// The option it is for, as its index.
    pub option: usize,
    /// The symbols it is for, where independence fails; none if it is for the option whatever the rest is like.
    pub context: Vec<usize>,
    /// From which places the option can run; its variables are those of the recording.
    pub condition: Precondition,
    /// For each variable of the base's pose, mean and standard deviation of the places from which the option could run.
    pub spread: Vec<(f64, f64)>,
    /// How often the option could run at the places seen, weighted by how likely the symbol is to offer them.
    pub reliability: f64,
}

/// The transitions, with space and without.
pub(crate) struct SpatialData<'a> {
    whole: &'a Transitions,
    rest: Transitions,
    /// The variables of the rest, as the recording counts them.
    rest_variables: Vec<usize>,
    params: &'a SpatialParams,
}

/// A part of the operators that share their places.
struct Group {
    option: usize,
    name: String,
    partitions: Vec<usize>,
    positive: Vec<usize>,
    negative: Vec<usize>,
    verdict: Verdict,
}

/// The navigation symbols to be, and which factors their operators must name.
pub(crate) struct Places {
    groups: Vec<Group>,
    independence: Vec<Independence>,
    /// For each partition, the factors on which its place depends.
    pub(crate) named_factors: Vec<Vec<usize>>,
}

impl<'a> SpatialData<'a> {
    pub(crate) fn new(whole: &'a Transitions, params: &'a SpatialParams) -> Self {
        let rest_variables: Vec<usize> = (0..whole.variables().len())
            .filter(|v| params.variables.binary_search(v).is_err())
            .collect();
        Self {
            whole,
            rest: whole.project(&rest_variables),
            rest_variables,
            params,
        }
    }

    /// The transitions with space projected out.
    pub(crate) fn rest(&self) -> &Transitions {
        &self.rest
    }

    /// The variables of the rest, as the recording counts them.
    pub(crate) fn rest_variables(&self) -> &[usize] {
        &self.rest_variables
    }

    /// Divides the options by what they do to the rest. Effects that places tell apart stay apart, and
    /// their options are named: each of their partitions has places of its own.
    pub(crate) fn partition(
        &self,
        params: &PartitionParams,
        classifier: &PreconditionParams,
        rng: &mut dyn Rng,
    ) -> (Vec<Partition>, Vec<LeftOut>, Vec<usize>) {
        let mut apart = Vec::new();
        let mut are_apart = |option: usize, effects: &[OutcomeSamples]| {
            let is_told =
                (0..effects.len()).any(|e| self.is_told_by_place(effects, e, classifier, rng));
            if is_told {
                apart.push(option);
            }
            is_told
        };
        let (partitions, mut left_out) = partition_unless(&self.rest, params, &mut are_apart);
        left_out = left_out
            .into_iter()
            .flat_map(|l| self.with_moves(l))
            .collect();
        (partitions, left_out, apart)
    }

    /// Whether places tell one effect of an option from its others, far better than chance.
    fn is_told_by_place(
        &self,
        effects: &[OutcomeSamples],
        index: usize,
        params: &PreconditionParams,
        rng: &mut dyn Rng,
    ) -> bool {
        /// Held-out balanced accuracy half way from chance to certainty.
        const SCORE_MIN: f64 = 0.75;
        let others = effects.iter().enumerate().filter(|(e, _)| *e != index);
        let negative: Vec<usize> = others.flat_map(|(_, e)| e.rows.iter().copied()).collect();
        let positive = effects[index].rows.clone();
        let error = 0.5 * (0.25 / positive.len() as f64 + 0.25 / negative.len() as f64).sqrt();
        let learned = learn_on(
            self.whole.states(),
            &self.params.variables,
            (positive, negative),
            params,
            rng,
        );
        (learned.score).is_some_and(|s| s > SCORE_MIN && s - 0.5 > self.params.n_errors * error)
    }

    /// What changed nothing of the rest may have moved the base.
    fn with_moves(&self, left_out: LeftOut) -> Vec<LeftOut> {
        if left_out.reason != LeftOutReason::NoChange {
            return vec![left_out];
        }
        let moved = (0..self.whole.len()).filter(|&i| {
            let is_own = self.whole.option(i) == left_out.option && self.rest.mask(i).is_empty();
            is_own && !self.whole.mask(i).is_empty()
        });
        let n_moved = moved.count();
        let part = |n_rows, reason| LeftOut {
            n_rows,
            reason,
            ..left_out.clone()
        };
        [
            part(n_moved, LeftOutReason::OnlyMoved),
            part(left_out.n_rows - n_moved, LeftOutReason::NoChange),
        ]
        .into_iter()
        .filter(|l| l.n_rows > 0)
        .collect()
    }

    /// The failures that the place does not explain: those whose rest was like in no state that the option ran from,
    /// and those at a place that the option ran from.
    pub(crate) fn unexplained(&self, positive: &[usize], negative: Vec<usize>) -> Vec<usize> {
        let right_rest = self.near(self.rest.states(), None, positive, &negative);
        let place = Some(self.params.variables.as_slice());
        let right_place = self.near(self.whole.states(), place, positive, &negative);
        let explained = right_rest
            .iter()
            .zip(right_place)
            .map(|(rest, place)| *rest && !place);
        (negative.iter().zip(explained))
            .filter(|(_, explained)| !explained)
            .map(|(&row, _)| row)
            .collect()
    }

    /// For each row whether it is within epsilon of one of the positive rows, in the given variables or in all.
    fn near(
        &self,
        states: &Samples,
        variables: Option<&[usize]>,
        positive: &[usize],
        rows: &[usize],
    ) -> Vec<bool> {
        let distinct = |rows: &[usize]| match variables {
            Some(variables) => Distinct::of(&states.project_rows(rows.iter().copied(), variables)),
            None => Distinct::of(&states.select(rows)),
        };
        let limit = self.params.epsilon * self.params.epsilon;
        let (positive, asked) = (distinct(positive), distinct(rows));
        let is_near = |point: &[f64]| {
            let mut positive = positive.points.rows();
            positive.any(|p| distance_squared_up_to(p, point, limit) <= limit)
        };
        let of_point: Vec<bool> = asked.points.rows().map(is_near).collect();
        asked.point_of_row.iter().map(|&p| of_point[p]).collect()
    }

    /// Tests independence for each option, or for each of its partitions where places tell them apart.
    pub(crate) fn places(
        &self,
        partitions: &[Partition],
        apart: &[usize],
        factors: &Factors,
        params: &PreconditionParams,
        rng: &mut dyn Rng,
    ) -> Places {
        let mut places = Places {
            groups: Vec::new(),
            independence: Vec::new(),
            named_factors: vec![Vec::new(); partitions.len()],
        };
        let mut by_group: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (i, partition) in partitions.iter().enumerate() {
            let part = if apart.contains(&partition.option) {
                i
            } else {
                0
            };
            by_group
                .entry((partition.option, part))
                .or_default()
                .push(i);
        }
        for ((option, _), members) in by_group {
            let number = places.groups.iter().filter(|g| g.option == option).count();
            let option_name = pddl_name(&self.whole.options()[option]);
            let name = match apart.contains(&option) {
                true => format!("at-{option_name}-{number}"),
                false => format!("at-{option_name}"),
            };
            let (positive, negative) = self.place_samples(option, &members, partitions, apart);
            let samples = PlaceSamples {
                states: self.whole.states(),
                positive: &positive,
                negative: &negative,
            };
            let (verdict, gain, depends_on) = samples.test(self.params, params, rng);
            let depends_on: Vec<usize> = (depends_on.iter())
                .filter_map(|v| self.rest_variables.binary_search(v).ok())
                .collect();
            for &i in &members {
                places.named_factors[i] = factors.of_variables(&depends_on);
            }
            places.independence.push(Independence {
                option,
                place: name.clone(),
                n_positive: positive.len(),
                n_negative: negative.len(),
                gain,
                verdict,
            });
            places.groups.push(Group {
                option,
                name,
                partitions: members,
                positive,
                negative,
                verdict,
            });
        }
        places
    }

    /// The rows in which the option, or its part, could run, and those in which it could not though the rest was right.
    fn place_samples(
        &self,
        option: usize,
        members: &[usize],
        partitions: &[Partition],
        apart: &[usize],
    ) -> (Vec<usize>, Vec<usize>) {
        let (could, mut could_not): (Vec<usize>, Vec<usize>) =
            (0..self.whole.len()).partition(|&i| self.whole.is_executable(i, option));
        let mut positive = could;
        if apart.contains(&option) {
            positive = members.iter().flat_map(|&m| partitions[m].rows()).collect();
            let others = partitions.iter().enumerate();
            let others = others.filter(|(i, p)| p.option == option && !members.contains(i));
            could_not.extend(others.flat_map(|(_, p)| p.rows()));
        }
        let right_rest = self.near(self.rest.states(), None, &positive, &could_not);
        let negative = could_not.into_iter().zip(right_rest);
        let negative = negative
            .filter(|(_, right)| *right)
            .map(|(row, _)| row)
            .collect();
        (positive, negative)
    }
}

impl Places {
    /// Learns the navigation symbols and gives every operator its own; operators without any are dropped.
    pub(crate) fn learn(
        self,
        data: &SpatialData<'_>,
        partitions: &[Partition],
        operators: &mut Vec<LearnedOperator>,
        vocabulary: &Vocabulary,
        (precondition, told): (&PreconditionParams, &OperatorParams),
        rng: &mut dyn Rng,
    ) -> SpatialModel {
        let mut places: Vec<Place> = Vec::new();
        let n_before = operators.len();
        for group in &self.groups {
            let mut known: BTreeMap<Vec<usize>, Option<usize>> = BTreeMap::new();
            for operator in operators.iter_mut() {
                if !group.partitions.contains(&operator.partition) {
                    continue;
                }
                let context = match group.verdict {
                    Verdict::Fails => operator.precondition.clone(),
                    Verdict::Holds | Verdict::Untested => Vec::new(),
                };
                operator.place = *known.entry(context.clone()).or_insert_with(|| {
                    let number = places
                        .iter()
                        .filter(|p| p.name.starts_with(&group.name))
                        .count();
                    let place =
                        group.place(data, vocabulary, context, number, precondition, rng)?;
                    places.push(place);
                    Some(places.len() - 1)
                });
            }
        }
        operators.retain(|operator| operator.place.is_some());
        for operator in operators.iter_mut() {
            if let Some(place) = operator.place {
                operator.probability *= places[place].reliability;
                operator.run_probability = told.as_told(operator.probability);
            }
            let outcomes = partitions[operator.partition].outcomes.iter();
            for (learned, seen) in operator.outcomes.iter_mut().zip(outcomes) {
                learned.moves_base = seen.rows.iter().any(|&i| {
                    let mask = data.whole.mask(i);
                    mask.iter()
                        .any(|v| data.params.variables.binary_search(v).is_ok())
                });
            }
        }
        SpatialModel {
            places,
            independence: self.independence,
            n_operators_without_place: n_before - operators.len(),
        }
    }
}

impl Group {
    /// The navigation symbol for where some symbols hold; `None` if the option was never seen to be able to run there.
    fn place(
        &self,
        data: &SpatialData<'_>,
        vocabulary: &Vocabulary,
        context: Vec<usize>,
        number: usize,
        params: &PreconditionParams,
        rng: &mut dyn Rng,
    ) -> Option<Place> {
        let limit = data.params.epsilon * data.params.epsilon;
        let holds = |&symbol: &usize, row: usize| {
            let density = &vocabulary.symbols()[symbol].density;
            let state = data.rest.states().row(row);
            let own: Vec<f64> = density.variables().iter().map(|&v| state[v]).collect();
            let mut seen = density.samples().points.rows();
            seen.any(|p| distance_squared_up_to(p, &own, limit) <= limit)
        };
        let in_context = |rows: &[usize]| -> Vec<usize> {
            let mut rows = rows.to_vec();
            rows.retain(|&row| context.iter().all(|symbol| holds(symbol, row)));
            rows
        };
        let (positive, negative) = (in_context(&self.positive), in_context(&self.negative));
        let states = data.whole.states();
        let variables = &data.params.variables;
        let spread = spread(&states.project_rows(positive.iter().copied(), variables))?;
        let rows = (positive.clone(), negative.clone());
        let condition = learn_on(states, variables, rows, params, rng);
        Some(Place {
            name: match context.is_empty() {
                true => self.name.clone(),
                false => format!("{}-{number}", self.name),
            },
            option: self.option,
            reliability: reliability(&condition, states, &positive, &negative),
            context,
            condition,
            spread,
        })
    }
}

/// Mean and standard deviation of each variable; `None` without points.
fn spread(points: &Samples) -> Option<Vec<(f64, f64)>> {
    let n = points.len() as f64;
    let of_variable = |v: usize| {
        let mean = points.rows().map(|row| row[v]).sum::<f64>() / n;
        let squares: f64 = points.rows().map(|row| (row[v] - mean).powi(2)).sum();
        (mean, (squares / n).sqrt())
    };
    (!points.is_empty()).then(|| (0..points.n_variables()).map(of_variable).collect())
}

/// Σ p y / Σ p: the share of successes among places accepted with their probability.
fn reliability(
    condition: &Precondition,
    states: &Samples,
    positive: &[usize],
    negative: &[usize],
) -> f64 {
    let sum = |rows: &[usize]| -> f64 {
        let probability = |&row: &usize| {
            let row = states.row(row);
            let values: Vec<f64> = condition.variables.iter().map(|&v| row[v]).collect();
            condition.probability(&values)
        };
        rows.iter().map(probability).sum()
    };
    let (right, wrong) = (sum(positive), sum(negative));
    right / (right + wrong)
}
