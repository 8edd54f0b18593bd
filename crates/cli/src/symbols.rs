//! `factotum symbols`: from recorded transitions to symbols and operators to plan with.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Subcommand};
use factotum_experiments::storage::{StorageError, write_atomically};
use factotum_symbols::model::{
    IndependenceRecord, LearnParams, LeftOutRecord, ModelRecord, Stage, SymbolicModel,
};
use factotum_symbols::partition::LeftOutReason;
use factotum_symbols::spatial::{SpatialParams, Verdict};
use factotum_symbols::transitions::{Transitions, read_csv};
use factotum_task_planning::pddl::{DeterminiseOptions, determinise, write_domain, write_problem};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use serde_json::json;

use crate::console::{Answer, Console, usage};

/// The files of a learned model, in its folder.
mod files {
    /// What was learned, by names, with what it stands on.
    pub(super) const MODEL: &str = "model.toml";
    /// Every operator's explanation.
    pub(super) const EXPLANATIONS: &str = "explanations.txt";
    /// The operators, one for each outcome, with costs of -1000 ln p.
    pub(super) const DOMAIN: &str = "domain.pddl";
    /// The problem to that domain.
    pub(super) const PROBLEM: &str = "problem.pddl";
    /// The operators with their probabilities.
    pub(super) const PROBABILISTIC_DOMAIN: &str = "domain.ppddl";
    /// The problem to that domain.
    pub(super) const PROBABILISTIC_PROBLEM: &str = "problem.ppddl";
}

/// Arguments of `factotum symbols`.
#[derive(Debug, Subcommand)]
pub(crate) enum SymbolsCommand {
    /// Learn symbols and operators from recorded transitions, and write them as PDDL.
    Learn(LearnArgs),
    /// Say why a learned operator is as it is.
    Explain {
        /// Folder that `symbols learn` wrote.
        model: PathBuf,
        /// The operator.
        operator: String,
    },
    /// Give learned symbols or operators names of your own.
    Rename {
        /// Folder that `symbols learn` wrote.
        model: PathBuf,
        /// What is called how.
        #[arg(required = true, value_name = "OLD=NEW", value_parser = parse_rename)]
        names: Vec<Rename>,
    },
}

/// Arguments of `factotum symbols learn`.
#[derive(Debug, Args)]
pub(crate) struct LearnArgs {
    /// Table of transitions: CSV, plain or packed by gzip. docs/symbols.md names its columns.
    transitions: PathBuf,
    /// Folder to write the model to.
    #[arg(long)]
    out: PathBuf,
    /// Seed of all that is drawn.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Learn from the first rows only.
    #[arg(long, value_name = "N")]
    rows: Option<usize>,
    /// The variables of the base's pose: where the base must be is learned apart from the rest.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    spatial: Vec<String>,
    /// Give a symbol, a place or an operator a name of your own; may be given again.
    #[arg(long, value_name = "OLD=NEW", value_parser = parse_rename)]
    rename: Vec<Rename>,
    /// Explain this operator when done.
    #[arg(long, value_name = "OPERATOR")]
    explain: Option<String>,
}

/// Another name.
#[derive(Debug, Clone)]
pub(crate) struct Rename {
    from: String,
    to: String,
}

fn parse_rename(text: &str) -> Result<Rename, String> {
    match text.split_once('=') {
        Some((from, to)) if !from.is_empty() && !to.is_empty() => Ok(Rename {
            from: from.to_owned(),
            to: to.to_owned(),
        }),
        _ => Err("expected OLD=NEW".to_owned()),
    }
}

/// Runs `factotum symbols`.
pub(crate) fn symbols(command: &SymbolsCommand, console: &Console) -> anyhow::Result<Answer> {
    match command {
        SymbolsCommand::Learn(args) => learn(args, console)?,
        SymbolsCommand::Explain { model, operator } => {
            let explanation = read_model(model)?.explain(operator).map_err(usage)?;
            console.answer(&explanation, || explanation.to_string())?;
        }
        SymbolsCommand::Rename { model, names } => {
            let mut record = read_model(model)?;
            rename(&mut record, names)?;
            write_model(&record, model)?;
            console.answer(&json!({"renamed": names.len()}), || {
                format!("{} renamed in `{}`", names.len(), model.display())
            })?;
        }
    }
    Ok(Answer::Yes)
}

