//! Objects of known classes in a segmented depth image.
//!
//! The segmenter says which pixels belong to an instance of which class; depth makes them points; the
//! object's pose is where the class model's surface lies on them. Registration starts from many poses,
//! since it only finds the nearest minimum: the model is turned about the vertical when the class stands
//! upright, over the 24 turns of a cube and the principal axes otherwise, and put with the centre of its
//! *visible* surface (the part that faces the camera) on the centre of the points. Each start is refined by
//! point-to-plane ICP onto the visible surface only, so that a thin object is not pulled to its back. The
//! best fit has the least truncated distance of the points to the model plus the share of the model that
//! the camera contradicts, by looking *through* it or by seeing something else there: a big object may not
//! explain a small patch, nor the leaf of a door the wall beside it.
//!
//! What stands on the floor is put there: the robot's base frame has its origin on the floor.
//!
//! A movable object that usually stands upright may have fallen over: where standing explains the points badly, lying
//! is tried as well.

use crate::sensing::{DepthFrame, DepthFrameError};
use factotum_geometry::Pose;
use factotum_geometry::cloud::PointCloud;
use factotum_geometry::icp::{IcpFreedom, IcpParams, IcpTarget};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// What a class of objects looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassModel {
    /// Name, as the segmenter says it.
    pub name: String,
    /// Samples of the surface with outward normals, in the class's frame Λ, joints at their usual position.
    pub surface: PointCloud,
    /// Whether turning it about Λ's z axis changes nothing.
    pub is_yaw_symmetric: bool,
    /// Whether Λ's z axis points up: always if it is fixed, else unless it has fallen over.
    pub is_upright: bool,
    /// Whether it belongs to the building, so that it never moves.
    pub is_fixed: bool,
    /// Whether Λ lies on the floor while it is upright: a smooth leaf of a door does not tell its own height.
    pub is_on_floor: bool,
}

/// Settings of a [`Detector`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectParams {
    /// Fewest points of an instance.
    pub n_points_min: usize,
    /// Points are thinned to one per voxel of this edge (m).
    pub voxel_m: f64,
    /// Most points of the observation that are used.
    pub n_points_max: usize,
    /// Most samples of a model that are used. Their spacing bounds how small a feature (a handle) can tell.
    pub n_samples_max: usize,
    /// Points farther than this from the model count as not explained (m).
    pub outlier_m: f64,
    /// Headings tried for a class that stands upright.
    pub n_yaw_starts: usize,
    /// Least share of the points that the model must explain.
    pub fitness_min: f64,
}

impl Default for DetectParams {
    fn default() -> Self {
        Self {
            n_points_min: 12,
            voxel_m: 0.005,
            n_points_max: 400,
            n_samples_max: 4000,
            outlier_m: 0.015,
            n_yaw_starts: 12,
            fitness_min: 0.5,
        }
    }
}

/// An object that was seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Its class.
    pub class: String,
    /// The instance's label in the image.
    pub label: u16,
    /// Pose of its frame Λ in the robot's base frame.
    pub base_from_object: Pose,
    /// Root mean square distance of the explained points to the model (m).
    pub rms_m: f64,
    /// Points it was fitted to.
    pub n_points: usize,
    /// Share of the points within [`DetectParams::outlier_m`] of the model.
    pub fitness: f64,
    /// How far the object was from the camera (m).
    pub distance_m: f64,
    /// Whether its heading about Λ's z axis means nothing.
    pub is_yaw_symmetric: bool,
    /// Whether turning it otherwise explains the points clearly worse. From afar, small things may be turned anyhow.
    pub is_turn_sure: bool,
    /// Whether it belongs to the building.
    pub is_fixed: bool,
}

/// A class that cannot be detected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DetectError {
    /// The surface has no normals or hardly any points.
    #[error(
        "class `{class}` has {n_points} surface points with {n_normals} normals, expected at least {wanted} of each"
    )]
    Model {
        /// The class.
        class: String,
        /// Points of its surface.
        n_points: usize,
        /// Normals of its surface.
        n_normals: usize,
        /// Points wanted.
        wanted: usize,
    },
    /// Two models have one name.
    #[error("class `{class}` is given twice")]
    RepeatedClass {
        /// The class.
        class: String,
    },
}

