//! Passes against a plain evaluation in f64, and gradients against its central differences.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::{Activation, Architecture, Mlp, NetworkError, Pass};
use crate::panels::{Lanes, Panels, WIDTH, ZERO, n_panels};

fn architecture(hidden: &[usize], n_outputs: usize, n_members: usize) -> Architecture {
    Architecture {
        n_inputs: 21,
        hidden: hidden.to_vec(),
        n_outputs,
        hidden_activation: Activation::Tanh,
        output_activation: Activation::Linear,
        layer_norm: false,
        n_members,
    }
}

/// Each form that is used somewhere, and sizes that do not fill a panel.
fn forms() -> Vec<Architecture> {
    let twin = architecture(&[40, 24], 1, 2);
    let actor = Architecture {
        output_activation: Activation::Tanh,
        ..architecture(&[24, 40, 16], 13, 1)
    };
    let relu = |form: &Architecture| Architecture {
        hidden_activation: Activation::Relu,
        ..form.clone()
    };
    let normed = |form: &Architecture| Architecture {
        layer_norm: true,
        ..form.clone()
    };
    vec![
        twin.clone(),
        relu(&twin),
        normed(&twin),
        normed(&relu(&twin)),
        actor.clone(),
        relu(&actor),
        Architecture {
            output_activation: Activation::Relu,
            ..relu(&twin)
        },
        architecture(&[1], 2, 3),
    ]
}

fn apply(activation: Activation, value: f64) -> f64 {
    match activation {
        Activation::Linear => value,
        Activation::Relu => value.max(0.0),
        Activation::Tanh => value.tanh(),
    }
}

/// The parameters of a member as matrices in f64, in the order of [`Mlp::tensors`].
fn matrices(network: &Mlp, member: usize) -> Vec<Matrix> {
    let prefix = format!("{member}.");
    network
        .tensors()
        .iter()
        .filter(|tensor| tensor.name.starts_with(&prefix))
        .map(|tensor| Matrix {
            name: tensor.name.clone(),
            shape: tensor.block.shape(),
            values: tensor
                .block
                .elements(network.parameters())
                .map(f64::from)
                .collect(),
        })
        .collect()
}

#[derive(Clone)]
struct Matrix {
    name: String,
    shape: [usize; 2],
    values: Vec<f64>,
}

/// The network as the module's formulas say it, in f64.
fn evaluate(form: &Architecture, matrices: &[Matrix], input: &[f64]) -> Vec<f64> {
    let mut y = input.to_vec();
    let per_layer = |l: usize| {
        let name = format!(".{l}.");
        matrices
            .iter()
            .filter(|matrix| matrix.name.contains(&name))
            .collect::<Vec<_>>()
    };
    for l in 0..=form.hidden.len() {
        let is_output = l == form.hidden.len();
        let layer = per_layer(l);
        let (weights, bias) = (layer[0], layer[1]);
        let n_outputs = bias.shape[1];
        let weight = |i: usize, o: usize| {
            if weights.shape == [y.len(), n_outputs] {
                weights.values[i * n_outputs + o]
            } else {
                weights.values[o * y.len() + i]
            }
        };
        let mut z: Vec<f64> = (0..n_outputs)
            .map(|o| bias.values[o] + (0..y.len()).map(|i| y[i] * weight(i, o)).sum::<f64>())
            .collect();
        if let [_, _, gain, shift] = layer[..] {
            let n = z.len() as f64;
            let mean = z.iter().sum::<f64>() / n;
            let variance = z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n;
            for (o, z) in z.iter_mut().enumerate() {
                *z = gain.values[o] * (*z - mean) / (variance + 1e-5).sqrt() + shift.values[o];
            }
        }
        let activation = if is_output {
            form.output_activation
        } else {
            form.hidden_activation
        };
        y = z.into_iter().map(|z| apply(activation, z)).collect();
    }
    y
}