fn learn(args: &LearnArgs, console: &Console) -> anyhow::Result<()> {
    if let Some(file) = (files_of(&args.out).into_iter()).find(|file| file.exists()) {
        return Err(usage(format!(
            "`{}` exists already; nothing was written",
            file.display()
        )));
    }
    let mut stages = StageClock::begin();
    console.progress("reading transitions");
    let transitions = read_transitions(args)?;
    stages.end("read");
    let spatial = spatial_params(&args.spatial, &transitions)?;
    console.progress(format!(
        "dividing the options of {} transitions",
        transitions.len()
    ));
    let mut rng = ChaCha8Rng::seed_from_u64(args.seed);
    let mut on_stage = |stage: Stage| {
        stages.end(&stage.to_string());
        console.progress(what_follows(stage));
    };
    let params = LearnParams {
        spatial,
        ..LearnParams::default()
    };
    let model = SymbolicModel::learn(&transitions, &params, &mut rng, &mut on_stage);
    let mut record = model.record();
    if record.operators.is_empty() {
        return Err(usage(format!(
            "`{}`: no operator can be learned; of {} transitions {}",
            args.transitions.display(),
            transitions.len(),
            left_out_notes(&record).join(", ")
        )));
    }
    rename(&mut record, &args.rename)?;
    let explanation = match &args.explain {
        Some(operator) => Some(record.explain(operator).map_err(usage)?),
        None => None,
    };
    std::fs::create_dir_all(&args.out)
        .map_err(|error| StorageError::writing(&args.out, error))
        .map_err(usage)?;
    write_model(&record, &args.out)?;
    stages.end("write");
    for note in notes(&record) {
        console.say(note);
    }
    let mut summary = model.summary(&[]);
    summary.stage_secs = stages.secs;
    let mut document = serde_json::to_value(&summary)?;
    document["rows"] = transitions.len().into();
    document["seed"] = args.seed.into();
    document["start"] = json!(record.start);
    document["goal"] = json!(record.goal);
    document["left_out"] = json!(record.left_out);
    document["not_subgoal"] = (record.partitions.iter().map(|p| p.not_subgoal.len()))
        .sum::<usize>()
        .into();
    if let Some(space) = model.space() {
        document["places"] = json!(space.places.len());
        document["independence"] = json!(record.independence);
        document["operators_without_place"] = space.n_operators_without_place.into();
    }
    if let Some(explanation) = &explanation {
        document["explanation"] = json!(explanation);
    }
    console.answer(&document, || {
        let learned = format!(
            "{} symbols and {} operators from {} transitions in `{}`",
            summary.symbols,
            summary.operators,
            transitions.len(),
            args.out.display()
        );
        match &explanation {
            Some(explanation) => format!("{learned}\n{explanation}"),
            None => learned,
        }
    })
}

/// What is being done when a stage is over.
fn what_follows(stage: Stage) -> &'static str {
    match stage {
        Stage::Partition => "learning preconditions",
        Stage::Preconditions => "learning effects",
        Stage::Effects => "making operators",
        Stage::Operators => "learning the goal",
        Stage::Goal => "writing",
    }
}

/// Wall seconds of what was done one after another.
struct StageClock {
    begun: Instant,
    secs: BTreeMap<String, f64>,
}

impl StageClock {
    fn begin() -> Self {
        Self {
            begun: Instant::now(),
            secs: BTreeMap::new(),
        }
    }

    fn end(&mut self, stage: &str) {
        let secs = self.begun.elapsed().as_secs_f64();
        self.secs
            .insert(stage.to_owned(), (1e3 * secs).round() / 1e3);
        self.begun = Instant::now();
    }
}

fn read_transitions(args: &LearnArgs) -> anyhow::Result<Transitions> {
    let path = args.transitions.display();
    let file = File::open(&args.transitions)
        .map_err(|error| usage(format!("cannot read `{path}`: {error}")))?;
    let transitions = read_csv(file).map_err(|error| usage(format!("`{path}`: {error}")))?;
    if transitions.is_empty() {
        return Err(usage(format!("`{path}` has a header and no transitions")));
    }
    Ok(match args.rows {
        Some(0) => return Err(usage("--rows is 0, expected 1 or more")),
        Some(n) => transitions.first(n),
        None => transitions,
    })
}