/// Finds objects of known classes.
#[derive(Debug, Clone)]
pub struct Detector {
    params: DetectParams,
    models: Vec<ClassModel>,
    /// The same models with [`N_SAMPLES_ROUGH`] samples, in the same order.
    rough_models: Vec<ClassModel>,
}

/// Samples of a model for the first look at a start.
const N_SAMPLES_ROUGH: usize = 600;

/// A standing fit that costs more may be of an object that lies.
const DOUBTFUL_COST: f64 = 0.35;
/// Fewer points than these do not tell lying from standing.
const N_LYING_MIN: usize = 30;
/// Lying must cost less than this share of standing.
const LYING_GAIN: f64 = 0.7;

/// Fits turned by less than this are of one turn, radians.
const SAME_TURN_RAD: f64 = 0.4;
/// Other turns must cost this many times more for a turn to be sure.
const TURN_CONTRAST: f64 = 1.5;

/// How an object may be turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Posture {
    /// Λ's z axis up.
    Standing,
    /// Fallen over.
    Lying,
    /// Any.
    Any,
}

/// A model laid onto the points of an instance.
struct Fit {
    base_from_object: Pose,
    rms_m: f64,
    fitness: f64,
    /// Less is better.
    cost: f64,
    /// Whether other turns cost clearly more.
    is_turn_sure: bool,
}

/// One instance's points and what the camera saw around it.
#[derive(Clone)]
struct View<'a> {
    frame: &'a DepthFrame,
    label: u16,
    points: Vec<Point3<f64>>,
    center: Point3<f64>,
    camera: Point3<f64>,
}

impl Detector {
    /// Detector for these classes; samples beyond [`DetectParams::n_samples_max`] are thinned evenly.
    ///
    /// # Errors
    /// [`DetectError`] when a model has too few points or no normals, or a name comes twice.
    pub fn new(models: Vec<ClassModel>, params: DetectParams) -> Result<Self, DetectError> {
        let wanted = params.n_points_min.max(3);
        let mut thinned: Vec<ClassModel> = Vec::with_capacity(models.len());
        for model in models {
            let (n_points, n_normals) = (
                model.surface.len(),
                model.surface.normals().map_or(0, <[_]>::len),
            );
            if n_points < wanted || n_normals != n_points {
                return Err(DetectError::Model {
                    class: model.name,
                    n_points,
                    n_normals,
                    wanted,
                });
            }
            if thinned.iter().any(|other| other.name == model.name) {
                return Err(DetectError::RepeatedClass { class: model.name });
            }
            let surface = evenly(&model.surface, params.n_samples_max);
            thinned.push(ClassModel { surface, ..model });
        }
        let rough_models = thinned
            .iter()
            .map(|model| ClassModel {
                surface: evenly(&model.surface, N_SAMPLES_ROUGH),
                ..model.clone()
            })
            .collect();
        Ok(Self {
            params,
            models: thinned,
            rough_models,
        })
    }

    /// The classes.
    #[must_use]
    pub fn models(&self) -> &[ClassModel] {
        &self.models
    }

    /// The objects in an image, by label. Labels of unknown classes, with too few points or without a
    /// fitting pose are left out.
    ///
    /// # Errors
    /// [`DepthFrameError`] when the image contradicts itself.
    pub fn detect(&self, frame: &DepthFrame) -> Result<Vec<Detection>, DepthFrameError> {
        frame.check()?;
        let labels = 1..=u16::try_from(frame.label_classes.len()).unwrap_or(u16::MAX);
        Ok(labels
            .filter_map(|label| self.detect_label(frame, label))
            .collect())
    }

