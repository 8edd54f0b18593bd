//! Learning navigation symbols from tries, one after the other.
//!
//! A try is a base pose, the pose of the object it was for, a skill, and whether the skill ran. The symbol σ^o is a
//! Gaussian process classifier (dissertation 5.4) over the base's pose as a [`PoseFrame`] sees it: in the map, where it
//! is of this home alone, or relative to the object, where it moves with the object to other homes.
//!
//! Where we differ: skills may [share](NavigationLearner::shared) one process. Which skill and which class of objects a try
//! is of are then variables like the place, so that what is known of one skill is what another begins with, and
//! their lengths say how alike skills are. Tries from earlier homes stay, and are the prior for the next.
//!
//! Two ways to choose the next try: the dissertation's, which proposes poses and [accepts](NavigationLearner::accept) each with
//! its probability; and [`Choice`], which weighs how likely a try succeeds, what it teaches, and the way to it.

mod choice;
mod pose_frame;
#[cfg(test)]
mod tests;

use factotum_geometry::Pose2;
use rand::{Rng, RngExt as _};

pub use choice::{Choice, Weights};
pub use pose_frame::PoseFrame;

use crate::gaussian_process::{GpClassifier, GpError, GpKernel, GpPrior};
use crate::samples::Samples;

/// What a skill is, and what it acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkillOnClass {
    /// Index of the skill.
    pub skill: usize,
    /// Index of the class of objects.
    pub class: usize,
}

/// How the process comes to its kernel.
#[derive(Debug, Clone, PartialEq)]
enum Kernel {
    /// It is given.
    Given(GpKernel),
    /// It is learned. Lengths of places begin at the spread of what could be tried.
    Learned {
        n_skills: usize,
        n_classes: usize,
        /// Sums over all places that could have been tried.
        seen: Seen,
    },
}

/// The places that could have been tried so far.
#[derive(Debug, Clone, PartialEq, Default)]
struct Seen {
    n: f64,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl Seen {
    fn add(&mut self, place: &[f64]) {
        self.sums.resize(place.len(), 0.0);
        self.squares.resize(place.len(), 0.0);
        self.n += 1.0;
        for ((sum, square), x) in self.sums.iter_mut().zip(&mut self.squares).zip(place) {
            *sum += x;
            *square += x * x;
        }
    }

    /// Standard deviations of `n_variables`; 1 for what does not vary, or was not seen.
    fn spreads(&self, n_variables: usize) -> impl Iterator<Item = f64> {
        (0..n_variables).map(|i| {
            let (sum, square) = self
                .sums
                .get(i)
                .zip(self.squares.get(i))
                .unwrap_or((&0.0, &0.0));
            let variance = square / self.n - (sum / self.n).powi(2);
            if variance > 1e-12 {
                variance.sqrt()
            } else {
                1.0
            }
        })
    }
}

/// Navigation symbols as they are learned.
#[derive(Debug, Clone, PartialEq)]
pub struct NavigationLearner {
    frame: PoseFrame,
    kernel: Kernel,
    points: Samples,
    succeeded: Vec<bool>,
    /// The symbol, and of how many tries it is.
    fitted: Option<(usize, GpClassifier)>,
}

impl NavigationLearner {
    /// Of one skill, with a kernel that stays as it is.
    pub fn with_kernel(frame: PoseFrame, kernel: GpKernel) -> Self {
        Self {
            points: Samples::new(kernel.lengths.len()),
            kernel: Kernel::Given(kernel),
            frame,
            succeeded: Vec::new(),
            fitted: None,
        }
    }

    /// Of so many skills on so many classes of objects, with one kernel that is learned.
    pub fn shared(frame: PoseFrame, n_skills: usize, n_classes: usize) -> Self {
        Self {
            points: Samples::new(frame.n_variables() + n_skills + n_classes),
            kernel: Kernel::Learned {
                n_skills,
                n_classes,
                seen: Seen::default(),
            },
            frame,
            succeeded: Vec::new(),
            fitted: None,
        }
    }

    /// Of one skill on one class, with a kernel that is learned.
    pub fn alone(frame: PoseFrame) -> Self {
        Self::shared(frame, 0, 0)
    }

    /// How many tries it was told of.
    pub fn n_tries(&self) -> usize {
        self.succeeded.len()
    }