/// A batch in panels and as rows of f64.
fn batch(rng: &mut ChaCha8Rng, n_rows: usize, n_cols: usize) -> (Vec<Lanes>, Vec<Vec<f64>>) {
    let mut lanes = vec![ZERO; n_rows * n_panels(n_cols)];
    let rows = (0..n_rows)
        .map(|row| {
            (0..n_cols)
                .map(|column| {
                    let value: f32 = rng.random_range(-1.0..1.0);
                    lanes[column / WIDTH * n_rows + row][column % WIDTH] = value;
                    f64::from(value)
                })
                .collect()
        })
        .collect();
    (lanes, rows)
}

/// A network whose normalisations and biases are not at their first values.
fn network(form: &Architecture, rng: &mut ChaCha8Rng) -> Mlp {
    let mut network = Mlp::new(form.clone(), rng).unwrap();
    for tensor in network.tensors() {
        tensor
            .block
            .for_each_mut(network.parameters_mut(), |value| {
                *value += rng.random_range(-0.2..0.2);
            });
    }
    network
}

const N_ROWS: usize = 11;

#[test]
fn the_forward_pass_is_the_formula() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for form in forms() {
        let network = network(&form, &mut rng);
        let (input, rows) = batch(&mut rng, N_ROWS, form.n_inputs);
        let mut pass = Pass::new(&form, N_ROWS);
        network.forward(
            Panels::new(&input, N_ROWS, form.n_inputs),
            form.n_members,
            &mut pass,
        );
        let mut single = Pass::new(&form, 1);
        for member in 0..form.n_members {
            let matrices = matrices(&network, member);
            for (i, row) in rows.iter().enumerate() {
                let wanted = evaluate(&form, &matrices, row);
                for (o, wanted) in wanted.iter().enumerate() {
                    let found = pass.output(member)[o / WIDTH * N_ROWS + i][o % WIDTH];
                    assert!(
                        (f64::from(found) - wanted).abs() < 2e-5,
                        "{form:?}: {found} for {wanted}"
                    );
                }
                if member == 0 {
                    let row: Vec<f32> = row.iter().map(|value| *value as f32).collect();
                    let mut out = vec![0.0; form.n_outputs];
                    network.evaluate_into(&row, &mut single, &mut out);
                    for (found, wanted) in out.iter().zip(&wanted) {
                        assert!((f64::from(*found) - wanted).abs() < 2e-5);
                    }
                }
            }
        }
    }
}

/// Loss whose derivatives are checked: a weighted sum of all outputs.
fn loss(form: &Architecture, matrices: &[Matrix], rows: &[Vec<f64>], weights: &[Vec<f64>]) -> f64 {
    rows.iter()
        .zip(weights)
        .map(|(row, weights)| {
            let outputs = evaluate(form, matrices, row);
            outputs.iter().zip(weights).map(|(y, w)| y * w).sum::<f64>()
        })
        .sum()
}

/// Step of the central differences, in f64: the error of the difference is of the order of its square.
const STEP: f64 = 1e-5;
/// Relative to the largest derivative: f32 rounds sums of tens of terms.
const TOLERANCE: f64 = 1e-4;

