//! Poses, velocities and Jacobians. All are as of the last computation
//! ([`State::forward_kinematics`] is enough), expressed in the world.

use std::ffi::c_int;

use mujoco_rs::mujoco_c::mjtObj;
use nalgebra::{DMatrix, Point3, Vector3};

use crate::Pose;
use crate::axes::{pose_from_mujoco, pose_from_pos_mat, world_from_optical};
use crate::engine;
use crate::error::PhysicsError;
use crate::ids::{BodyId, CameraId, GeomId, JointId, SiteId};
use crate::state::{State, view};

/// Row `i` of an array of `N`-vectors.
pub(crate) fn row<const N: usize>(values: &[f64], i: usize) -> [f64; N] {
    let mut out = [0.0; N];
    out.copy_from_slice(&values[N * i..N * (i + 1)]);
    out
}

impl State {
    /// Pose of a body.
    pub fn world_from_body(&self, body: BodyId) -> Pose {
        let n = self.model().n_bodies();
        let pos = view!(self, xpos, 3 * n);
        let quat = view!(self, xquat, 4 * n);
        pose_from_mujoco(row(pos, body.0), row(quat, body.0))
    }

    /// Pose of a site.
    pub fn world_from_site(&self, site: SiteId) -> Pose {
        let n = self.model().n_sites();
        let pos = view!(self, site_xpos, 3 * n);
        let mat = view!(self, site_xmat, 9 * n);
        pose_from_pos_mat(&row::<3>(pos, site.0), &row::<9>(mat, site.0))
    }

    /// Pose of a geom.
    pub fn world_from_geom(&self, geom: GeomId) -> Pose {
        let n = self.model().n_geoms();
        let pos = view!(self, geom_xpos, 3 * n);
        let mat = view!(self, geom_xmat, 9 * n);
        pose_from_pos_mat(&row::<3>(pos, geom.0), &row::<9>(mat, geom.0))
    }

    /// Pose of a camera's optical frame (REP-103: z forward, x right, y down), which is not
    /// MuJoCo's own (−z forward, y up).
    pub fn world_from_camera(&self, camera: CameraId) -> Pose {
        let n = self.model().tables().cameras.len();
        let pos = view!(self, cam_xpos, 3 * n);
        let mat = view!(self, cam_xmat, 9 * n);
        world_from_optical(&pose_from_pos_mat(
            &row::<3>(pos, camera.0),
            &row::<9>(mat, camera.0),
        ))
    }

    /// Centre of mass of a body.
    pub fn body_com_in_world(&self, body: BodyId) -> Point3<f64> {
        Point3::from(row::<3>(
            view!(self, xipos, 3 * self.model().n_bodies()),
            body.0,
        ))
    }

    /// Axis of a slide or hinge.
    pub fn joint_axis_in_world(&self, joint: JointId) -> Vector3<f64> {
        Vector3::from(row::<3>(
            view!(self, xaxis, 3 * self.model().n_joints()),
            joint.0,
        ))
    }

    /// Anchor of a joint: a point on the axis of a hinge.
    pub fn joint_anchor_in_world(&self, joint: JointId) -> Point3<f64> {
        Point3::from(row::<3>(
            view!(self, xanchor, 3 * self.model().n_joints()),
            joint.0,
        ))
    }

    /// Jacobian of a site: 6 × `n_v`, rows 0..3 the velocity of its origin (m/s), rows 3..6 the
    /// angular velocity (rad/s), both expressed in the world. `jac` is resized when it is of another
    /// size.
    pub fn site_jacobian_into(&self, site: SiteId, jac: &mut DMatrix<f64>) {
        let pos = view!(self, site_xpos, 3 * self.model().n_sites());
        let point = Point3::from(row::<3>(pos, site.0));
        self.body_jacobian_into(self.model().site_body(site), &point, jac);
    }

