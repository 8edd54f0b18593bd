//! Whether an object that is thought to be somewhere should be in the image, and is.
//!
//! A missing object is noticed only where the camera looked: each sample of its surface that faces the
//! camera is projected into the image and compared with the depth measured there.

use crate::detect::{ClassModel, pixel_of};
use crate::sensing::DepthFrame;
use factotum_geometry::Pose;
use nalgebra::Point3;

/// What an image says about an object at a supposed pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Presence {
    /// The camera saw a surface of this label's class (or, without labels, any) where the object should be.
    Seen {
        /// Share of the visible samples that were confirmed.
        confirmed: f64,
    },
    /// The camera saw past where the object should be: it is not there.
    Gone {
        /// Share of the visible samples behind which something else was seen.
        seen_through: f64,
    },
    /// Something stands in front, or it is neither clearly there nor gone.
    Hidden,
    /// Most of it is outside the image.
    OutOfView,
}

/// Settings of [`presence`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PresenceParams {
    /// Depths this near to the object's surface are the object (m).
    pub margin_m: f64,
    /// Least share of the facing surface that must lie in the image to say anything.
    pub in_view_min: f64,
    /// Share of the samples that decides.
    pub majority: f64,
}

impl Default for PresenceParams {
    fn default() -> Self {
        Self {
            margin_m: 0.03,
            in_view_min: 0.5,
            majority: 0.5,
        }
    }
}

/// What `frame` says about an object of class `model` supposed at `base_from_object`.
#[must_use]
pub fn presence(
    frame: &DepthFrame,
    model: &ClassModel,
    base_from_object: &Pose,
    params: &PresenceParams,
) -> Presence {
    let camera = Point3::from(frame.base_from_optical.translation.vector);
    let camera_in_object = base_from_object.inverse_transform_point(&camera);
    let optical_from_object = frame.base_from_optical.inverse() * base_from_object;
    let normals = model.surface.normals().unwrap_or_default();
    let mut n_facing = 0usize;
    let mut n_in_view = 0usize;
    let mut n_confirmed = 0usize;
    let mut n_through = 0usize;
    for (i, sample) in model.surface.points().iter().enumerate() {
        if normals
            .get(i)
            .is_some_and(|n| n.dot(&(camera_in_object - sample)) <= 0.0)
        {
            continue;
        }
        n_facing += 1;
        let expected = optical_from_object * sample;
        let Some((column, row)) = pixel_of(frame, &expected) else {
            continue;
        };
        let Some(seen) = frame.point_in_optical(column, row) else {
            continue;
        };
        n_in_view += 1;
        if seen.z > expected.z + params.margin_m {
            n_through += 1;
        } else if seen.z >= expected.z - params.margin_m
            && is_class(frame, column, row, &model.name)
        {
            n_confirmed += 1;
        }
    }
    let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
    if share(n_in_view, n_facing) < params.in_view_min {
        return Presence::OutOfView;
    }
    let (confirmed, seen_through) = (share(n_confirmed, n_in_view), share(n_through, n_in_view));
    if confirmed >= params.majority {
        Presence::Seen { confirmed }
    } else if seen_through >= params.majority {
        Presence::Gone { seen_through }
    } else {
        Presence::Hidden
    }
}

fn is_class(frame: &DepthFrame, column: usize, row: usize, class: &str) -> bool {
    match frame.labels.get(row * frame.width + column) {
        None => true,
        Some(0) => false,
        Some(&label) => frame
            .label_classes
            .get(usize::from(label) - 1)
            .is_some_and(|name| name == class),
    }
}

#[cfg(test)]
mod tests;
