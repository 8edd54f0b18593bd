//! Pictures for people, made by casting rays: no graphics card, no window, the same on every machine.

use nalgebra::{Point3, Vector3};

use crate::{DepthImage, GeomId, PhysicsError, PinholeCamera, Pose, State, depth_image};

/// Colour where nothing is seen.
const BACKGROUND: [f64; 3] = [0.93, 0.95, 0.97];

/// Share of its colour that a surface keeps when it is turned away from the light.
const AMBIENT: f64 = 0.55;

/// How much darker a pixel is at the edge of a geom.
const EDGE: f64 = 0.72;

/// Farther than this nothing is drawn, m.
const FAR_M: f64 = 20.0;

/// A picture, row by row from the upper left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel (sRGB).
    pub rgb: Vec<u8>,
}

/// What a camera sees from `world_from_optical` (z forward, x right, y down): geoms in their colours, lit from above the
/// camera's left shoulder, with their edges drawn. Poses are those of the last computation of `state`.
///
/// # Errors
/// As [`State::rays`].
pub fn picture(
    state: &State,
    camera: &PinholeCamera,
    world_from_optical: &Pose,
) -> Result<Picture, PhysicsError> {
    let image = depth_image(state, camera, world_from_optical, [0.01, FAR_M], &[])?;
    let mut points: Vec<Option<Point3<f64>>> = vec![None; image.geom.len()];
    for (i, point) in image.points_in_optical(camera) {
        points[i] = Some(point);
    }
    let light = Vector3::new(-0.35, -0.8, -0.6).normalize();
    let model = state.model();
    let mut rgb = Vec::with_capacity(3 * points.len());
    for (i, geom) in image.geom.iter().enumerate() {
        let colour = match geom {
            None => BACKGROUND,
            Some(geom) => {
                let [r, g, b, _] = model.geom_rgba(*geom).map(f64::from);
                let lit =
                    normal_at(&image, &points, i).map_or(0.0, |normal| normal.dot(&light).max(0.0));
                let edge = if is_edge(&image, i, *geom) { EDGE } else { 1.0 };
                let shade = edge * (AMBIENT + (1.0 - AMBIENT) * lit);
                [r * shade, g * shade, b * shade]
            }
        };
        rgb.extend(colour.map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8));
    }
    Ok(Picture {
        width: image.width,
        height: image.height,
        rgb,
    })
}

/// The neighbours of a pixel to one side of it, or the other: (index, sign).
fn neighbours(image: &DepthImage, i: usize) -> [[Option<usize>; 2]; 2] {
    let (row, column) = (i / image.width, i % image.width);
    [
        [
            (column + 1 < image.width).then_some(i + 1),
            i.checked_sub(1).filter(|_| column > 0),
        ],
        [
            (row + 1 < image.height).then_some(i + image.width),
            i.checked_sub(image.width),
        ],
    ]
}

/// The surface's normal towards the camera, from neighbours on the same geom.
fn normal_at(image: &DepthImage, points: &[Option<Point3<f64>>], i: usize) -> Option<Vector3<f64>> {
    let here = points[i]?;
    let along = |[after, before]: [Option<usize>; 2]| {
        let same = |j: &usize| image.geom[*j] == image.geom[i];
        let way = |j: usize| points[j].map(|point| point - here);
        match after.filter(same) {
            Some(j) => way(j),
            None => way(before.filter(same)?).map(|way| -way),
        }
    };
    let [across, down] = neighbours(image, i).map(along);
    // x right, y down, z forward: the product of down and across comes towards the camera.
    down?.cross(&across?).try_normalize(1e-12)
}

/// Whether a neighbour shows another geom that is farther away.
fn is_edge(image: &DepthImage, i: usize, geom: GeomId) -> bool {
    neighbours(image, i).iter().flatten().flatten().any(|&j| {
        image.geom[j] != Some(geom)
            && (image.geom[j].is_none() || image.depth_m[j] > image.depth_m[i])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;

    const SCENE: &str = r#"<mujoco><worldbody>
      <geom name="box" type="box" size="0.2 0.2 0.2" rgba="1 0 0 1"/>
    </worldbody></mujoco>"#;

    fn seen_from(eye: [f64; 3]) -> Picture {
        let model = Model::from_mjcf_str(SCENE).unwrap();
        let mut state = State::new(&model).unwrap();
        state.forward_kinematics().unwrap();
        let camera = PinholeCamera::from_fovy(40, 30, 0.8).unwrap();
        let pose = Pose::face_towards(&Point3::from(eye), &Point3::origin(), &-Vector3::z());
        picture(&state, &camera, &pose).unwrap()
    }

    fn pixel(picture: &Picture, column: usize, row: usize) -> [u8; 3] {
        let at = 3 * (row * picture.width + column);
        [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
    }

    #[test]
    fn a_red_box_is_red_in_the_middle_and_the_sky_is_around_it() {
        let picture = seen_from([-2.0, 0.0, 0.0]);
        assert_eq!(picture.rgb.len(), 40 * 30 * 3);
        let [r, g, b] = pixel(&picture, 20, 15);
        assert!(r > 100 && g == 0 && b == 0);
        assert_eq!(pixel(&picture, 0, 0), [237, 242, 247]);
    }

    #[test]
    fn what_faces_the_light_is_brighter_than_what_is_turned_from_it() {
        // From above and in front: the upper face, above in the picture, is nearer to the light.
        let picture = seen_from([-2.0, 0.0, 2.0]);
        let column = 20;
        let red: Vec<u8> = (0..30)
            .map(|row| pixel(&picture, column, row))
            .filter(|[_, g, b]| *g == 0 && *b == 0)
            .map(|[r, _, _]| r)
            .collect();
        let quarter = red.len() / 4;
        assert!(red[quarter] > red[3 * quarter] + 20, "{red:?}");
        // The edge against the sky is drawn.
        assert!(red[0] < red[quarter], "{red:?}");
    }
}
