//! Grounding a navigation symbol: from the object's frame into a home.

use factotum_geometry::Pose2;
use rand::Rng;

use crate::navigation_symbol::NavigationSymbol;

/// Draws for each pose asked for; a region of which less than a few percent is free is as good as blocked.
const N_TRIES_PER_POSE: usize = 50;

/// Up to `n` free base poses in the world from which the option can run on the object.
///
/// Draws from the symbol, moves each pose into the world (`world_from_object * object_from_base`) and
/// keeps the free ones. The likeliest come first, equals in the order drawn. Fewer than `n` poses, or
/// none, mean that the free part of the region is small or empty.
pub fn ground(
    symbol: &NavigationSymbol,
    world_from_object: Pose2,
    is_free: impl Fn(&Pose2) -> bool,
    rng: &mut dyn Rng,
    n: usize,
) -> Vec<Pose2> {
    let mut found: Vec<(f64, Pose2)> = Vec::with_capacity(n);
    for _ in 0..n.saturating_mul(N_TRIES_PER_POSE) {
        if found.len() == n {
            break;
        }
        let Some(object_from_base) = symbol.sample(rng, N_TRIES_PER_POSE) else {
            break;
        };
        let world_from_base = world_from_object * object_from_base;
        if is_free(&world_from_base) {
            let probability = symbol.classifier.probability(&object_from_base);
            found.push((probability, world_from_base));
        }
    }
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    found
        .into_iter()
        .map(|(_, world_from_base)| world_from_base)
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use nalgebra::Vector2;
    use proptest::prelude::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::approach_region::ApproachRegion;
    use crate::navigation_symbol::BasePoseClassifier;

    fn symbol() -> NavigationSymbol {
        let region = ApproachRegion::new([0.6, 1.2], [-1.0, 1.0], 0.3).unwrap();
        NavigationSymbol::given("pick", "bottle", region)
    }

    proptest! {
        #[test]
        fn grounded_poses_are_free_likely_and_face_the_object(
            x in -5.0..5.0, y in -5.0..5.0, yaw in -PI..PI, seed: u64
        ) {
            let world_from_object = Pose2::new(Vector2::new(x, y), yaw);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let symbol = symbol();
            let free = |world_from_base: &Pose2| world_from_base.translation.x > x;
            let poses = ground(&symbol, world_from_object, free, &mut rng, 8);
            for world_from_base in &poses {
                prop_assert!(free(world_from_base));
                prop_assert!(symbol.probability(&world_from_object, world_from_base) > 0.0);
                let ahead = world_from_base.rotation * Vector2::x();
                let to_object = Vector2::new(x, y) - world_from_base.translation.vector;
                prop_assert!(ahead.dot(&to_object.normalize()) > 0.3f64.cos());
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_poses() {
        let draw = |seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            ground(&symbol(), Pose2::identity(), |_| true, &mut rng, 5)
        };
        assert_eq!(draw(1), draw(1));
        assert_eq!(draw(1).len(), 5);
        assert_ne!(draw(1), draw(2));
    }

    #[test]
    fn a_blocked_region_grounds_to_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        assert!(ground(&symbol(), Pose2::identity(), |_| false, &mut rng, 5).is_empty());
        assert!(ground(&symbol(), Pose2::identity(), |_| true, &mut rng, 0).is_empty());
    }

    /// Stands for a learned classifier: likely near, unlikely far, wrong proposals everywhere.
    #[derive(Debug)]
    struct Fading;

    impl BasePoseClassifier for Fading {
        fn probability(&self, object_from_base: &Pose2) -> f64 {
            (1.0 - object_from_base.translation.vector.norm()).max(0.0)
        }

        fn propose(&self, rng: &mut dyn Rng) -> Pose2 {
            let place = Vector2::new(
                rng.random::<f64>() * 4.0 - 2.0,
                rng.random::<f64>() * 4.0 - 2.0,
            );
            Pose2::new(place, rng.random::<f64>() * TAU)
        }
    }

    /// Classifiers other than regions are sampled by rejection: impossible poses never come out, and the
    /// likeliest come first.
    #[test]
    fn any_classifier_can_stand_behind_a_symbol() {
        let symbol = NavigationSymbol::given("pour", "cup", Fading);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let poses = ground(&symbol, Pose2::identity(), |_| true, &mut rng, 20);
        assert_eq!(poses.len(), 20);
        let probabilities: Vec<_> = poses
            .iter()
            .map(|p| symbol.probability(&Pose2::identity(), p))
            .collect();
        assert!(
            probabilities.is_sorted_by(|a, b| a >= b),
            "{probabilities:?}"
        );
        assert!(probabilities.iter().all(|p| *p > 0.0), "{probabilities:?}");
    }
}