    /// Jacobian of a point fixed to a body, given where the point is in the world; as
    /// [`site_jacobian_into`](Self::site_jacobian_into).
    pub fn body_jacobian_into(
        &self,
        body: BodyId,
        point_in_world: &Point3<f64>,
        jac: &mut DMatrix<f64>,
    ) {
        let n_v = self.model().n_v();
        if jac.shape() != (6, n_v) {
            *jac = DMatrix::zeros(6, n_v);
        }
        let mut rows = self.scratch();
        rows.clear();
        rows.resize(6 * n_v, 0.0);
        let (linear, angular) = rows.split_at_mut(3 * n_v);
        let point: [f64; 3] = point_in_world.coords.into();
        // SAFETY: a live model and state, two arrays of 3 x nv values, a point of 3.
        let rc = unsafe {
            engine::fct_jacobian(
                self.model().as_ptr(),
                self.as_ptr(),
                linear.as_mut_ptr(),
                angular.as_mut_ptr(),
                point.as_ptr(),
                c_int::try_from(body.0).unwrap_or(0),
            )
        };
        if self.check(rc, "mj_jac").is_err() {
            jac.fill(f64::NAN);
            return;
        }
        for (i, &value) in rows.iter().enumerate() {
            jac[(i / n_v, i % n_v)] = value;
        }
    }

    /// Velocity of a site's origin (m/s) and its angular velocity (rad/s), both in world axes; needs
    /// [`forward`](Self::forward) or [`dynamics`](Self::dynamics).
    pub fn site_velocity(&self, site: SiteId) -> (Vector3<f64>, Vector3<f64>) {
        self.object_velocity(mjtObj::mjOBJ_SITE, site.0)
    }

    /// Velocity of a body's frame (m/s, rad/s), as [`site_velocity`](Self::site_velocity).
    pub fn body_velocity(&self, body: BodyId) -> (Vector3<f64>, Vector3<f64>) {
        self.object_velocity(mjtObj::mjOBJ_XBODY, body.0)
    }

    fn object_velocity(&self, kind: mjtObj, id: usize) -> (Vector3<f64>, Vector3<f64>) {
        // MuJoCo gives the rotation first.
        let mut twist = [0.0; 6];
        // SAFETY: a live model and state, an object of the model, room for 6 values.
        let rc = unsafe {
            engine::fct_object_velocity(
                self.model().as_ptr(),
                self.as_ptr(),
                kind as c_int,
                c_int::try_from(id).unwrap_or(0),
                twist.as_mut_ptr(),
            )
        };
        if self.check(rc, "mj_objectVelocity").is_err() {
            twist = [f64::NAN; 6];
        }
        let [rx, ry, rz, x, y, z] = twist;
        (Vector3::new(x, y, z), Vector3::new(rx, ry, rz))
    }

    /// Velocity, length `n_v`, that leads from one position to another in `dt_secs`; it knows free
    /// and ball joints.
    ///
    /// # Errors
    /// [`PhysicsError::Size`].
    pub fn differentiate_positions(
        &self,
        from: &[f64],
        to: &[f64],
        dt_secs: f64,
    ) -> Result<Vec<f64>, PhysicsError> {
        self.expect_n_q(from)?;
        self.expect_n_q(to)?;
        let mut velocity = vec![0.0; self.model().n_v()];
        // SAFETY: a live model, arrays of nq, nq and nv values.
        let rc = unsafe {
            engine::fct_differentiate_pos(
                self.model().as_ptr(),
                velocity.as_mut_ptr(),
                dt_secs,
                from.as_ptr(),
                to.as_ptr(),
            )
        };
        self.check(rc, "mj_differentiatePos")?;
        Ok(velocity)
    }

    /// Moves positions along a velocity for `dt_secs`; it knows free and ball joints.
    ///
    /// # Errors
    /// [`PhysicsError::Size`].
    pub fn integrate_positions(
        &self,
        qpos: &mut [f64],
        velocity: &[f64],
        dt_secs: f64,
    ) -> Result<(), PhysicsError> {
        self.expect_n_q(qpos)?;
        if velocity.len() != self.model().n_v() {
            return Err(PhysicsError::Size {
                what: "velocity",
                found: velocity.len(),
                expected: self.model().n_v(),
            });
        }
        // SAFETY: a live model, arrays of nq and nv values.
        let rc = unsafe {
            engine::fct_integrate_pos(
                self.model().as_ptr(),
                qpos.as_mut_ptr(),
                velocity.as_ptr(),
                dt_secs,
            )
        };
        self.check(rc, "mj_integratePos")
    }

    fn expect_n_q(&self, qpos: &[f64]) -> Result<(), PhysicsError> {
        let expected = self.model().n_q();
        if qpos.len() == expected {
            return Ok(());
        }
        Err(PhysicsError::Size {
            what: "qpos",
            found: qpos.len(),
            expected,
        })
    }
}