#[test]
fn gradients_are_central_differences() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for form in forms() {
        let network = network(&form, &mut rng);
        let (input, rows) = batch(&mut rng, N_ROWS, form.n_inputs);
        let input = Panels::new(&input, N_ROWS, form.n_inputs);
        let mut pass = Pass::new(&form, N_ROWS);
        network.forward(input, form.n_members, &mut pass);
        let mut weights = Vec::new();
        for member in 0..form.n_members {
            let (lanes, rows) = batch(&mut rng, N_ROWS, form.n_outputs);
            pass.output_delta_mut(member).copy_from_slice(&lanes);
            weights.push(rows);
        }
        let mut gradient = vec![[7.0; WIDTH]; network.parameters().len()];
        network.backward(input, &mut pass, &mut gradient);
        for (member, weights) in weights.iter().enumerate() {
            let matrices = matrices(&network, member);
            let prefix = format!("{member}.");
            let tensors = network.tensors();
            let found: Vec<Vec<f32>> = tensors
                .iter()
                .filter(|tensor| tensor.name.starts_with(&prefix))
                .map(|tensor| tensor.block.elements(&gradient).collect())
                .collect();
            for (t, found) in found.iter().enumerate() {
                // Every eleventh is enough to find an error of any row, column or panel.
                let chosen = (0..found.len()).step_by(11);
                let wanted: Vec<f64> = chosen
                    .clone()
                    .map(|i| {
                        let at = |step: f64| {
                            let mut moved = matrices.clone();
                            moved[t].values[i] += step;
                            loss(&form, &moved, &rows, weights)
                        };
                        (at(STEP) - at(-STEP)) / (2.0 * STEP)
                    })
                    .collect();
                let found: Vec<f32> = chosen.map(|i| found[i]).collect();
                check(&found, &wanted, &format!("{form:?} {}", matrices[t].name));
            }
        }
        let padding = gradient
            .as_flattened()
            .iter()
            .filter(|value| **value == 7.0);
        assert_eq!(padding.count(), 0, "the whole gradient is written");
    }
}

fn check(found: &[f32], wanted: &[f64], what: &str) {
    let largest = wanted
        .iter()
        .fold(1.0, |most: f64, value| most.max(value.abs()));
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        assert!(
            (f64::from(*found) - wanted).abs() < TOLERANCE * largest,
            "{what} {i}: {found} for {wanted}"
        );
    }
}

#[test]
fn input_gradients_are_central_differences() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for form in forms() {
        let network = network(&form, &mut rng);
        let (input, rows) = batch(&mut rng, N_ROWS, form.n_inputs);
        let mut pass = Pass::new(&form, N_ROWS);
        network.forward(Panels::new(&input, N_ROWS, form.n_inputs), 1, &mut pass);
        let (lanes, weights) = batch(&mut rng, N_ROWS, form.n_outputs);
        pass.output_delta_mut(0).copy_from_slice(&lanes);
        let delta = network.backward_to_input(&mut pass, 1).to_vec();
        assert_eq!(delta.len(), N_ROWS);
        let matrices = matrices(&network, 0);
        let n_columns = form.n_inputs - WIDTH;
        for row in 0..N_ROWS {
            let wanted: Vec<f64> = (0..n_columns)
                .map(|column| {
                    let at = |step: f64| {
                        let mut moved = rows[row].clone();
                        moved[WIDTH + column] += step;
                        loss(&form, &matrices, &[moved], &weights[row..=row])
                    };
                    (at(STEP) - at(-STEP)) / (2.0 * STEP)
                })
                .collect();
            check(
                &delta[row][..n_columns],
                &wanted,
                &format!("{form:?} row {row}"),
            );
        }
    }
}

#[test]
fn a_size_of_zero_is_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let good = architecture(&[4], 1, 1);
    let refused = [
        (
            Architecture {
                n_inputs: 0,
                ..good.clone()
            },
            "inputs",
        ),
        (
            Architecture {
                n_outputs: 0,
                ..good.clone()
            },
            "outputs",
        ),
        (
            Architecture {
                n_members: 0,
                ..good.clone()
            },
            "members",
        ),
        (architecture(&[], 1, 1), "hidden layers"),
        (architecture(&[4, 0], 1, 1), "units in a hidden layer"),
    ];
    for (form, what) in refused {
        let found = Mlp::new(form, &mut rng);
        assert_eq!(found.unwrap_err(), NetworkError::Empty { what });
    }
}

#[test]
fn an_output_of_scale_zero_says_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let form = architecture(&[8], 3, 1);
    let mut network = Mlp::new(form.clone(), &mut rng).unwrap();
    network.scale_output(0.0);
    let mut out = [1.0; 3];
    network.evaluate_into(&[0.5; 21], &mut Pass::new(&form, 1), &mut out);
    assert_eq!(out, [0.0; 3]);
}