    fn detect_label(&self, frame: &DepthFrame, label: u16) -> Option<Detection> {
        let class = &frame.label_classes[usize::from(label) - 1];
        let model_idx = self.models.iter().position(|model| model.name == *class)?;
        let model = &self.models[model_idx];
        let seen = frame.cloud_in_base(|l| l == label);
        if seen.len() < self.params.n_points_min {
            return None;
        }
        let seen = largest_cluster(&seen);
        let n_points = seen.len();
        let seen = evenly(
            &seen.voxel_downsampled(self.params.voxel_m),
            self.params.n_points_max,
        );
        let view = View {
            frame,
            label,
            center: seen.centroid()?,
            points: seen.points().to_vec(),
            camera: frame.base_from_optical.translation.vector.into(),
        };
        if view.points.len() < self.params.n_points_min {
            return None;
        }
        let models = [model, &self.rough_models[model_idx]];
        let usual = if model.is_upright {
            Posture::Standing
        } else {
            Posture::Any
        };
        let mut best = self.best_fit(models, &view, usual);
        let is_doubtful = best.as_ref().is_none_or(|fit| fit.cost > DOUBTFUL_COST);
        let may_lie = model.is_upright && !model.is_fixed && n_points >= N_LYING_MIN;
        if may_lie && is_doubtful {
            let lying = self.best_fit(models, &view, Posture::Lying);
            let cost_max = best
                .as_ref()
                .map_or(f64::INFINITY, |fit| LYING_GAIN * fit.cost);
            best = lying.filter(|fit| fit.cost < cost_max).or(best);
        }
        let best = best?;
        (best.fitness >= self.params.fitness_min).then(|| Detection {
            class: model.name.clone(),
            label,
            base_from_object: best.base_from_object,
            rms_m: best.rms_m,
            n_points,
            fitness: best.fitness,
            distance_m: (view.center - view.camera).norm(),
            is_yaw_symmetric: model.is_yaw_symmetric,
            is_turn_sure: best.is_turn_sure,
            is_fixed: model.is_fixed,
        })
    }

    /// The best of all starts: each is tried on few points, the most promising on all.
    fn best_fit(
        &self,
        [model, rough_model]: [&ClassModel; 2],
        view: &View<'_>,
        posture: Posture,
    ) -> Option<Fit> {
        /// Points for the first look at a start.
        const N_POINTS_ROUGH: usize = 80;
        /// Starts that are looked at closely.
        const N_CLOSE: usize = 4;
        let starts = starts(model, view, posture, self.params.n_yaw_starts);
        let rough = View {
            points: spread(&view.points, N_POINTS_ROUGH),
            ..*view
        };
        let mut tried: Vec<Fit> = starts
            .into_iter()
            .filter_map(|turn| start_pose(rough_model, &rough, turn))
            .filter_map(|start| self.fit(rough_model, &rough, posture, start, &[8.0, 3.0]))
            .collect();
        // Stable: of equal fits the earlier start comes first.
        tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let starts = distinct(&tried, N_CLOSE);
        let close = |fit: &Fit| {
            let start = if model.is_fixed {
                self.slid(rough_model, &rough, fit.base_from_object)
            } else {
                fit.base_from_object
            };
            self.fit(model, view, posture, start, &[3.0, 1.5])
        };
        let mut best = starts
            .into_iter()
            .filter_map(close)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let is_other = |fit: &Fit| {
            let (a, b) = (best.base_from_object, fit.base_from_object);
            a.rotation.angle_to(&b.rotation) > SAME_TURN_RAD
        };
        let other = tried.iter().find(|fit| is_other(fit)).and_then(close);
        best.is_turn_sure =
            other.is_none_or(|other| !is_other(&other) || other.cost > TURN_CONTRAST * best.cost);
        Some(best)
    }

    /// The model refined from one pose, with pairs up to each of `reaches` outlier distances apart, each time
    /// onto the surface that faces the camera from there.
    fn fit(
        &self,
        model: &ClassModel,
        view: &View<'_>,
        posture: Posture,
        start: Pose,
        reaches: &[f64],
    ) -> Option<Fit> {
        let grounded = |mut pose: Pose| {
            if model.is_on_floor && posture == Posture::Standing {
                pose.translation.z = 0.0;
            }
            pose
        };
        let mut base_from_object = grounded(start);
        for reach in reaches {
            let visible = visible_surface(model, view, &base_from_object);
            let target = IcpTarget::new(&visible).ok()?;
            let params = IcpParams {
                n_iterations_max: 15,
                pair_distance_max_m: reach * self.params.outlier_m,
                n_pairs_min: self.params.n_points_min.min(view.points.len()) / 2 + 1,
                step_translation_m: 1e-5,
                step_rotation_rad: 1e-4,
                freedom: freedom(model, posture),
                ..IcpParams::default()
            };
            // A start too far off stays as it is; its cost will tell.
            if let Ok(result) = target.register(&view.points, &base_from_object.inverse(), &params)
            {
                base_from_object = grounded(result.target_from_source.inverse());
            }
        }
        self.judge(model, view, base_from_object)
    }

