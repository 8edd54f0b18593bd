//! One robot that makes coffee again and again, and the tries that takes.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, TAU};

use factotum_symbols::ApproachRegion;
use factotum_symbols::gaussian_process::{GpError, GpKernel};
use factotum_symbols::navigation_learner::{NavigationLearner, PoseFrame, Weights};
use factotum_worlds::action_map::StandingPlace;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::kitchen::{COFFEE, Kitchen, N_CLASSES, Site};
use super::method::{Chooser, Method, Proposal, Setting};

/// Tries of a step after which a robot that cannot learn better is stopped.
const N_TRIES_MAX: u32 = 1_000;

/// Distances nearer than this are inside the object.
const DISTANCE_MIN_M: f64 = 1e-3;

/// Coffee made once, as a part of a line of the results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Completion {
    /// Where.
    pub kitchen: String,
    /// The tries of each step.
    pub tries: [u32; COFFEE.len()],
    /// How far the robot drove.
    pub travel_m: f64,
    /// Whether it was stopped in a step that did not succeed.
    pub is_stuck: bool,
}

impl Completion {
    /// The tries of all steps.
    #[must_use]
    pub fn n_tries(&self) -> u32 {
        self.tries.iter().sum()
    }
}

/// Makes coffee `n_completions` times, or until it is stuck.
pub(super) fn trial(
    kitchens: &[Kitchen],
    method: Method,
    setting: Setting,
    seed: u64,
    n_completions: usize,
) -> Result<Vec<Completion>, GpError> {
    let order = order(kitchens.len(), setting, seed, n_completions);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    let mut robot = Robot::new(method);
    let mut completions: Vec<Completion> = Vec::with_capacity(n_completions);
    let mut before = None;
    for idx in order {
        let is_new = before.replace(idx) != Some(idx);
        let completion = robot.complete(&kitchens[idx], is_new, &mut rng)?;
        let is_stuck = completion.is_stuck;
        completions.push(completion);
        if is_stuck {
            break;
        }
    }
    Ok(completions)
}

/// The kitchens of the completions. Every method of a seed meets the same ones in the same order.
fn order(n_kitchens: usize, setting: Setting, seed: u64, n_completions: usize) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut order = Vec::with_capacity(n_completions + n_kitchens);
    while order.len() < n_completions {
        let mut round: Vec<usize> = (0..n_kitchens).collect();
        round.shuffle(&mut rng);
        order.extend(round);
    }
    if setting == Setting::Single {
        let first = order[0];
        order.fill(first);
    }
    order.truncate(n_completions);
    order
}

/// What a robot knows.
struct Robot {
    method: Method,
    /// One for each step, or one for all.
    learners: Vec<NavigationLearner>,
    /// Where it failed in this kitchen, for each step.
    failed: Vec<BTreeSet<StandingPlace>>,
}

impl Robot {
    fn new(method: Method) -> Self {
        let frame = method.frame();
        let learners = match method {
            Method::Ours | Method::OursObject => {
                vec![NavigationLearner::shared(frame, COFFEE.len(), N_CLASSES)]
            }
            Method::OursApart => vec![NavigationLearner::alone(frame); COFFEE.len()],
            _ => vec![NavigationLearner::with_kernel(frame, fixed_kernel(frame)); COFFEE.len()],
        };
        Self {
            method,
            learners,
            failed: vec![BTreeSet::new(); COFFEE.len()],
        }
    }

