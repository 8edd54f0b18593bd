//! Navigation symbols: where the base can stand for an option, relative to the option's object.

use std::sync::Arc;

use factotum_geometry::Pose2;
use factotum_task_planning::operator::Provenance;
use rand::{Rng, RngExt as _};

use crate::approach_region::ApproachRegion;

/// A probabilistic classifier over the base's pose in an object's frame.
///
/// A learned classifier is sampled by rejection (dissertation 5.4): it proposes poses from a geometric
/// heuristic or its own data, and [`NavigationSymbol::sample`] accepts each with its probability.
pub trait BasePoseClassifier: std::fmt::Debug + Send + Sync {
    /// How likely the option can run from this base pose, in \[0, 1\].
    fn probability(&self, object_from_base: &Pose2) -> f64;

    /// A candidate pose; every pose of non-zero probability must be able to come up.
    fn propose(&self, rng: &mut dyn Rng) -> Pose2;

    /// The classifier as a region, if it is one: regions are kept as text and drawn as outlines.
    fn as_approach_region(&self) -> Option<&ApproachRegion> {
        None
    }
}

/// The navigation symbol σ^o of an option o on a class of objects.
#[derive(Debug, Clone)]
pub struct NavigationSymbol {
    /// Name of the option.
    pub option: String,
    /// Name of the object class the option acts on.
    pub object_class: String,
    /// Where it comes from.
    pub provenance: Provenance,
    /// The classifier over `object_from_base`.
    pub classifier: Arc<dyn BasePoseClassifier>,
}

impl NavigationSymbol {
    /// The symbol of an option with a classifier given by hand.
    pub fn given(
        option: impl Into<String>,
        object_class: impl Into<String>,
        classifier: impl BasePoseClassifier + 'static,
    ) -> Self {
        Self {
            option: option.into(),
            object_class: object_class.into(),
            provenance: Provenance::Given,
            classifier: Arc::new(classifier),
        }
    }

    /// How likely the option can run from a base pose in the world, for an object at its pose.
    pub fn probability(&self, world_from_object: &Pose2, world_from_base: &Pose2) -> f64 {
        self.classifier
            .probability(&world_from_object.inv_mul(world_from_base))
    }

    /// Draws `object_from_base` from the symbol by rejection; `None` after `n_tries_max` rejections.
    pub fn sample(&self, rng: &mut dyn Rng, n_tries_max: usize) -> Option<Pose2> {
        (0..n_tries_max).find_map(|_| {
            let object_from_base = self.classifier.propose(rng);
            let accepted = rng.random::<f64>() < self.classifier.probability(&object_from_base);
            accepted.then_some(object_from_base)
        })
    }
}
