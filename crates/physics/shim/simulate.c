// Guarded run-time calls of MuJoCo: each returns an FCT_ code.

#include "guard.h"

// First warning counted on `d`, or FCT_OK; clears the counters, so each is reported once.
static int take_warning(mjData* d, int* kind, int* info) {
  for (int w = mjNWARNING - 1; w >= 0; w--) {
    if (d->warning[w].number) {
      *kind = w;
      *info = d->warning[w].lastinfo;
      for (int v = 0; v < mjNWARNING; v++) d->warning[v].number = 0;
      return FCT_WARNING;
    }
  }
  return FCT_OK;
}

// Bad numbers are found before the engine works on them: with auto-reset off it would go on.
#define CHECK_INPUT(m, d, kind, info)                     \
  do {                                                    \
    FCT_GUARDED(mj_checkPos(m, d); mj_checkVel(m, d));    \
    int rc = take_warning(d, kind, info);                 \
    if (rc) return rc;                                    \
  } while (0)

int fct_step(const mjModel* m, mjData* d, int* kind, int* info) {
  CHECK_INPUT(m, d, kind, info);
  FCT_GUARDED(mj_step(m, d));
  return take_warning(d, kind, info);
}

int fct_step1(const mjModel* m, mjData* d, int* kind, int* info) {
  CHECK_INPUT(m, d, kind, info);
  FCT_GUARDED(mj_step1(m, d));
  return take_warning(d, kind, info);
}

int fct_step2(const mjModel* m, mjData* d, int* kind, int* info) {
  FCT_GUARDED(mj_step2(m, d));
  return take_warning(d, kind, info);
}

int fct_forward(const mjModel* m, mjData* d, int* kind, int* info) {
  CHECK_INPUT(m, d, kind, info);
  FCT_GUARDED(mj_forward(m, d); mj_checkAcc(m, d));
  return take_warning(d, kind, info);
}

int fct_inverse(const mjModel* m, mjData* d, int* kind, int* info) {
  CHECK_INPUT(m, d, kind, info);
  FCT_GUARDED(mj_inverse(m, d));
  return take_warning(d, kind, info);
}

int fct_kinematics(const mjModel* m, mjData* d, int* kind, int* info) {
  FCT_GUARDED(mj_checkPos(m, d));
  int rc = take_warning(d, kind, info);
  if (rc) return rc;
  FCT_GUARDED(mj_fwdKinematics(m, d));
  return take_warning(d, kind, info);
}

int fct_collision(const mjModel* m, mjData* d, int* kind, int* info) {
  FCT_GUARDED(mj_checkPos(m, d));
  int rc = take_warning(d, kind, info);
  if (rc) return rc;
  FCT_GUARDED(mj_kinematics(m, d); if (m->nflex) mj_flex(m, d); mj_collision(m, d));
  return take_warning(d, kind, info);
}

// Poses, inertia and bias forces only: no actuation, contacts or constraint solver.
int fct_dynamics(const mjModel* m, mjData* d, int* kind, int* info) {
  CHECK_INPUT(m, d, kind, info);
  FCT_GUARDED(mj_kinematics(m, d); mj_comPos(m, d); mj_camlight(m, d); mj_makeM(m, d);
              mj_factorM(m, d); mj_comVel(m, d); mj_rne(m, d, 0, d->qfrc_bias));
  return take_warning(d, kind, info);
}

// Bias forces at zero velocity, into `out` (nv); qvel and cvel are as before on return.
int fct_gravity(const mjModel* m, mjData* d, mjtNum* qvel_scratch, mjtNum* out) {
  mju_copy(qvel_scratch, d->qvel, (int)m->nv);
  mju_zero(d->qvel, (int)m->nv);
  FCT_GUARDED(mj_comVel(m, d); mj_rne(m, d, 0, out));
  mju_copy(d->qvel, qvel_scratch, (int)m->nv);
  FCT_GUARDED(mj_comVel(m, d));
  return FCT_OK;
}

