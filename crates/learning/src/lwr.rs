//! Locally weighted regression: a function as a blend of small models, each fitted to the samples near its own place.
//!
//! ```text
//! psi_i(x) = exp(-sum_d h_di (x_d - c_di)^2)
//! W_i      = argmin sum_k psi_i(x_k) |y_k - W_i phi_i(x_k)|^2
//! y(x)     = sum_i psi_i(x) W_i phi_i(x) / sum_i psi_i(x)
//! ```
//!
//! Sources: Cleveland, "Robust Locally Weighted Regression and Smoothing Scatterplots", JASA 74 (1979), doi
//! 10.1080/01621459.1979.10481038; Schaal & Atkeson, "Constructive Incremental Learning from Only Local Information",
//! Neural Computation 10 (1998), doi 10.1162/089976698300016963, whose receptive fields these are, at fixed places and
//! of fixed widths. Each model is fitted by itself, without looking at its neighbours' errors.
//!
//! | symbol | name |
//! |---|---|
//! | c, h | centre, and width as one over a squared distance |
//! | phi | what a model is linear in: [`LocalModel`] |
//! | W | a model's coefficients, `n_outputs` times the number of terms |

mod error;
mod fields;

pub use error::LwrError;
pub use fields::{Activation, ReceptiveFields};

use nalgebra::{DMatrix, DVector};

use error::{check_finite, check_size};

/// Directions in which a field's samples spread less than this share of the widest are taken as not seen at all.
const SPREAD_SHARE_MIN: f64 = 1e-12;

/// What each local model is linear in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocalModel {
    /// `phi = x`: models that vanish where the input does, such as forces that fade with a phase.
    ThroughOrigin,
    /// `phi = (x - c, 1)`: a plane, at the centre of its field.
    Affine,
}

/// A fitted function.
#[derive(Debug, Clone, PartialEq)]
pub struct LocallyWeightedRegression {
    fields: ReceptiveFields,
    form: LocalModel,
    n_outputs: usize,
    /// One column a field, `(n_terms * n_outputs, n_fields)`; outputs change fastest.
    models: DMatrix<f64>,
}

impl LocallyWeightedRegression {
    /// Fits to samples in columns: inputs `(n_inputs, n_samples)`, outputs `(n_outputs, n_samples)`.
    ///
    /// Of several best models the one with the least coefficients is taken; so a field without a sample says zero, and
    /// an affine one with a single sample is level.
    ///
    /// # Errors
    /// [`LwrError`] when a size differs or a number is not finite.
    pub fn fit(
        fields: ReceptiveFields,
        form: LocalModel,
        inputs: &DMatrix<f64>,
        outputs: &DMatrix<f64>,
    ) -> Result<Self, LwrError> {
        check_size("inputs, rows", inputs.nrows(), fields.n_inputs())?;
        check_size("outputs, columns", outputs.ncols(), inputs.ncols())?;
        check_finite("inputs", inputs.iter())?;
        check_finite("outputs", outputs.iter())?;
        let n_terms = form.n_terms(fields.n_inputs());
        let n_outputs = outputs.nrows();
        let mut models = DMatrix::zeros(n_terms * n_outputs, fields.n_fields());
        let mut moments = Moments::new(n_terms, n_outputs);
        let mut terms = vec![0.0; n_terms];
        for (field, mut model) in models.column_iter_mut().enumerate() {
            moments.clear();
            for (input, output) in inputs.column_iter().zip(outputs.column_iter()) {
                let share = fields.exponent(field, input.as_slice()).exp();
                form.terms_into(&fields, field, input.as_slice(), &mut terms);
                moments.add(share, &terms, output.as_slice());
            }
            model.copy_from_slice(moments.solve().as_slice());
        }
        Ok(Self {
            fields,
            form,
            n_outputs,
            models,
        })
    }

    /// The function's value at an input, into `output`.
    ///
    /// # Errors
    /// [`LwrError`] when a size differs or the input is not finite.
    pub fn predict_into(
        &self,
        input: &[f64],
        activation: &mut Activation,
        output: &mut [f64],
    ) -> Result<(), LwrError> {
        check_size("input", input.len(), self.fields.n_inputs())?;
        check_size("output", output.len(), self.n_outputs)?;
        check_size("activation", activation.n_fields(), self.fields.n_fields())?;
        check_finite("input", input)?;
        self.evaluate_into(input, activation, output);
        Ok(())
    }

