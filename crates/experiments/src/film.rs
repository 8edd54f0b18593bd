//! What happened, as pictures beside each other.

use std::io::{Cursor, Write as _};
use std::path::Path;

use factotum_physics::{PhysicsError, Picture, PinholeCamera, Pose, Snapshot, State, picture};
use thiserror::Error;

use crate::storage::{StorageError, write_atomically};

/// Size of a picture, pixels.
const SIZE: [usize; 2] = [320, 240];

/// Vertical field of view, rad.
const FOVY_RAD: f64 = 0.7;

/// Between two pictures, pixels.
const GAP: usize = 4;

/// A strip that cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FilmError {
    /// A moment cannot be drawn.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// The file cannot be written.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The pixels do not go into the format.
    #[error("cannot put a picture into PNG")]
    Png(#[from] png::EncodingError),
}

/// Draws `n` of these moments beside each other, the first, the last, and between them such that about as much moves from each
/// to the next; `state` is one of the same model, and is left at the last moment.
///
/// # Errors
/// [`FilmError::Physics`] for moments of another model.
pub fn strip(
    state: &mut State,
    moments: &[Snapshot],
    n: usize,
    world_from_optical: &Pose,
) -> Result<Picture, FilmError> {
    let camera = PinholeCamera::from_fovy(SIZE[0], SIZE[1], FOVY_RAD)?;
    let mut pictures = Vec::with_capacity(n);
    for moment in spread(state, moments, n)? {
        state.restore(moment)?;
        state.forward_kinematics()?;
        pictures.push(picture(state, &camera, world_from_optical)?);
    }
    Ok(beside(&pictures))
}

/// `n` of these moments, or all if there are not so many, by equal shares of what all joints move.
fn spread<'a>(
    state: &mut State,
    moments: &'a [Snapshot],
    n: usize,
) -> Result<Vec<&'a Snapshot>, FilmError> {
    let mut moved = Vec::with_capacity(moments.len());
    let mut before: Vec<f64> = Vec::new();
    let mut sum = 0.0;
    for moment in moments {
        state.restore(moment)?;
        let pairs = state.qpos().iter().zip(&before);
        sum += pairs.map(|(now, before)| (now - before).abs()).sum::<f64>();
        moved.push(sum);
        before = state.qpos().to_vec();
    }
    let n = n.min(moments.len());
    let chosen = (0..n).map(|i| {
        let share = i as f64 / (n.max(2) - 1) as f64;
        if i + 1 == n {
            moments.len() - 1
        } else {
            moved.partition_point(|moved| *moved < share * sum)
        }
    });
    Ok(chosen.filter_map(|at| moments.get(at)).collect())
}

/// Pictures of one height from left to right.
fn beside(pictures: &[Picture]) -> Picture {
    let height = pictures.iter().map(|picture| picture.height).max();
    let height = height.unwrap_or(0);
    let mut rgb = Vec::new();
    for row in 0..height {
        for (i, picture) in pictures.iter().enumerate() {
            if i > 0 {
                rgb.resize(rgb.len() + 3 * GAP, u8::MAX);
            }
            let bytes = 3 * picture.width;
            rgb.extend_from_slice(&picture.rgb[row * bytes..(row + 1) * bytes]);
        }
    }
    Picture {
        width: rgb.len() / 3 / height.max(1),
        height,
        rgb,
    }
}

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// [`FilmError`] if it has no pixels or the file cannot be written.
pub fn write_png(file: &Path, picture: &Picture) -> Result<(), FilmError> {
    let mut bytes = Cursor::new(Vec::new());
    let [width, height] = [picture.width, picture.height].map(|n| n as u32);
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb)?;
    writer.finish()?;
    bytes
        .flush()
        .map_err(|error| StorageError::writing(file, error))?;
    Ok(write_atomically(file, &bytes.into_inner())?)
}

#[cfg(test)]
mod tests {
    use factotum_physics::Model;
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn a_strip_shows_the_first_the_last_and_what_is_between() {
        let model = Model::from_mjcf_str(
            r#"<mujoco><worldbody><body name="ball" pos="0 0 0.4">
                 <freejoint/><geom type="sphere" size="0.1" rgba="0 0 1 1"/></body></worldbody></mujoco>"#,
        )
        .unwrap();
        let mut state = State::new(&model).unwrap();
        let mut moments = vec![state.snapshot()];
        while state.time_secs() < 0.4 {
            state.step().unwrap();
            moments.push(state.snapshot());
        }
        let eye = Pose::face_towards(
            &Point3::new(-2.5, 0.0, 0.0),
            &Point3::origin(),
            &-Vector3::z(),
        );
        let strip = strip(&mut state, &moments, 3, &eye).unwrap();
        assert_eq!((strip.width, strip.height), (3 * 320 + 2 * 4, 240));
        // The ball falls from picture to picture.
        let highest = |k: usize| {
            (0..240).find(|row| {
                let at = |column: usize| 3 * (row * strip.width + k * 324 + column);
                (0..320).any(|column| strip.rgb[at(column)] == 0)
            })
        };
        let rows: Vec<usize> = (0..3).filter_map(highest).collect();
        assert!(
            rows.len() == 3 && rows[0] < rows[1] && rows[1] < rows[2],
            "{rows:?}"
        );

        // Where nothing moves any more there is nothing to see.
        let last = state.snapshot();
        moments.resize(10 * moments.len(), last);
        let still = super::strip(&mut state, &moments, 3, &eye).unwrap();
        assert_eq!(still.rgb, strip.rgb);

        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("strip.png");
        write_png(&file, &strip).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(file).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        assert_eq!(rgb, strip.rgb);
    }
}
