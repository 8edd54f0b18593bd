//! Torque limits hold whatever is wished.

use factotum_control::torque_limit::{FULL_TORQUE_SECS, TorqueLimiter};
use nalgebra::DVector;
use proptest::prelude::*;

proptest! {
    #[test]
    fn both_limits_always_hold(wishes in prop::collection::vec(prop::array::uniform3(-1e4_f64..1e4), 1..40)) {
        let max = [30.0, 5.0, 80.0];
        let dt = 0.002;
        let mut limiter = TorqueLimiter::new(&max);
        let mut before: DVector<f64> = DVector::zeros(3);
        for wish in wishes {
            let now = limiter.limit(&DVector::from_row_slice(&wish), dt).unwrap();
            for i in 0..3 {
                prop_assert!(now[i].abs() <= max[i]);
                prop_assert!((now[i] - before[i]).abs() <= max[i] / FULL_TORQUE_SECS * dt * (1.0 + 1e-12));
                prop_assert!((wish[i] - now[i]).abs() <= (wish[i] - before[i]).abs() + 1e-12);
            }
            before.clone_from(now);
        }
    }
}

#[test]
fn a_number_that_is_none_is_refused() {
    let mut limiter = TorqueLimiter::new(&[1.0]);
    let error = limiter
        .limit(&DVector::from_element(1, f64::NAN), 0.002)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "torques holds a number that is not finite"
    );
    assert_eq!(limiter.last()[0], 0.0);
}
