use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

use super::{LocalModel, LocallyWeightedRegression, LwrError, ReceptiveFields};

/// Two fields over one input, at 0 and 1.
fn two_fields() -> ReceptiveFields {
    ReceptiveFields::new(&dmatrix![0.0, 1.0], &dmatrix![2.0, 2.0]).unwrap()
}

fn predict(function: &LocallyWeightedRegression, input: &[f64]) -> Vec<f64> {
    let mut activation = function.fields().activation();
    let mut output = vec![f64::NAN; function.n_outputs];
    function
        .predict_into(input, &mut activation, &mut output)
        .unwrap();
    output
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Each local model of a plane is that plane, so their blend is it everywhere.
    #[test]
    fn a_plane_is_found_to_rounding(
        slopes in prop::array::uniform4(-3.0..3.0f64), offsets in prop::array::uniform2(-3.0..3.0f64),
        at in prop::array::uniform2(-2.0..3.0f64),
    ) {
        let plane = |x: f64, y: f64| [
            slopes[0] * x + slopes[1] * y + offsets[0],
            slopes[2] * x + slopes[3] * y + offsets[1],
        ];
        let fields = ReceptiveFields::new(
            &dmatrix![0.0, 1.0, 0.5; 0.2, 0.9, 0.1],
            &dmatrix![1.0, 2.0, 3.0; 2.0, 1.0, 0.5],
        ).unwrap();
        let inputs = DMatrix::from_fn(2, 49, |dim, k| (if dim == 0 { k / 7 } else { k % 7 }) as f64 / 6.0);
        let outputs = DMatrix::from_fn(2, 49, |dim, k| plane(inputs[(0, k)], inputs[(1, k)])[dim]);
        let function =
            LocallyWeightedRegression::fit(fields, LocalModel::Affine, &inputs, &outputs).unwrap();
        for (found, wanted) in predict(&function, &at).iter().zip(plane(at[0], at[1])) {
            prop_assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }

    #[test]
    fn shares_are_of_one(at in -1e3..1e3f64) {
        let fields = two_fields();
        let mut activation = fields.activation();
        fields.activate_into(&[at], &mut activation);
        let sum: f64 = activation.shares().map(|(_, share)| share).sum();
        prop_assert!((sum - 1.0).abs() < 1e-15, "{sum}");
    }
}

/// Weighted least squares of three samples under one field, worked out by hand.
#[test]
fn a_line_is_the_closed_form() {
    let fields = ReceptiveFields::new(&dmatrix![0.0], &dmatrix![1.0]).unwrap();
    let (x, y) = ([-1.0, 0.0, 2.0], [3.0, 1.0, -2.0]);
    let inputs = DMatrix::from_row_slice(1, 3, &x);
    let outputs = DMatrix::from_row_slice(1, 3, &y);
    let fit = |form| LocallyWeightedRegression::fit(fields.clone(), form, &inputs, &outputs);
    let weight = |k: usize| (-x[k] * x[k]).exp();
    let sum = |term: &dyn Fn(usize) -> f64| (0..3).map(|k| weight(k) * term(k)).sum::<f64>();
    let (s, sx, sxx) = (sum(&|_| 1.0), sum(&|k| x[k]), sum(&|k| x[k] * x[k]));
    let (sy, sxy) = (sum(&|k| y[k]), sum(&|k| x[k] * y[k]));

    let slope = (s * sxy - sx * sy) / (s * sxx - sx * sx);
    let level = (sy - slope * sx) / s;
    let found = fit(LocalModel::Affine).unwrap();
    assert!(
        (found.models() - dmatrix![slope; level]).amax() < 1e-12,
        "{found:?}"
    );

    let found = fit(LocalModel::ThroughOrigin).unwrap();
    assert!(
        (found.models() - dmatrix![sxy / sxx]).amax() < 1e-12,
        "{found:?}"
    );
}

/// Between two fields that say 0 and 1, `1 / (1 + exp(h (1 - 2 x)))`.
#[test]
fn models_are_blended_by_their_fields() {
    let inputs = dmatrix![0.0, 1.0];
    let mut function = LocallyWeightedRegression::fit(
        two_fields(),
        LocalModel::Affine,
        &inputs,
        &dmatrix![0.0, 0.0],
    )
    .unwrap();
    function.set_models(dmatrix![0.0, 0.0; 0.0, 1.0]).unwrap();
    for x in [-4.0_f64, 0.0, 0.3, 0.5, 1.0, 30.0] {
        let wanted = 1.0 / (1.0 + (2.0 * (1.0 - 2.0 * x)).exp());
        let found = predict(&function, &[x])[0];
        assert!((found - wanted).abs() < 1e-14, "{found} {wanted} at {x}");
    }
}

#[test]
fn what_was_not_seen_is_not_made_up() {
    let level = |inputs: DMatrix<f64>, outputs: DMatrix<f64>| {
        let far = ReceptiveFields::new(&dmatrix![0.0, 100.0], &dmatrix![2.0, 2.0]).unwrap();
        LocallyWeightedRegression::fit(far, LocalModel::Affine, &inputs, &outputs).unwrap()
    };
    // One sample at the centre of the first field: level there, and zero where there is none.
    let function = level(dmatrix![0.0], dmatrix![5.0]);
    assert!((function.models() - dmatrix![0.0, 0.0; 5.0, 0.0]).amax() < 1e-12);
    // The same sample twice is no slope either.
    let function = level(dmatrix![0.0, 0.0], dmatrix![4.0, 6.0]);
    assert!((function.models() - dmatrix![0.0, 0.0; 5.0, 0.0]).amax() < 1e-12);
}

#[test]
fn bad_samples_and_fields_are_refused() {
    let fit = |inputs: DMatrix<f64>, outputs: DMatrix<f64>| {
        LocallyWeightedRegression::fit(two_fields(), LocalModel::Affine, &inputs, &outputs)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        fit(dmatrix![0.0; 1.0], dmatrix![1.0]),
        "inputs, rows has 2 entries, expected 1"
    );
    assert_eq!(
        fit(dmatrix![0.0, 1.0], dmatrix![1.0]),
        "outputs, columns has 1 entries, expected 2"
    );
    assert_eq!(
        fit(dmatrix![f64::NAN], dmatrix![1.0]),
        "inputs has a component that is not finite"
    );
    assert_eq!(
        fit(dmatrix![0.0], dmatrix![f64::INFINITY]),
        "outputs has a component that is not finite"
    );
    let fields = |centers: DMatrix<f64>, widths: DMatrix<f64>| {
        ReceptiveFields::new(&centers, &widths).unwrap_err()
    };
    assert_eq!(
        fields(DMatrix::zeros(1, 0), DMatrix::zeros(1, 0)),
        LwrError::Empty { what: "fields" }
    );
    let found = -1.0;
    assert_eq!(
        fields(dmatrix![0.0, 1.0], dmatrix![1.0, found]),
        LwrError::Width {
            field: 1,
            dim: 0,
            found
        }
    );
}