/// The variables of the base's pose, by name.
fn spatial_params(
    names: &[String],
    transitions: &Transitions,
) -> anyhow::Result<Option<SpatialParams>> {
    let known = transitions.variables();
    let place = |name: &String| {
        (known.iter().position(|v| v == name)).ok_or_else(|| {
            usage(format!(
                "--spatial names variable `{name}`; available: `{}`",
                known.join("`, `")
            ))
        })
    };
    let variables = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    if variables.len() == known.len() {
        return Err(usage(
            "--spatial names every variable; nothing is left to learn symbols of",
        ));
    }
    Ok((!variables.is_empty()).then(|| SpatialParams::new(variables)))
}

fn rename(record: &mut ModelRecord, names: &[Rename]) -> anyhow::Result<()> {
    for Rename { from, to } in names {
        record.rename(from, to).map_err(usage)?;
    }
    Ok(())
}

/// What people should know of a model before they plan with it.
fn notes(record: &ModelRecord) -> Vec<String> {
    let mut notes = Vec::new();
    if record.goal.is_none() {
        notes.push(
            "the goal was never reached, or is like no symbols: problem.pddl has no plan"
                .to_owned(),
        );
    }
    let runs = |option: &String| record.partitions.iter().any(|p| p.option == *option);
    let unused: Vec<_> = (record.options.iter().filter(|option| !runs(option)))
        .map(|option| format!("`{option}`"))
        .collect();
    if !unused.is_empty() {
        notes.push(format!("no operator runs {}", unused.join(", ")));
    }
    let n_not_subgoal: usize = record.partitions.iter().map(|p| p.not_subgoal.len()).sum();
    if n_not_subgoal > 0 {
        notes.push(format!(
            "{n_not_subgoal} outcomes end where their start says, within what their symbols allow: they are no subgoals"
        ));
    }
    for tested in &record.independence {
        let IndependenceRecord { option, place, .. } = tested;
        notes.push(match tested.verdict {
            Verdict::Holds => format!("`{option}`: where it can run does not depend on the rest ({place})"),
            Verdict::Fails => format!(
                "`{option}`: where it can run depends on the rest; each operator has places of its own ({place}-...)"
            ),
            Verdict::Untested => format!(
                "`{option}`: too little was seen to test whether where it can run depends on the rest; taken as if not ({place})"
            ),
        });
    }
    notes
}

/// Why transitions were of no use.
fn left_out_notes(record: &ModelRecord) -> Vec<String> {
    let note = |left_out: &LeftOutRecord| {
        let why = match left_out.reason {
            LeftOutReason::NoChange => "changed nothing",
            LeftOutReason::OnlyMoved => "moved the base alone",
            LeftOutReason::TooFew => "are too few of their kind",
            LeftOutReason::Noise => "ended each somewhere else",
        };
        format!("{} of option `{}` {why}", left_out.n_rows, left_out.option)
    };
    record.left_out.iter().map(note).collect()
}

fn files_of(folder: &Path) -> [PathBuf; 6] {
    [
        files::MODEL,
        files::EXPLANATIONS,
        files::DOMAIN,
        files::PROBLEM,
        files::PROBABILISTIC_DOMAIN,
        files::PROBABILISTIC_PROBLEM,
    ]
    .map(|name| folder.join(name))
}

fn read_model(folder: &Path) -> anyhow::Result<ModelRecord> {
    let file = folder.join(files::MODEL);
    let text = std::fs::read_to_string(&file)
        .map_err(|error| usage(StorageError::reading(&file, error)))?;
    toml::from_str(&text).map_err(|error| usage(format!("`{}`: {error}", file.display())))
}

/// Writes all files of a model; the folder must be there.
fn write_model(record: &ModelRecord, folder: &Path) -> anyhow::Result<()> {
    let domain = record.domain("learned")?;
    let problem = record.problem("learned-goal", &domain)?;
    let costs = determinise(&domain, &problem, &DeterminiseOptions::default())?;
    let mut explanations = String::new();
    for operator in &record.operators {
        let explanation = record.explain(&operator.name).map_err(usage)?;
        explanations.push_str(&format!("{explanation}\n"));
    }
    let texts = [
        (files::MODEL, toml::to_string(record)?),
        (files::EXPLANATIONS, explanations),
        (files::DOMAIN, write_domain(&costs.domain)),
        (files::PROBLEM, write_problem(&costs.problem)),
        (files::PROBABILISTIC_DOMAIN, write_domain(&domain)),
        (files::PROBABILISTIC_PROBLEM, write_problem(&problem)),
    ];
    for (name, text) in texts {
        write_atomically(&folder.join(name), text.as_bytes()).map_err(usage)?;
    }
    Ok(())
}
