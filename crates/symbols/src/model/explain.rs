//! What a learned operator stands on, for people: which samples, which variables, how sure.

use std::fmt;

use serde::Serialize;

use super::record::{ModelRecord, NameError, OutcomeRecord, PlaceRecord, SymbolRecord, position};

/// Why a learned operator is as it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    pub needs: Vec<SymbolRecord>,
    /// Where the base must be, if space was learned apart.
    pub place: Option<PlaceRecord>,
    /// What may come of it.
    pub outcomes: Vec<OutcomeExplanation>,
}

/// What one outcome changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutcomeExplanation {
    /// How likely, if the option runs.
    pub probability: f64,
    /// In how many transitions it was seen.
    pub n_transitions: usize,
    /// Whether its end depends on its start.
    pub depends_on_start: bool,
    /// The symbols that hold after it.
    pub adds: Vec<SymbolRecord>,
    /// The names of the symbols that hold no more.
    pub deletes: Vec<String>,
}

impl ModelRecord {
    /// Explains an operator.
    ///
    /// # Errors
    /// There is no operator of this name, or one that names what the model does not have.
    pub fn explain(&self, operator: &str) -> Result<Explanation, NameError> {
        let names = self.operators.iter().map(|o| o.name.as_str());
        let operator = &self.operators[position("operator", operator, names)?];
        let dangling = |kind, found: &str| NameError::Dangling {
            operator: operator.name.clone(),
            kind,
            found: found.to_owned(),
        };
        let partition = (self.partitions.get(operator.partition))
            .filter(|p| p.rows.len() == operator.outcomes.len())
            .ok_or_else(|| dangling("partition", &operator.partition.to_string()))?;
        let symbols = |names: &[String]| -> Result<Vec<SymbolRecord>, NameError> {
            let symbol = |name: &String| {
                let symbol = self.symbols.iter().find(|s| s.name == *name);
                symbol.cloned().ok_or_else(|| dangling("symbol", name))
            };
            names.iter().map(symbol).collect()
        };
        let outcome = |(o, (outcome, rows)): (usize, (&OutcomeRecord, &Vec<usize>))| {
            Ok(OutcomeExplanation {
                probability: outcome.probability,
                n_transitions: rows.len(),
                depends_on_start: partition.not_subgoal.contains(&o),
                adds: symbols(&outcome.adds)?,
                deletes: outcome.deletes.clone(),
            })
        };
        let outcomes = operator.outcomes.iter().zip(&partition.rows);
        let outcomes = outcomes.enumerate().map(outcome);
        Ok(Explanation {
            operator: operator.name.clone(),
            option: partition.option.clone(),
            rows: partition.rows.concat(),
            looks_at: partition.looks_at.clone(),
            n_positive: partition.n_positive,
            n_negative: partition.n_negative,
            score: partition.score,
            probability: operator.probability,
            needs: symbols(&operator.needs)?,
            place: match &operator.place {
                Some(name) => {
                    let place = self.places.iter().find(|p| p.name == *name);
                    Some(place.cloned().ok_or_else(|| dangling("place", name))?)
                }
                None => None,
            },
            outcomes: outcomes.collect::<Result<_, _>>()?,
        })
    }
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
        if let Some(place) = &self.place {
            writeln!(f, "    {place}")?;
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
            if outcome.depends_on_start {
                writeln!(f, "    more precisely, where depends on the start")?;
            }
            if !outcome.deletes.is_empty() {
                writeln!(f, "    no more: {}", outcome.deletes.join(", "))?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for SymbolRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = values(&self.variables, &self.means, &self.deviations);
        write!(f, "{}: {values} ({} samples)", self.name, self.n_samples)
    }
}

impl fmt::Display for PlaceRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            reliability,
            n_positive,
            n_negative,
            ..
        } = self;
        let values = values(&self.variables, &self.means, &self.deviations);
        write!(
            f,
            "{name}: {values} (it could from {n_positive} places, not from {n_negative}; {:.1} % of those offered are right)",
            100.0 * reliability
        )
    }
}

fn values(variables: &[String], means: &[f64], deviations: &[f64]) -> String {
    let values: Vec<_> = (variables.iter().zip(means).zip(deviations))
        .map(|((name, mean), deviation)| format!("{name} = {mean:.3} ± {deviation:.3}"))
        .collect();
    values.join(", ")
}