    /// Carries out the plan.
    fn complete(
        &mut self,
        kitchen: &Kitchen,
        is_new: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Completion, GpError> {
        let places: Vec<StandingPlace> = kitchen.map().places().collect();
        if is_new {
            self.failed.iter_mut().for_each(BTreeSet::clear);
        }
        // Each time, the robot comes in anywhere.
        let mut at = places[rng.random_range(0..places.len())];
        let mut completion = Completion {
            kitchen: kitchen.map().scene().to_owned(),
            tries: [0; COFFEE.len()],
            travel_m: 0.0,
            is_stuck: false,
        };
        for idx in 0..COFFEE.len() {
            let site = kitchen.site(idx);
            let proposed = self.proposed(kitchen, site, &places);
            loop {
                if completion.tries[idx] == N_TRIES_MAX {
                    completion.is_stuck = true;
                    return Ok(completion);
                }
                let travel_m = kitchen.map().travel_m(at);
                at = self.choose(idx, kitchen, &proposed, &travel_m, rng)?;
                let way_m = travel_m[at.index()];
                completion.travel_m += if way_m.is_finite() { way_m } else { 0.0 };
                completion.tries[idx] += 1;
                let succeeded = site.feasible.contains(&at);
                self.learn(idx, kitchen, at, succeeded);
                if succeeded {
                    break;
                }
            }
        }
        Ok(completion)
    }

    /// The places that may be tried.
    fn proposed(
        &self,
        kitchen: &Kitchen,
        site: &Site,
        places: &[StandingPlace],
    ) -> Vec<StandingPlace> {
        let within = |radius_m: f64| -> Vec<StandingPlace> {
            // A heading of four is at most an eighth turn from the object.
            let region = ApproachRegion::new([DISTANCE_MIN_M, radius_m], [0.0, TAU], FRAC_PI_4);
            let Ok(region) = region else {
                return Vec::new();
            };
            let contains = |place: &StandingPlace| {
                let world_from_base = kitchen.map().world_from_base(*place);
                region.contains(&site.world_from_object.inv_mul(&world_from_base))
            };
            places.iter().copied().filter(contains).collect()
        };
        let near = match self.method.proposal() {
            Proposal::Random => Vec::new(),
            Proposal::Heuristic { radius_m } => within(radius_m),
            Proposal::Feasible => site.feasible.iter().copied().collect(),
        };
        // Where nothing is near, the object is looked for from everywhere.
        if near.is_empty() {
            places.to_vec()
        } else {
            near
        }
    }

    fn choose(
        &mut self,
        idx: usize,
        kitchen: &Kitchen,
        proposed: &[StandingPlace],
        travel_m: &[f64],
        rng: &mut ChaCha8Rng,
    ) -> Result<StandingPlace, GpError> {
        let world_from_object = kitchen.site(idx).world_from_object;
        let any = |rng: &mut ChaCha8Rng| proposed[rng.random_range(0..proposed.len())];
        match self.method.chooser() {
            Chooser::Any => Ok(any(rng)),
            Chooser::Accepted => loop {
                let place = any(rng);
                let world_from_base = kitchen.map().world_from_base(place);
                let on = COFFEE[idx].on;
                if self.learners[idx].accept(on, &world_from_object, &world_from_base, rng)? {
                    return Ok(place);
                }
            },
            Chooser::Weighed(weights) => {
                self.weigh(idx, kitchen, proposed, travel_m, &weights, rng)
            }
        }
    }

    /// The place worth most of those that did not fail here yet; when all that are proposed failed, of all others.
    fn weigh(
        &mut self,
        idx: usize,
        kitchen: &Kitchen,
        proposed: &[StandingPlace],
        travel_m: &[f64],
        weights: &Weights,
        rng: &mut ChaCha8Rng,
    ) -> Result<StandingPlace, GpError> {
        let map = kitchen.map();
        let world_from_object = kitchen.site(idx).world_from_object;
        let failed = &self.failed[idx];
        let open = |place: &StandingPlace| !failed.contains(place);
        let mut candidates: Vec<_> = proposed.iter().copied().filter(open).collect();
        if candidates.is_empty() {
            candidates = map.places().filter(open).collect();
        }
        // Of places of equal worth, any.
        candidates.shuffle(rng);
        let which = idx.min(self.learners.len() - 1);
        let learner = &mut self.learners[which];
        for place in &candidates {
            learner.see(&world_from_object, &map.world_from_base(*place));
        }
        let mut best: Option<(f64, StandingPlace)> = None;
        for place in candidates {
            let choice = learner.choice(
                COFFEE[idx].on,
                &world_from_object,
                &map.world_from_base(place),
                travel_m[place.index()],
            )?;
            let worth = choice.worth(weights);
            if best.is_none_or(|(most, _)| worth > most) {
                best = Some((worth, place));
            }
        }
        // Where every place of a kitchen failed, none is left that is worth anything.
        Ok(best.map_or(proposed[0], |(_, place)| place))
    }

    fn learn(&mut self, idx: usize, kitchen: &Kitchen, place: StandingPlace, succeeded: bool) {
        let world_from_base = kitchen.map().world_from_base(place);
        let world_from_object = kitchen.site(idx).world_from_object;
        let which = idx.min(self.learners.len() - 1);
        self.learners[which].learn(
            COFFEE[idx].on,
            &world_from_object,
            &world_from_base,
            succeeded,
        );
        if !succeeded {
            self.failed[idx].insert(place);
        }
    }
}

/// σ = ℓ = 1 in metres and degrees, as in the dissertation's code; in the polar frame, which that has not, in metres and
/// radians.
fn fixed_kernel(frame: PoseFrame) -> GpKernel {
    GpKernel {
        amplitude: 1.0,
        lengths: match frame {
            PoseFrame::Polar => vec![1.0; frame.n_variables()],
            _ => vec![1.0, 1.0, 1f64.to_radians()],
        },
    }
}