    /// Tells it of places that can be tried.
    pub fn see(&mut self, world_from_object: &Pose2, world_from_base: &Pose2) {
        if let Kernel::Learned { seen, .. } = &mut self.kernel {
            seen.add(&self.frame.variables(world_from_object, world_from_base));
        }
    }

    /// Tells it of a try.
    pub fn learn(
        &mut self,
        skill: SkillOnClass,
        world_from_object: &Pose2,
        world_from_base: &Pose2,
        succeeded: bool,
    ) {
        let point = self.point(skill, world_from_object, world_from_base);
        self.points.push(&point);
        self.succeeded.push(succeeded);
    }

    /// The variables of a try: the place, then one for each skill and class, 1 for its own and 0 for all others.
    fn point(
        &self,
        skill: SkillOnClass,
        world_from_object: &Pose2,
        world_from_base: &Pose2,
    ) -> Vec<f64> {
        let mut point = self.frame.variables(world_from_object, world_from_base);
        if let Kernel::Learned {
            n_skills,
            n_classes,
            ..
        } = self.kernel
        {
            let one_of = |n: usize, own: usize| (0..n).map(move |i| f64::from(u8::from(i == own)));
            point.extend(one_of(n_skills, skill.skill));
            point.extend(one_of(n_classes, skill.class));
        }
        point
    }

    /// The symbol, fitted to the tries so far. Of more than 32 tries the last few may be left out, one in 32 at most: a
    /// fit takes the longer the more tries there are, and a single one tells the less.
    ///
    /// # Errors
    /// A pose that is not finite was learned from.
    pub fn symbol(&mut self) -> Result<&GpClassifier, GpError> {
        let n = self.n_tries();
        let fitted = match self.fitted.take() {
            Some((of, symbol)) if n - of <= of / N_TRIES_A_FIT => (of, symbol),
            _ => (n, self.fit()?),
        };
        Ok(&self.fitted.insert(fitted).1)
    }

    fn fit(&self) -> Result<GpClassifier, GpError> {
        match &self.kernel {
            Kernel::Given(kernel) => {
                GpClassifier::with_kernel(&self.points, &self.succeeded, kernel.clone())
            }
            Kernel::Learned {
                n_skills,
                n_classes,
                seen,
            } => {
                let prior = GpPrior::default();
                let spreads = seen.spreads(self.frame.n_variables());
                let lengths = spreads.map(|spread| prior.length_median * spread);
                let alike = std::iter::repeat_n(LENGTH_ALIKE, n_skills + n_classes);
                let centre = GpKernel {
                    amplitude: prior.amplitude_median,
                    lengths: lengths.chain(alike).collect(),
                };
                GpClassifier::fit_near(&self.points, &self.succeeded, &centre, prior.log_deviation)
            }
        }
    }

    /// How likely the skill runs from a base pose.
    ///
    /// # Errors
    /// A pose that is not finite was learned from.
    pub fn probability(
        &mut self,
        skill: SkillOnClass,
        world_from_object: &Pose2,
        world_from_base: &Pose2,
    ) -> Result<f64, GpError> {
        let point = self.point(skill, world_from_object, world_from_base);
        Ok(self.symbol()?.probability(&point))
    }

    /// What speaks for a try from a base pose that is so far away.
    ///
    /// # Errors
    /// A pose that is not finite was learned from.
    pub fn choice(
        &mut self,
        skill: SkillOnClass,
        world_from_object: &Pose2,
        world_from_base: &Pose2,
        travel_m: f64,
    ) -> Result<Choice, GpError> {
        let point = self.point(skill, world_from_object, world_from_base);
        Ok(Choice::new(self.symbol()?, &point, travel_m))
    }

    /// Whether a proposed base pose is taken: with its probability.
    ///
    /// # Errors
    /// A pose that is not finite was learned from.
    pub fn accept(
        &mut self,
        skill: SkillOnClass,
        world_from_object: &Pose2,
        world_from_base: &Pose2,
        rng: &mut dyn Rng,
    ) -> Result<bool, GpError> {
        let probability = self.probability(skill, world_from_object, world_from_base)?;
        Ok(rng.random::<f64>() < probability)
    }
}

/// A symbol is fitted anew when it has one try in so many more.
const N_TRIES_A_FIT: usize = 32;

/// Median of the lengths of the variables that say which skill and which class: two skills on one class are then
/// believed to correlate by exp(−1 / 2²) before any try.
const LENGTH_ALIKE: f64 = 2.0;