    /// As [`Self::predict_into`] for sizes that are known to be right.
    pub(crate) fn evaluate_into(
        &self,
        input: &[f64],
        activation: &mut Activation,
        output: &mut [f64],
    ) {
        self.fields.activate_into(input, activation);
        output.fill(0.0);
        for (field, share) in activation.shares() {
            let model = self.models.column(field);
            let blocks = model.as_slice().chunks_exact(self.n_outputs);
            for (term, block) in blocks.enumerate() {
                let weight = share * self.form.term(&self.fields, field, input, term);
                for (out, coefficient) in output.iter_mut().zip(block) {
                    *out += weight * coefficient;
                }
            }
        }
    }

    /// Where the local models lie.
    #[must_use]
    pub fn fields(&self) -> &ReceptiveFields {
        &self.fields
    }

    /// The coefficients, one column a field: for each term those of all outputs.
    #[must_use]
    pub fn models(&self) -> &DMatrix<f64> {
        &self.models
    }

    /// Replaces the coefficients.
    ///
    /// # Errors
    /// [`LwrError`] when their shape is another or one is not finite.
    pub fn set_models(&mut self, models: DMatrix<f64>) -> Result<(), LwrError> {
        check_size("coefficients, rows", models.nrows(), self.models.nrows())?;
        check_size("coefficients, fields", models.ncols(), self.models.ncols())?;
        check_finite("coefficients", models.iter())?;
        self.models = models;
        Ok(())
    }
}

impl LocalModel {
    fn n_terms(self, n_inputs: usize) -> usize {
        match self {
            Self::ThroughOrigin => n_inputs,
            Self::Affine => n_inputs + 1,
        }
    }

    fn term(self, fields: &ReceptiveFields, field: usize, input: &[f64], term: usize) -> f64 {
        match (self, input.get(term)) {
            (Self::ThroughOrigin, Some(x)) => *x,
            (Self::Affine, Some(x)) => x - fields.center(field)[term],
            (_, None) => 1.0,
        }
    }

    fn terms_into(self, fields: &ReceptiveFields, field: usize, input: &[f64], out: &mut [f64]) {
        for (term, out) in out.iter_mut().enumerate() {
            *out = self.term(fields, field, input, term);
        }
    }
}

/// Weighted sums over the samples of one field.
struct Moments {
    /// `sum psi phi phi^T`.
    terms: DMatrix<f64>,
    /// `sum psi y phi^T`, `(n_outputs, n_terms)`.
    outputs: DMatrix<f64>,
}

impl Moments {
    fn new(n_terms: usize, n_outputs: usize) -> Self {
        Self {
            terms: DMatrix::zeros(n_terms, n_terms),
            outputs: DMatrix::zeros(n_outputs, n_terms),
        }
    }

    fn clear(&mut self) {
        self.terms.fill(0.0);
        self.outputs.fill(0.0);
    }

    fn add(&mut self, share: f64, terms: &[f64], outputs: &[f64]) {
        for (j, term) in terms.iter().enumerate() {
            let weight = share * term;
            for (sum, other) in self.terms.column_mut(j).iter_mut().zip(terms) {
                *sum += weight * other;
            }
            for (sum, output) in self.outputs.column_mut(j).iter_mut().zip(outputs) {
                *sum += weight * output;
            }
        }
    }

    /// Least-squares coefficients `(n_outputs, n_terms)`; of several the least.
    fn solve(&self) -> DMatrix<f64> {
        if self.terms.len() == 1 {
            let square = self.terms[(0, 0)];
            let inverse = if square > 0.0 { 1.0 / square } else { 0.0 };
            return &self.outputs * inverse;
        }
        let parts = self.terms.clone().symmetric_eigen();
        let least = SPREAD_SHARE_MIN * parts.eigenvalues.max();
        let inverses: DVector<f64> = parts
            .eigenvalues
            .map(|value| if value > least { 1.0 / value } else { 0.0 });
        let along = &self.outputs * &parts.eigenvectors;
        along * DMatrix::from_diagonal(&inverses) * parts.eigenvectors.transpose()
    }
}

#[cfg(test)]
mod tests;
