//! Plans: sequences of operators applied to objects.

/// A ground fact, such as `(on mug table)`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Atom {
    /// Name of the predicate or function.
    pub symbol: String,
    /// Names of the objects.
    pub args: Vec<String>,
}

impl Atom {
    /// The symbol applied to the objects.
    pub fn new<A: Into<String>>(
        symbol: impl Into<String>,
        args: impl IntoIterator<Item = A>,
    ) -> Self {
        Self {
            symbol: symbol.into(),
            args: args.into_iter().map(Into::into).collect(),
        }
    }
}

impl std::fmt::Display for Atom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write_application(f, &self.symbol, &self.args)
    }
}

/// An operator with objects for its parameters, such as `(pick bottle)`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GroundAction {
    /// Name of the operator.
    pub name: String,
    /// One object for each parameter, in order.
    pub args: Vec<String>,
}

impl GroundAction {
    /// The operator applied to the objects.
    pub fn new<A: Into<String>>(
        name: impl Into<String>,
        args: impl IntoIterator<Item = A>,
    ) -> Self {
        Self {
            name: name.into(),
            args: args.into_iter().map(Into::into).collect(),
        }
    }
}

impl std::fmt::Display for GroundAction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write_application(f, &self.name, &self.args)
    }
}

fn write_application(
    f: &mut std::fmt::Formatter<'_>,
    head: &str,
    args: &[String],
) -> std::fmt::Result {
    write!(f, "({head}")?;
    for arg in args {
        write!(f, " {arg}")?;
    }
    f.write_str(")")
}

/// A sequence of actions and what it costs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// The actions, first to last.
    pub steps: Vec<GroundAction>,
    /// Sum of the operators' costs; the number of steps where the domain has no costs.
    pub cost: f64,
}

impl std::fmt::Display for Plan {
    /// One action a line, as planners write plan files.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for step in &self.steps {
            writeln!(f, "{step}")?;
        }
        Ok(())
    }
}