    /// A pose shifted to where it costs less: registration does not move a plane along itself, and of a big object the
    /// camera may see a part whose middle is not the object's.
    fn slid(&self, model: &ClassModel, view: &View<'_>, base_from_object: Pose) -> Pose {
        /// Shifts tried, each until it gains nothing more, metres.
        const STEPS_M: [f64; 5] = [0.4, 0.2, 0.1, 0.05, 0.025];
        /// What a shift must gain.
        const GAIN: f64 = 0.01;
        let cost = |pose: &Pose| {
            let fit = self.judge(model, view, *pose);
            fit.map_or(f64::INFINITY, |fit| fit.cost)
        };
        let n_axes = if model.is_on_floor { 2 } else { 3 };
        let mut best = (cost(&base_from_object), base_from_object);
        for step_m in STEPS_M {
            for axis in 0..n_axes {
                for signed_m in [-step_m, step_m] {
                    let mut shift = Translation3::identity();
                    shift.vector[axis] = signed_m;
                    loop {
                        let moved = best.1 * shift;
                        let moved_cost = cost(&moved);
                        if moved_cost > best.0 - GAIN {
                            break;
                        }
                        best = (moved_cost, moved);
                    }
                }
            }
        }
        best.1
    }

    fn judge(&self, model: &ClassModel, view: &View<'_>, base_from_object: Pose) -> Option<Fit> {
        let visible = visible_surface(model, view, &base_from_object);
        let target = IcpTarget::new(&visible).ok()?;
        let object_from_base = base_from_object.inverse();
        let outlier_m2 = self.params.outlier_m.powi(2);
        let spacing_m2 = sample_spacing_m2(model);
        // Beyond this a point is an outlier, however far.
        let reach_m = outlier_m2.max(2.0 * spacing_m2).sqrt();
        let mut explained_m2 = 0.0;
        let mut truncated = 0.0;
        let mut n_explained = 0usize;
        for point in &view.points {
            let moved = object_from_base * point;
            let Some((index, m2)) = target.tree().nearest_within(&moved, reach_m) else {
                truncated += outlier_m2;
                continue;
            };
            let normal = visible.normals()?[index];
            let across_m = normal.dot(&(moved - target.points()[index]));
            // Beside a sample is still on the surface, up to the samples' own spacing.
            let off_m2 = if m2 <= 2.0 * spacing_m2 {
                across_m * across_m
            } else {
                m2
            };
            truncated += off_m2.min(outlier_m2);
            if off_m2 <= outlier_m2 {
                explained_m2 += across_m * across_m;
                n_explained += 1;
            }
        }
        let n = view.points.len() as f64;
        let contradicted =
            contradicted_share(view, &visible, &base_from_object, self.params.outlier_m);
        Some(Fit {
            base_from_object,
            rms_m: (explained_m2 / n_explained.max(1) as f64).sqrt(),
            fitness: n_explained as f64 / n,
            cost: truncated / (n * outlier_m2) + contradicted,
            is_turn_sure: true,
        })
    }
}

/// The first `n_max` fits that are not the same pose again.
fn distinct(fits: &[Fit], n_max: usize) -> Vec<&Fit> {
    /// Fits nearer than this end in the same minimum (m, rad).
    const SAME_M: f64 = 0.02;
    const SAME_RAD: f64 = 0.2;
    let mut kept: Vec<&Fit> = Vec::new();
    for fit in fits {
        let is_new = kept.iter().all(|other| {
            let apart = other.base_from_object.inverse() * fit.base_from_object;
            apart.translation.vector.norm() > SAME_M || apart.rotation.angle() > SAME_RAD
        });
        if is_new && kept.len() < n_max {
            kept.push(fit);
        }
    }
    kept
}

