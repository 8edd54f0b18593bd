//! What a learned operator stands on, for people: which samples, which variables, how sure.

use std::fmt;

use super::SymbolicModel;

/// Why a learned operator is as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The operator.
    pub operator: String,
    /// The option it runs.
    pub option: String,
    /// The transitions it was learned from, as rows of the recording, from 0.
    pub rows: Vec<usize>,
    /// The variables its precondition hangs on.
    pub looks_at: Vec<String>,
    /// In how many states it was seen to be able to run, and in how many not.
    pub n_positive: usize,
    /// In how many states it was seen not to be able to run.
    pub n_negative: usize,
    /// Balanced accuracy of the precondition on held-out states, if there were enough.
    pub score: Option<f64>,
    /// How likely it can run where its symbols hold.
    pub probability: f64,
    /// The symbols it needs.
    pub needs: Vec<SymbolExplanation>,
    /// What may come of it.
    pub outcomes: Vec<OutcomeExplanation>,
}

/// What a symbol says.
#[derive(Debug, Clone, PartialEq)]
pub struct SymbolExplanation {
    /// Its name.
    pub symbol: String,
    /// Each variable with its mean and standard deviation where the symbol holds.
    pub values: Vec<(String, f64, f64)>,
    /// The samples it stands on.
    pub n_samples: usize,
}

/// What one outcome changes.
#[derive(Debug, Clone, PartialEq)]
pub struct OutcomeExplanation {
    /// How likely, if the option runs.
    pub probability: f64,
    /// In how many transitions it was seen.
    pub n_transitions: usize,
    /// The symbols that hold after it.
    pub adds: Vec<SymbolExplanation>,
    /// The names of the symbols that hold no more.
    pub deletes: Vec<String>,
}

/// Why something cannot be explained or renamed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NameError {
    /// No such name.
    #[error("the model has no {kind} `{found}`{hint}")]
    Unknown {
        /// What was looked for.
        kind: &'static str,
        /// The name asked for.
        found: String,
        /// The nearest name, as a question.
        hint: String,
    },
    /// The new name is taken or none that PDDL can write.
    #[error("`{from}` cannot be called `{to}`: {reason}")]
    Refused {
        /// The name there is.
        from: String,
        /// The name wanted.
        to: String,
        /// What is wrong with it.
        reason: String,
    },
}

impl SymbolicModel {
    /// Explains an operator.
    ///
    /// # Errors
    /// There is no operator of this name.
    pub fn explain(&self, operator: &str) -> Result<Explanation, NameError> {
        let operator = &self.operators[self.operator_of_name(operator)?];
        let partition = &self.partitions[operator.partition];
        let precondition = &self.preconditions[operator.partition];
        let symbols = |symbols: &[usize]| symbols.iter().map(|&s| self.explain_symbol(s)).collect();
        let outcome = |o: usize| {
            let outcome = &operator.outcomes[o];
            let name = |&s: &usize| self.vocabulary.symbols()[s].name.clone();
            OutcomeExplanation {
                probability: outcome.probability,
                n_transitions: partition.outcomes[o].rows.len(),
                adds: symbols(&outcome.adds),
                deletes: outcome.deletes.iter().map(name).collect(),
            }
        };
        let variable = |&v: &usize| self.variables[v].clone();
        Ok(Explanation {
            operator: operator.name.clone(),
            option: self.options[partition.option].clone(),
            rows: partition.rows().collect(),
            looks_at: precondition.variables.iter().map(variable).collect(),
            n_positive: precondition.n_positive,
            n_negative: precondition.n_negative,
            score: precondition.score,
            probability: operator.probability,
            needs: symbols(&operator.precondition),
            outcomes: (0..operator.outcomes.len()).map(outcome).collect(),
        })
    }

    fn explain_symbol(&self, symbol: usize) -> SymbolExplanation {
        let symbol = &self.vocabulary.symbols()[symbol];
        let density = &symbol.density;
        let (mean, deviation) = (density.mean(), density.deviation());
        let value = |(i, &v): (usize, &usize)| (self.variables[v].clone(), mean[i], deviation[i]);
        SymbolExplanation {
            symbol: symbol.name.clone(),
            values: density.variables().iter().enumerate().map(value).collect(),
            n_samples: density.samples().n_rows(),
        }
    }

