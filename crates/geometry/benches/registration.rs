//! Time of registration, alignment, distance fields and mapping, on fixed made-up data.

use divan::Bencher;
use factotum_geometry::Pose2;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::grid::{
    Cell, CellIndex, DistanceField, GridMapper, GridMapperParams, OccupancyGrid, UnknownCells,
};
use factotum_geometry::icp::{IcpParams, IcpTarget};
use factotum_geometry::sensing::LaserScan;
use nalgebra::{Isometry3, Point3, Vector3};

fn main() {
    divan::main();
}

/// Points on three mutually perpendicular walls, in a low-discrepancy order.
fn corner(n: u32) -> PointCloud {
    let points = (0..n)
        .map(|i| {
            let (u, v) = (f64::from(i) * 0.754_877_666, f64::from(i) * 0.569_840_291);
            let (u, v) = (u.fract() * 3.0, v.fract() * 3.0);
            match i % 3 {
                0 => Point3::new(u, v, 0.0),
                1 => Point3::new(u, 0.0, v),
                _ => Point3::new(0.0, u, v),
            }
        })
        .collect();
    PointCloud::new(points)
}

#[divan::bench(args = [500, 2_000, 8_000])]
fn icp_on_20k_points(bencher: Bencher<'_, '_>, n_source: u32) {
    let cloud = corner(20_000).with_estimated_normals(12, &Point3::new(1.5, 1.5, 1.5));
    let Ok(target) = cloud
        .map_err(drop)
        .and_then(|cloud| IcpTarget::new(&cloud).map_err(drop))
    else {
        return;
    };
    let offset = Isometry3::new(
        Vector3::new(0.05, -0.04, 0.03),
        Vector3::new(0.02, 0.03, -0.05),
    );
    let source = corner(n_source).transformed(&offset);
    let start = Isometry3::identity();
    bencher.bench(|| target.register(source.points(), &start, &IcpParams::default()));
}

#[divan::bench(args = [2_000, 20_000])]
fn normals_of_12_neighbours(bencher: Bencher<'_, '_>, n: u32) {
    let cloud = corner(n);
    bencher.bench(|| cloud.with_estimated_normals(12, &Point3::new(1.5, 1.5, 1.5)));
}

#[divan::bench]
fn voxel_downsample_of_20k_points(bencher: Bencher<'_, '_>) {
    let cloud = corner(20_000);
    bencher.bench(|| cloud.voxel_downsampled(0.05));
}

#[divan::bench(args = [200, 1_000])]
fn distance_field_of_a_square(bencher: Bencher<'_, '_>, side: usize) {
    let Ok(mut grid) = OccupancyGrid::filled(side, side, 0.05, Pose2::identity(), Cell::FREE)
    else {
        return;
    };
    for i in 0..side {
        grid.set_cell(
            CellIndex {
                column: i,
                row: i * i % side,
            },
            Cell::OCCUPIED,
        );
    }
    bencher.bench(|| DistanceField::of(&grid, UnknownCells::Passable));
}

#[divan::bench]
fn mapping_a_scan_of_360_rays(bencher: Bencher<'_, '_>) {
    let scan = LaserScan {
        angle_min_rad: 0.0,
        angle_step_rad: std::f64::consts::TAU / 360.0,
        ranges_m: (0..360).map(|i| 3.0 + f64::from(i % 40) * 0.05).collect(),
        range_min_m: 0.05,
        range_max_m: 10.0,
        base_from_lidar: Pose2::identity(),
    };
    let Ok(mut mapper) = GridMapper::new(GridMapperParams::default()) else {
        return;
    };
    bencher.bench_local(|| mapper.integrate(&Pose2::identity(), &scan));
}
