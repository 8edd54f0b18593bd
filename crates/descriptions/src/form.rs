//! Classes made of a shape: what a person says of a thing for which there is no model.
//!
//! Λ lies in the middle of the foot, z up, so that an object of the class stands where Γ puts it on the floor or a
//! table. The model is a solid of even density; that a bin is hollow does not matter to a robot that drops things into
//! it from above.

use serde::{Deserialize, Serialize};

/// A shape that a class can be made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Form {
    /// A cuboid.
    Box {
        /// Its edges along x, y and z, metres.
        size_m: [f64; 3],
    },
    /// An upright cylinder.
    Cylinder {
        /// Diameter, metres.
        diameter_m: f64,
        /// Height, metres.
        height_m: f64,
    },
}

/// A size that no thing of a home has: what was found and what is wanted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("`{size}` is {found_m} m, expected {SIZE_MIN_M} to {SIZE_MAX_M} m")]
pub struct FormError {
    /// Which size.
    pub size: &'static str,
    /// What it is, metres.
    pub found_m: f64,
}

/// Smallest edge that a thing may have, metres.
pub const SIZE_MIN_M: f64 = 0.002;
/// Largest edge that a thing may have, metres.
pub const SIZE_MAX_M: f64 = 5.0;

/// Density of the model: what a half full bottle weighs for its size, kg/m³.
const DENSITY_KG_PER_M3: f64 = 400.0;

impl Form {
    /// The sizes by name.
    fn sizes(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Box { size_m: [x, y, z] } => {
                vec![("size_m.x", x), ("size_m.y", y), ("size_m.z", z)]
            }
            Self::Cylinder {
                diameter_m,
                height_m,
            } => vec![("diameter_m", diameter_m), ("height_m", height_m)],
        }
    }

    /// Height above Λ, metres.
    pub fn height_m(&self) -> f64 {
        match *self {
            Self::Box { size_m } => size_m[2],
            Self::Cylinder { height_m, .. } => height_m,
        }
    }

    /// Whether turning it about z changes nothing.
    pub fn is_yaw_symmetric(&self) -> bool {
        matches!(self, Self::Cylinder { .. })
    }

    /// The model, as MJCF, of a class of this name.
    ///
    /// # Errors
    /// [`FormError`] if a size is none.
    pub fn to_mjcf(self, class: &str) -> Result<String, FormError> {
        let is_size = |size_m: f64| (SIZE_MIN_M..=SIZE_MAX_M).contains(&size_m);
        if let Some((size, found_m)) = self.sizes().into_iter().find(|(_, m)| !is_size(*m)) {
            return Err(FormError { size, found_m });
        }
        let middle_m = self.height_m() / 2.0;
        let geom = match self {
            Self::Box { size_m } => {
                let [x, y, z] = size_m.map(|edge| edge / 2.0);
                format!(r#"type="box" size="{x} {y} {z}""#)
            }
            Self::Cylinder { diameter_m, .. } => {
                let radius_m = diameter_m / 2.0;
                format!(r#"type="cylinder" size="{radius_m} {middle_m}""#)
            }
        };
        let name: String = class.chars().filter(|c| !"<>&\"".contains(*c)).collect();
        Ok(format!(
            r#"<mujoco model="{name}">
  <!-- Made of a shape by a person. Λ: the middle of the foot, z up. -->
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="{name}">
      <geom name="{name}_form" {geom} pos="0 0 {middle_m}" density="{DENSITY_KG_PER_M3}" condim="6" friction="0.7 0.005 0.0015" rgba="0.62 0.66 0.70 1"/>
    </body>
  </worldbody>
</mujoco>
"#
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_stands_on_its_foot() {
        let form = Form::Cylinder {
            diameter_m: 0.06,
            height_m: 0.2,
        };
        let model = form.to_mjcf("can").unwrap();
        assert!(
            model.contains(r#"type="cylinder" size="0.03 0.1" pos="0 0 0.1""#),
            "{model}"
        );
        let form = Form::Box {
            size_m: [0.3, 0.2, 0.1],
        };
        let model = form.to_mjcf("crate").unwrap();
        assert!(
            model.contains(r#"type="box" size="0.15 0.1 0.05" pos="0 0 0.05""#),
            "{model}"
        );
    }

    #[test]
    fn what_is_no_size_is_refused_by_name() {
        for height_m in [0.0, -0.2, 40.0, f64::NAN, f64::INFINITY] {
            let form = Form::Cylinder {
                diameter_m: 0.06,
                height_m,
            };
            let error = form.to_mjcf("can").unwrap_err();
            assert_eq!(
                error.to_string(),
                format!("`height_m` is {height_m} m, expected 0.002 to 5 m")
            );
        }
    }
}