fn freedom(model: &ClassModel, posture: Posture) -> IcpFreedom {
    match (posture, model.is_yaw_symmetric) {
        (Posture::Standing, true) => IcpFreedom::Translation,
        (Posture::Standing, false) => IcpFreedom::Upright,
        (Posture::Lying | Posture::Any, _) => IcpFreedom::Full,
    }
}

/// Orientations of the model in the base frame from which registration starts.
fn starts(
    model: &ClassModel,
    view: &View<'_>,
    posture: Posture,
    n_yaw: usize,
) -> Vec<UnitQuaternion<f64>> {
    let n_yaw = n_yaw.max(1);
    let yaw = |angle| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let headings = (0..n_yaw).map(|i| yaw(TAU * i as f64 / n_yaw as f64));
    let pitch = |angle| UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
    let roll = |angle| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
    match (posture, model.is_yaw_symmetric) {
        (Posture::Standing, true) => return vec![UnitQuaternion::identity()],
        (Posture::Standing, false) => return headings.collect(),
        // Turning a symmetric object about its own axis changes nothing.
        (Posture::Lying, true) => {
            return headings.map(|heading| heading * pitch(FRAC_PI_2)).collect();
        }
        (Posture::Lying, false) | (Posture::Any, _) => {}
    }
    // Any of the six faces down, at eight headings, and the principal axes of points and model matched.
    let faces = [
        roll(0.0),
        roll(FRAC_PI_2),
        roll(2.0 * FRAC_PI_2),
        roll(-FRAC_PI_2),
        pitch(FRAC_PI_2),
        pitch(-FRAC_PI_2),
    ];
    let mut starts: Vec<_> = (0..8)
        .flat_map(|i| faces.map(|face| yaw(TAU * f64::from(i) / 8.0) * face))
        .collect();
    if let (Some(seen), Some(own)) = (
        principal_axes(&view.points),
        principal_axes(model.surface.points()),
    ) {
        for flip in [
            roll(0.0),
            roll(2.0 * FRAC_PI_2),
            pitch(2.0 * FRAC_PI_2),
            yaw(2.0 * FRAC_PI_2),
        ] {
            starts.push(seen * flip * own.inverse());
        }
    }
    starts
}

/// Rotation whose columns are the principal axes of the points, largest extent first.
fn principal_axes(points: &[Point3<f64>]) -> Option<UnitQuaternion<f64>> {
    let n = points.len() as f64;
    let mean = points
        .iter()
        .fold(Vector3::zeros(), |sum, p| sum + p.coords)
        / n.max(1.0);
    let scatter = points.iter().fold(Matrix3::zeros(), |sum, p| {
        let d = p.coords - mean;
        sum + d * d.transpose()
    });
    let eigen = scatter.try_symmetric_eigen(f64::EPSILON, 100)?;
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let x = eigen.eigenvectors.column(order[0]).into_owned();
    let y = eigen.eigenvectors.column(order[1]).into_owned();
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    Some(UnitQuaternion::from_rotation_matrix(&rotation))
}

/// The model turned as told, its visible surface centred on the points.
fn start_pose(model: &ClassModel, view: &View<'_>, turn: UnitQuaternion<f64>) -> Option<Pose> {
    let roughly = Translation3::from(view.center.coords) * turn;
    let visible_center = visible_surface(model, view, &roughly).centroid()?;
    let shift = view.center - turn * visible_center;
    Some(Pose::from_parts(shift.into(), turn))
}

/// The samples of the model that face the camera, in Λ; all of them if none does.
fn visible_surface(model: &ClassModel, view: &View<'_>, base_from_object: &Pose) -> PointCloud {
    let camera_in_object = base_from_object.inverse_transform_point(&view.camera);
    let surface = &model.surface;
    let Some(normals) = surface.normals() else {
        return surface.clone();
    };
    let facing: Vec<usize> = (0..surface.len())
        .filter(|&i| normals[i].dot(&(camera_in_object - surface.points()[i])) > 0.0)
        .collect();
    if facing.len() < 3 {
        surface.clone()
    } else {
        surface.select(&facing)
    }
}