    /// Gives a symbol another name, in every operator at once.
    ///
    /// # Errors
    /// There is no such symbol, the name is taken, or PDDL cannot write it.
    pub fn rename_symbol(&mut self, from: &str, to: &str) -> Result<(), NameError> {
        let names = self.vocabulary.symbols().iter().map(|s| s.name.as_str());
        let symbol = index_of("symbol", from, names)?;
        self.rename(from, to, |model, name| {
            name.clone_into(&mut model.vocabulary.symbols_mut()[symbol].name);
        })
    }

    /// Gives an operator another name.
    ///
    /// # Errors
    /// There is no such operator, the name is taken, or PDDL cannot write it.
    pub fn rename_operator(&mut self, from: &str, to: &str) -> Result<(), NameError> {
        let operator = self.operator_of_name(from)?;
        self.rename(from, to, |model, name| {
            name.clone_into(&mut model.operators[operator].name);
        })
    }

    /// Renames, and takes it back if no domain can be made with the new name.
    fn rename(
        &mut self,
        from: &str,
        to: &str,
        set: impl Fn(&mut Self, &str),
    ) -> Result<(), NameError> {
        set(self, to);
        let Err(error) = self.domain("renamed") else {
            return Ok(());
        };
        set(self, from);
        Err(NameError::Refused {
            from: from.to_owned(),
            to: to.to_owned(),
            reason: error.to_string(),
        })
    }

    fn operator_of_name(&self, name: &str) -> Result<usize, NameError> {
        index_of(
            "operator",
            name,
            self.operators.iter().map(|o| o.name.as_str()),
        )
    }
}

fn index_of<'a>(
    kind: &'static str,
    wanted: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, NameError> {
    names
        .clone()
        .position(|name| name == wanted)
        .ok_or_else(|| {
            let nearest = names.min_by_key(|name| strsim::levenshtein(name, wanted));
            NameError::Unknown {
                kind,
                found: wanted.to_owned(),
                hint: nearest.map_or(String::new(), |name| format!("; did you mean `{name}`?")),
            }
        })
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const N_ROWS_SHOWN: usize = 8;
        let rows: Vec<_> = self
            .rows
            .iter()
            .take(N_ROWS_SHOWN)
            .map(usize::to_string)
            .collect();
        let more = if self.rows.len() > N_ROWS_SHOWN {
            ", ..."
        } else {
            ""
        };
        writeln!(f, "{} runs option `{}`", self.operator, self.option)?;
        writeln!(
            f,
            "  seen in {} transitions: rows {}{more}",
            self.rows.len(),
            rows.join(", ")
        )?;
        match (self.looks_at.is_empty(), self.score) {
            (false, Some(score)) => writeln!(
                f,
                "  whether it can run hangs on {}: {:.1} % right on held-out states ({} could, {} could not)",
                self.looks_at.join(", "),
                100.0 * score,
                self.n_positive,
                self.n_negative
            )?,
            _ => writeln!(
                f,
                "  nothing was seen that it hangs on ({} states could, {} could not)",
                self.n_positive, self.n_negative
            )?,
        }
        writeln!(
            f,
            "  it can run with probability {:.3} where",
            self.probability
        )?;
        for symbol in &self.needs {
            writeln!(f, "    {symbol}")?;
        }
        for outcome in &self.outcomes {
            writeln!(
                f,
                "  then with probability {:.3} (seen {} times)",
                outcome.probability, outcome.n_transitions
            )?;
            for symbol in &outcome.adds {
                writeln!(f, "    {symbol}")?;
            }
            if !outcome.deletes.is_empty() {
                writeln!(f, "    no more: {}", outcome.deletes.join(", "))?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for SymbolExplanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = |(name, mean, deviation): &(String, f64, f64)| {
            format!("{name} = {mean:.3} ± {deviation:.3}")
        };
        let values: Vec<_> = self.values.iter().map(value).collect();
        write!(
            f,
            "{}: {} ({} samples)",
            self.symbol,
            values.join(", "),
            self.n_samples
        )
    }
}
