//! Where local models hold: Gaussian bumps in the space of inputs.

use nalgebra::DMatrix;

use super::LwrError;
use super::error::{check_finite, check_size};

/// Fields weaker than the strongest by more than `exp(-37)`, less than half a unit in the last place, are left out.
const EXPONENT_BELOW_MAX: f64 = 37.0;

/// Gaussian fields at fixed places, `psi_i(x) = exp(-sum_d h_di (x_d - c_di)^2)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceptiveFields {
    n_inputs: usize,
    /// Field after field.
    centers: Vec<f64>,
    /// Field after field.
    widths: Vec<f64>,
}

/// How much each field has to say about an input, as shares of one. Memory for one set of fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Activation {
    values: Vec<f64>,
    /// The first field that counts, and the first after the last.
    counted: (usize, usize),
}

impl ReceptiveFields {
    /// Fields in columns: centres and widths, both `(n_inputs, n_fields)`. A width of zero ignores its dimension.
    ///
    /// # Errors
    /// [`LwrError`] when there is no field, the sizes differ, or a number is not finite or a width negative.
    pub fn new(centers: &DMatrix<f64>, widths: &DMatrix<f64>) -> Result<Self, LwrError> {
        for (what, size) in [("inputs", centers.nrows()), ("fields", centers.ncols())] {
            if size == 0 {
                return Err(LwrError::Empty { what });
            }
        }
        check_size("widths, rows", widths.nrows(), centers.nrows())?;
        check_size("widths, fields", widths.ncols(), centers.ncols())?;
        check_finite("centres", centers.iter())?;
        for (field, column) in widths.column_iter().enumerate() {
            for (dim, &found) in column.iter().enumerate() {
                if !(found.is_finite() && found >= 0.0) {
                    return Err(LwrError::Width { field, dim, found });
                }
            }
        }
        Ok(Self {
            n_inputs: centers.nrows(),
            centers: centers.as_slice().to_vec(),
            widths: widths.as_slice().to_vec(),
        })
    }

    /// Components of an input.
    #[must_use]
    pub fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    /// Number of fields.
    #[must_use]
    pub fn n_fields(&self) -> usize {
        self.centers.len() / self.n_inputs
    }

    /// Memory for the activation of these fields.
    #[must_use]
    pub fn activation(&self) -> Activation {
        Activation {
            values: vec![0.0; self.n_fields()],
            counted: (0, 0),
        }
    }

    pub(super) fn center(&self, field: usize) -> &[f64] {
        &self.centers[field * self.n_inputs..][..self.n_inputs]
    }

    /// `ln psi`.
    pub(super) fn exponent(&self, field: usize, input: &[f64]) -> f64 {
        let widths = &self.widths[field * self.n_inputs..][..self.n_inputs];
        let distance: f64 = self
            .center(field)
            .iter()
            .zip(widths)
            .zip(input)
            .map(|((center, width), x)| width * (x - center) * (x - center))
            .sum();
        -distance
    }

    /// Shares relative to the strongest field, so that their sum cannot vanish far from all centres.
    pub(crate) fn activate_into(&self, input: &[f64], activation: &mut Activation) {
        let values = &mut activation.values;
        let mut highest = f64::NEG_INFINITY;
        for (field, value) in values.iter_mut().enumerate() {
            *value = self.exponent(field, input);
            highest = highest.max(*value);
        }
        let least = highest - EXPONENT_BELOW_MAX;
        let counts = |value: &f64| *value >= least;
        let first = values.iter().position(counts).unwrap_or(0);
        let end = values.iter().rposition(counts).map_or(0, |last| last + 1);
        let mut sum = 0.0;
        for value in &mut values[first..end] {
            *value = (*value - highest).exp();
            sum += *value;
        }
        for value in &mut values[first..end] {
            *value /= sum;
        }
        activation.counted = (first, end);
    }
}

impl Activation {
    pub(super) fn n_fields(&self) -> usize {
        self.values.len()
    }

    /// Fields that count, with their shares.
    pub fn shares(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (first, end) = self.counted;
        (first..end).zip(self.values[first..end].iter().copied())
    }
}
