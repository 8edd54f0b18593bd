//! Learns symbols from recorded transitions and prints what came of it, with the time of each stage:
//! `cargo run --release -p factotum-symbols --example learn_symbols -- TRANSITIONS.csv.gz [N_ROWS [SEED]]`.
#![expect(clippy::print_stdout, reason = "a program that prints")]

use std::error::Error;
use std::fs::File;
use std::time::Instant;

use factotum_symbols::model::{LearnParams, SymbolicModel};
use factotum_symbols::transitions::read_csv;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let path = args
        .next()
        .ok_or("usage: learn_symbols TRANSITIONS [N_ROWS [SEED]]")?;
    let n_rows = args.next().map_or(Ok(usize::MAX), |text| text.parse())?;
    let seed = args.next().map_or(Ok(0), |text| text.parse())?;
    let transitions = read_csv(File::open(path)?)?.first(n_rows);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut stages = Vec::new();
    let mut begun = Instant::now();
    let mut on_stage = |stage| {
        stages.push((stage, begun.elapsed().as_secs_f64()));
        begun = Instant::now();
    };
    let model = SymbolicModel::learn(
        &transitions,
        &LearnParams::default(),
        &mut rng,
        &mut on_stage,
    );
    println!("{}", serde_json::to_string(&model.summary(&stages))?);
    Ok(())
}