/// Share of the visible samples that the camera contradicts: it saw something behind them, or another thing in their place.
fn contradicted_share(
    view: &View<'_>,
    visible: &PointCloud,
    base_from_object: &Pose,
    margin_m: f64,
) -> f64 {
    let frame = view.frame;
    let optical_from_object = frame.base_from_optical.inverse() * base_from_object;
    let is_contradicted = |point: &&Point3<f64>| {
        let sample = optical_from_object * *point;
        let Some((column, row)) = pixel_of(frame, &sample) else {
            return false;
        };
        let Some(seen) = frame.point_in_optical(column, row) else {
            return false;
        };
        let beyond_m = seen.z - sample.z;
        let label = frame.labels.get(row * frame.width + column);
        let is_other = label.is_some_and(|label| *label != view.label);
        beyond_m > 2.0 * margin_m || (is_other && beyond_m > -2.0 * margin_m)
    };
    let n_contradicted = visible.points().iter().filter(is_contradicted).count();
    n_contradicted as f64 / visible.len().max(1) as f64
}

/// Depth measured where a point of the optical frame projects (m), if it is in the image.
pub(crate) fn depth_at(frame: &DepthFrame, point_in_optical: &Point3<f64>) -> Option<f64> {
    let (column, row) = pixel_of(frame, point_in_optical)?;
    frame.point_in_optical(column, row).map(|p| p.z)
}

/// Pixel to which a point of the optical frame projects, if it is in the image.
pub(crate) fn pixel_of(
    frame: &DepthFrame,
    point_in_optical: &Point3<f64>,
) -> Option<(usize, usize)> {
    if point_in_optical.z <= 1e-6 {
        return None;
    }
    let column = (frame.fx * point_in_optical.x / point_in_optical.z + frame.cx).round();
    let row = (frame.fy * point_in_optical.y / point_in_optical.z + frame.cy).round();
    let is_inside =
        column >= 0.0 && row >= 0.0 && column < frame.width as f64 && row < frame.height as f64;
    is_inside.then_some((column as usize, row as usize))
}

/// Mean squared distance between neighbouring samples of a model (m²), assuming them spread evenly.
fn sample_spacing_m2(model: &ClassModel) -> f64 {
    let Some((low, high)) = model.surface.bounds() else {
        return 0.0;
    };
    let size = high - low;
    let area_m2 = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    area_m2 / model.surface.len() as f64
}

/// At most `n_max` points of a cloud.
fn evenly(cloud: &PointCloud, n_max: usize) -> PointCloud {
    if cloud.len() <= n_max {
        cloud.clone()
    } else {
        cloud.select(&spread_indices(cloud.len(), n_max))
    }
}

/// At most `n_max` of the points.
pub(crate) fn spread(points: &[Point3<f64>], n_max: usize) -> Vec<Point3<f64>> {
    spread_indices(points.len(), n_max)
        .into_iter()
        .map(|i| points[i])
        .collect()
}

/// `n_max` of the indices below `n` (all, if there are not more), in order: one anywhere in each of as many equal parts.
/// Drawn, since any regular choice falls in step with the rows that surfaces are sampled in, and leaves bands without any.
fn spread_indices(n: usize, n_max: usize) -> Vec<usize> {
    if n <= n_max {
        return (0..n).collect();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let part = |i: usize| i * n / n_max;
    (0..n_max)
        .map(|i| rng.random_range(part(i)..part(i + 1)))
        .collect()
}

/// The points without those that depth noise at the object's edge threw far behind or before it: kept are
/// points within three times the median distance from the median point.
fn largest_cluster(cloud: &PointCloud) -> PointCloud {
    let median = |axis: usize| {
        let mut values: Vec<f64> = cloud.points().iter().map(|p| p[axis]).collect();
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let center = Point3::new(median(0), median(1), median(2));
    let mut distances: Vec<f64> = cloud.points().iter().map(|p| (p - center).norm()).collect();
    let middle = distances.len() / 2;
    let reach_m = 4.0 * *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
    cloud.filtered(|p| (p - center).norm() <= reach_m)
}

#[cfg(test)]
mod tests;
