//! The objects of a home, made of many detections.
//!
//! A detection belongs to the nearest known object of its class, if that is within the gate; otherwise it is
//! a new object. Position and heading of an object are means weighted by inverse variance, which grows
//! with the distance from which it was seen and with the robot's own uncertainty. How it is turned is learned from
//! detections that are sure of it, once there is one.

use crate::detect::Detection;
use factotum_geometry::Pose;
use nalgebra::{Point3, UnitQuaternion, Vector3};

/// Number of a tracked object; never used twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u32);

/// Settings of an [`ObjectTracker`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerParams {
    /// Detections farther than this from an object are another one (m).
    pub gate_m: f64,
    /// Standard deviation of a detection's position at zero distance (m).
    pub sigma_m: f64,
    /// What each metre of distance adds to it (m/m).
    pub sigma_per_m: f64,
    /// Most weight an object's past has, as the standard deviation it may claim (m): it can still follow.
    pub sigma_floor_m: f64,
}

impl Default for TrackerParams {
    fn default() -> Self {
        Self {
            gate_m: 0.35,
            sigma_m: 0.01,
            sigma_per_m: 0.01,
            sigma_floor_m: 0.003,
        }
    }
}

/// An object seen once or more.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedObject {
    /// Its number.
    pub id: TrackId,
    /// Its class.
    pub class: String,
    /// Where it is.
    pub map_from_object: Pose,
    /// Standard deviation of its position (m).
    pub sigma_m: f64,
    /// Detections it is made of.
    pub n_seen: usize,
    /// Whether its heading about Λ's z axis means nothing.
    pub is_yaw_symmetric: bool,
    /// Whether any detection was sure of how it is turned.
    pub is_turn_sure: bool,
    /// Whether it belongs to the building.
    pub is_fixed: bool,
    /// Best share of points explained by the model in any detection.
    pub fitness_max: f64,
}

/// Objects found so far.
#[derive(Debug, Clone)]
pub struct ObjectTracker {
    params: TrackerParams,
    objects: Vec<TrackedObject>,
    n_ids: u32,
}

impl ObjectTracker {
    /// A tracker that knows no object.
    #[must_use]
    pub fn new(params: TrackerParams) -> Self {
        Self {
            params,
            objects: Vec::new(),
            n_ids: 0,
        }
    }

    /// The objects, in order of their first sighting.
    #[must_use]
    pub fn objects(&self) -> &[TrackedObject] {
        &self.objects
    }

    /// One object.
    #[must_use]
    pub fn object(&self, id: TrackId) -> Option<&TrackedObject> {
        self.objects.iter().find(|object| object.id == id)
    }

    /// Adds the detections of one image taken at `map_from_base`, whose position is known to
    /// `base_sigma_m`; returns the object each became part of.
    ///
    /// Within one image no object takes two detections: the nearest pairs are joined first.
    pub fn observe(
        &mut self,
        map_from_base: &Pose,
        base_sigma_m: f64,
        detections: &[Detection],
    ) -> Vec<TrackId> {
        let poses: Vec<Pose> = detections
            .iter()
            .map(|d| map_from_base * d.base_from_object)
            .collect();
        let partners = self.associate(detections, &poses);
        detections
            .iter()
            .zip(&poses)
            .zip(partners)
            .map(|((detection, pose), partner)| {
                let sigma_m = (self.params.sigma_m
                    + self.params.sigma_per_m * detection.distance_m)
                    .hypot(base_sigma_m);
                match partner {
                    Some(i) => self.fuse(i, detection, pose, sigma_m),
                    None => self.add(detection, pose, sigma_m),
                }
            })
            .collect()
    }

    /// Doubts where an object is, down to a standard deviation (m): what is seen next counts for more than what was
    /// seen so far, from elsewhere or before it was touched.
    pub fn doubt(&mut self, id: TrackId, sigma_m: f64) {
        for object in self.objects.iter_mut().filter(|object| object.id == id) {
            object.sigma_m = object.sigma_m.max(sigma_m);
        }
    }

    /// Forgets an object that is no longer there; returns it.
    pub fn forget(&mut self, id: TrackId) -> Option<TrackedObject> {
        let at = self.objects.iter().position(|object| object.id == id)?;
        Some(self.objects.remove(at))
    }

    /// Index of the object of each detection.
    fn associate(&self, detections: &[Detection], poses: &[Pose]) -> Vec<Option<usize>> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, (detection, pose)) in detections.iter().zip(poses).enumerate() {
            for (j, object) in self.objects.iter().enumerate() {
                let apart_m = (place(pose) - place(&object.map_from_object)).norm();
                if object.class == detection.class && apart_m <= self.params.gate_m {
                    pairs.push((apart_m, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut partners = vec![None; detections.len()];
        let mut is_taken = vec![false; self.objects.len()];
        for (_, i, j) in pairs {
            if partners[i].is_none() && !is_taken[j] {
                partners[i] = Some(j);
                is_taken[j] = true;
            }
        }
        partners
    }

    fn add(&mut self, detection: &Detection, map_from_object: &Pose, sigma_m: f64) -> TrackId {
        let id = TrackId(self.n_ids);
        self.n_ids += 1;
        self.objects.push(TrackedObject {
            id,
            class: detection.class.clone(),
            map_from_object: *map_from_object,
            sigma_m,
            n_seen: 1,
            is_yaw_symmetric: detection.is_yaw_symmetric,
            is_turn_sure: detection.is_turn_sure,
            is_fixed: detection.is_fixed,
            fitness_max: detection.fitness,
        });
        id
    }

    fn fuse(&mut self, i: usize, detection: &Detection, pose: &Pose, sigma_m: f64) -> TrackId {
        let floor_m = self.params.sigma_floor_m;
        let object = &mut self.objects[i];
        let (old, new) = (
            object.sigma_m.max(floor_m).powi(-2),
            sigma_m.max(floor_m).powi(-2),
        );
        let share = new / (old + new);
        let turn_share = match (object.is_turn_sure, detection.is_turn_sure) {
            (true, false) => 0.0,
            (false, true) => 1.0,
            (true, true) | (false, false) => share,
        };
        let rotation = mean_rotation(
            &object.map_from_object.rotation,
            &pose.rotation,
            turn_share,
            object.is_yaw_symmetric,
        );
        let translation = object
            .map_from_object
            .translation
            .vector
            .lerp(&pose.translation.vector, share);
        object.map_from_object = Pose::from_parts(translation.into(), rotation);
        object.sigma_m = (old + new).recip().sqrt().max(floor_m);
        object.is_turn_sure |= detection.is_turn_sure;
        object.n_seen += 1;
        object.fitness_max = object.fitness_max.max(detection.fitness);
        object.id
    }
}

/// Rotation `share` of the way from `old` to `new`; only the z axis moves when the heading means nothing.
fn mean_rotation(
    old: &UnitQuaternion<f64>,
    new: &UnitQuaternion<f64>,
    share: f64,
    is_yaw_symmetric: bool,
) -> UnitQuaternion<f64> {
    let step = if is_yaw_symmetric {
        let (z_old, z_new) = (old * Vector3::z(), new * Vector3::z());
        // Opposite axes have no shortest turn: keep the old one.
        UnitQuaternion::scaled_rotation_between(&z_old, &z_new, share)
            .unwrap_or_else(UnitQuaternion::identity)
    } else {
        (new * old.inverse()).powf(share)
    };
    let mut mean = step * old;
    mean.renormalize();
    mean
}

fn place(pose: &Pose) -> Point3<f64> {
    Point3::from(pose.translation.vector)
}

#[cfg(test)]
mod tests;