int fct_ray(const mjModel* m, const mjData* d, const mjtNum* point, const mjtNum* direction,
            const mjtByte* groups, mjtBool include_static, int body_excluded, int* geom,
            mjtNum* normal, mjtNum* distance) {
  FCT_GUARDED(*distance = mj_ray(m, d, point, direction, groups, include_static, body_excluded,
                                 geom, normal));
  return FCT_OK;
}

int fct_multi_ray(const mjModel* m, mjData* d, const mjtNum* point, const mjtNum* directions,
                  const mjtByte* groups, mjtBool include_static, int body_excluded, int* geoms,
                  mjtNum* distances, int n_rays, mjtNum cutoff) {
  FCT_GUARDED(mj_multiRay(m, d, point, directions, groups, include_static, body_excluded, geoms,
                          distances, NULL, n_rays, cutoff));
  return FCT_OK;
}

int fct_geom_distance(const mjModel* m, mjData* d, int geom_a, int geom_b, mjtNum distance_max,
                      mjtNum* segment, mjtNum* distance) {
  FCT_GUARDED(*distance = mj_geomDistance(m, d, geom_a, geom_b, distance_max, segment));
  return FCT_OK;
}

int fct_make_data(const mjModel* m, mjData** out) {
  *out = NULL;
  FCT_GUARDED(*out = mj_makeData(m));
  if (!*out) {
    fct_set_message("mj_makeData returned no data");
    return FCT_REFUSED;
  }
  return FCT_OK;
}

int fct_reset_data(const mjModel* m, mjData* d) {
  FCT_GUARDED(mj_resetData(m, d));
  return FCT_OK;
}

int fct_reset_keyframe(const mjModel* m, mjData* d, int key) {
  FCT_GUARDED(mj_resetDataKeyframe(m, d, key));
  return FCT_OK;
}

int fct_copy_data(const mjModel* m, mjData* destination, const mjData* source) {
  FCT_GUARDED(mj_copyData(destination, m, source));
  return FCT_OK;
}

int fct_copy_model(const mjModel* m, mjModel** out) {
  *out = NULL;
  FCT_GUARDED(*out = mj_copyModel(NULL, m));
  if (!*out) {
    fct_set_message("mj_copyModel returned no model");
    return FCT_REFUSED;
  }
  return FCT_OK;
}

int fct_set_state(const mjModel* m, mjData* d, const mjtNum* state, int signature) {
  FCT_GUARDED(mj_setState(m, d, state, signature));
  return FCT_OK;
}

int fct_get_state(const mjModel* m, const mjData* d, mjtNum* state, int signature) {
  FCT_GUARDED(mj_getState(m, d, state, signature));
  return FCT_OK;
}

int fct_jacobian(const mjModel* m, const mjData* d, mjtNum* linear, mjtNum* angular,
                 const mjtNum* point, int body) {
  FCT_GUARDED(mj_jac(m, d, linear, angular, point, body));
  return FCT_OK;
}

int fct_full_mass_matrix(const mjModel* m, const mjData* d, mjtNum* out) {
  FCT_GUARDED(mj_fullM(m, d, out));
  return FCT_OK;
}

int fct_contact_force(const mjModel* m, const mjData* d, int contact, mjtNum* out) {
  FCT_GUARDED(mj_contactForce(m, d, contact, out));
  return FCT_OK;
}

int fct_object_velocity(const mjModel* m, const mjData* d, int object_type, int id, mjtNum* out) {
  FCT_GUARDED(mj_objectVelocity(m, d, object_type, id, out, 0));
  return FCT_OK;
}

int fct_differentiate_pos(const mjModel* m, mjtNum* velocity, mjtNum dt, const mjtNum* from,
                          const mjtNum* to) {
  FCT_GUARDED(mj_differentiatePos(m, velocity, dt, from, to));
  return FCT_OK;
}

int fct_integrate_pos(const mjModel* m, mjtNum* qpos, const mjtNum* velocity, mjtNum dt) {
  FCT_GUARDED(mj_integratePos(m, qpos, velocity, dt));
  return FCT_OK;
}

// Forgets contacts and constraints, whose memory a broken-off call may have left half written.
void fct_abandon(mjData* d) {
  d->ncon = 0;
  d->nefc = 0;
}
