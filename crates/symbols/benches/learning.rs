//! Time of clustering, classifiers and densities, on fixed made-up data.

use divan::Bencher;
use factotum_symbols::clustering::{DbscanParams, dbscan};
use factotum_symbols::density::{BandwidthGrid, KernelDensity};
use factotum_symbols::gaussian_process::{GpClassifier, GpPrior};
use factotum_symbols::support_vector::{Kernel, Labelled, SvmGrid};
use factotum_symbols::{Distinct, Samples};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

fn main() {
    divan::main();
}

/// Points in the unit square.
fn square(n: usize) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    Samples::from_rows(
        2,
        (0..n).map(|_| [rng.random::<f64>(), rng.random::<f64>()]),
    )
}

fn is_in_disc(point: &[f64]) -> bool {
    (point[0] - 0.5).hypot(point[1] - 0.5) < 0.3
}

#[divan::bench(args = [1_000, 10_000, 100_000])]
fn dbscan_in_a_square(bencher: Bencher<'_, '_>, n: usize) {
    let distinct = Distinct::of(&square(n));
    let params = DbscanParams {
        epsilon: 0.05,
        min_weight: 5.0,
    };
    bencher.bench(|| dbscan(&distinct.points, &distinct.weights, &params));
}

#[divan::bench(args = [500, 2_000])]
fn svm_grid_on_a_disc(bencher: Bencher<'_, '_>, n: usize) {
    let (inside, outside): (Vec<usize>, Vec<usize>) = {
        let points = square(n);
        (0..n).partition(|&i| is_in_disc(points.row(i)))
    };
    let points = square(n);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let data = Labelled::new(
        &points.select(&inside),
        &points.select(&outside),
        3,
        &mut rng,
    );
    bencher.bench(|| SvmGrid::default().search(&data, &Kernel::new(&data.points)));
}

#[divan::bench(args = [500, 2_000])]
fn density_of_a_square(bencher: Bencher<'_, '_>, n: usize) {
    let points = square(n);
    bencher.bench(|| {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        KernelDensity::fit(&[0, 1], &points, &BandwidthGrid::default(), &mut rng)
    });
}

#[divan::bench(args = [100, 500])]
fn gp_on_a_disc(bencher: Bencher<'_, '_>, n: usize) {
    let points = square(n);
    let labels: Vec<bool> = points.rows().map(is_in_disc).collect();
    bencher.bench(|| GpClassifier::fit(&points, &labels, &GpPrior::default()));
}
