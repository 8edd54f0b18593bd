// Guarded calls on mjSpec: reading, attaching, adding actuators, compiling.

#include "guard.h"

#include <string.h>

static int refuse(const char* text) {
  fct_set_message(text && text[0] ? text : "refused without a reason");
  return FCT_REFUSED;
}

int fct_spec_parse_file(const char* path, mjSpec** out) {
  char error[1024] = "";
  *out = NULL;
  FCT_GUARDED(*out = mj_parseXML(path, NULL, error, (int)sizeof error));
  return *out ? FCT_OK : refuse(error);
}

int fct_spec_parse_text(const char* xml, mjSpec** out) {
  char error[1024] = "";
  *out = NULL;
  FCT_GUARDED(*out = mj_parseXMLString(xml, NULL, error, (int)sizeof error));
  return *out ? FCT_OK : refuse(error);
}

void fct_spec_delete(mjSpec* spec) { mj_deleteSpec(spec); }

int fct_spec_compile(mjSpec* spec, mjModel** out) {
  *out = NULL;
  FCT_GUARDED(*out = mj_compile(spec, NULL));
  return *out ? FCT_OK : refuse(mjs_getError(spec));
}

int fct_spec_n_warnings(const mjSpec* spec) { return mjs_numWarnings(spec); }

const char* fct_spec_warning(const mjSpec* spec, int index) {
  return mjs_getWarning(spec, index);
}

int fct_spec_save(const mjSpec* spec, char* text, int capacity) {
  char error[1024] = "";
  int rc = 0;
  FCT_GUARDED(rc = mj_saveXMLString(spec, text, capacity, error, (int)sizeof error));
  return rc == 0 ? FCT_OK : refuse(error);
}

// Moves everything in the world of `spec` by a pose, as one frame.
static int shift_world(mjSpec* spec, const double* pos, const double* quat) {
  static const mjtObj kinds[] = {mjOBJ_BODY, mjOBJ_GEOM, mjOBJ_SITE, mjOBJ_CAMERA, mjOBJ_LIGHT,
                                 mjOBJ_FRAME};
  mjsBody* world = mjs_findBody(spec, "world");
  if (!world) return refuse("the part has no world body");
  mjsFrame* shift = mjs_addFrame(world, NULL);
  if (!shift) return refuse(mjs_getError(spec));
  memcpy(shift->pos, pos, sizeof shift->pos);
  memcpy(shift->quat, quat, sizeof shift->quat);
  for (unsigned k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
    for (mjsElement* e = mjs_firstChild(world, kinds[k], 0); e;
         e = mjs_nextChild(world, e, 0)) {
      if (e != shift->element && mjs_getParent(e) == world && !mjs_getFrame(e)) {
        if (mjs_setFrame(e, shift)) return refuse(mjs_getError(spec));
      }
    }
  }
  return FCT_OK;
}

// The site of that name, else a new frame at the body of that name (NULL: the world).
static mjsElement* carrier(mjSpec* spec, const char* name) {
  mjsElement* site = name ? mjs_findElement(spec, mjOBJ_SITE, name) : NULL;
  if (site) return site;
  mjsBody* body = mjs_findBody(spec, name ? name : "world");
  mjsFrame* frame = body ? mjs_addFrame(body, NULL) : NULL;
  return frame ? frame->element : NULL;
}

// Attaches all of `child` to a site or body of `parent` (NULL: to its world), moved by a pose.
static int attach(mjSpec* parent, const char* to, mjSpec* child, const double* pos,
                  const double* quat, const char* prefix) {
  int rc = shift_world(child, pos, quat);
  if (rc) return rc;
  mjsElement* at = carrier(parent, to);
  if (!at) return refuse("no such site or body");
  mjs_setDeepCopy(parent, 1);
  return mjs_attach(at, child->element, prefix, "") ? FCT_OK : refuse(mjs_getError(parent));
}

int fct_spec_attach(mjSpec* parent, const char* to, mjSpec* child, const double* pos,
                    const double* quat, const char* prefix) {
  int rc = 0;
  FCT_GUARDED(rc = attach(parent, to, child, pos, quat, prefix));
  return rc;
}

int fct_spec_has(const mjSpec* spec, int kind, const char* name) {
  return mjs_findElement(spec, (mjtObj)kind, name) != NULL;
}

// Name of the `index`-th element of a kind, or NULL past the last. Fine for error messages.
const char* fct_spec_name(const mjSpec* spec, int kind, int index) {
  mjsElement* e = mjs_firstElement(spec, (mjtObj)kind);
  for (int i = 0; e && i < index; i++) e = mjs_nextElement(spec, e);
  return e ? mjs_getString(mjs_getName(e)) : NULL;
}

static int free_roots(mjSpec* spec) {
  mjsBody* world = mjs_findBody(spec, "world");
  int n_bodies = 0;
  for (mjsElement* e = world ? mjs_firstChild(world, mjOBJ_BODY, 0) : NULL; e;
       e = mjs_nextChild(world, e, 0)) {
    mjsBody* body = mjs_asBody(e);
    n_bodies++;
    int already = 0;
    for (mjsElement* j = mjs_firstChild(body, mjOBJ_JOINT, 0); j;
         j = mjs_nextChild(body, j, 0)) {
      if (mjs_asJoint(j)->type == mjJNT_FREE) already = 1;
    }
    if (already) continue;
    mjsJoint* joint = mjs_addFreeJoint(body);
    if (!joint) return refuse(mjs_getError(spec));
    char name[256];
    const char* body_name = mjs_getString(mjs_getName(e));
    int n = (int)strlen(body_name);
    if (n > 240) return refuse("body name too long");
    memcpy(name, body_name, (size_t)n);
    memcpy(name + n, "_free", sizeof "_free");
    if (n && mjs_setName(joint->element, name)) return refuse(mjs_getError(spec));
  }
  return n_bodies ? FCT_OK : refuse("the part has no body to free");
}

// Gives each root body of the spec a free joint, named `<body>_free`.
int fct_spec_free_roots(mjSpec* spec) {
  int rc = 0;
  FCT_GUARDED(rc = free_roots(spec));
  return rc;
}

// servo 0: torque or force motor; 1: position servo (gains kp, kv); 2: velocity servo (gain kv).
static int add_actuator(mjSpec* spec, const char* name, const char* joint, int servo, double kp,
                        double kv, const double* ctrl_range, const double* force_range) {
  mjsActuator* a = mjs_addActuator(spec, NULL);
  if (!a) return refuse(mjs_getError(spec));
  const char* error = "";
  if (servo == 0) {
    error = mjs_setToMotor(a);
  } else if (servo == 1) {
    error = mjs_setToPosition(a, kp, &kv, NULL, NULL, 0);
  } else {
    error = mjs_setToVelocity(a, kv);
  }
  if (error && error[0]) return refuse(error);
  if (mjs_setName(a->element, name)) return refuse(mjs_getError(spec));
  a->trntype = mjTRN_JOINT;
  mjs_setString(a->target, joint);
  if (ctrl_range) {
    a->ctrllimited = mjLIMITED_TRUE;
    a->ctrlrange[0] = ctrl_range[0];
    a->ctrlrange[1] = ctrl_range[1];
  }
  if (force_range) {
    a->forcelimited = mjLIMITED_TRUE;
    a->forcerange[0] = force_range[0];
    a->forcerange[1] = force_range[1];
  }
  return FCT_OK;
}

int fct_spec_add_actuator(mjSpec* spec, const char* name, const char* joint, int servo, double kp,
                          double kv, const double* ctrl_range, const double* force_range) {
  int rc = 0;
  FCT_GUARDED(rc = add_actuator(spec, name, joint, servo, kp, kv, ctrl_range, force_range));
  return rc;
}

static int add_site(mjSpec* spec, const char* body, const char* name, const double* pos,
                    const double* quat) {
  mjsBody* b = mjs_findBody(spec, body);
  if (!b) return refuse("no such body");
  mjsSite* site = mjs_addSite(b, NULL);
  if (!site) return refuse(mjs_getError(spec));
  if (mjs_setName(site->element, name)) return refuse(mjs_getError(spec));
  memcpy(site->pos, pos, sizeof site->pos);
  memcpy(site->quat, quat, sizeof site->quat);
  return FCT_OK;
}

// Adds a site to a body, at a pose in the body's frame.
int fct_spec_add_site(mjSpec* spec, const char* body, const char* name, const double* pos,
                      const double* quat) {
  int rc = 0;
  FCT_GUARDED(rc = add_site(spec, body, name, pos, quat));
  return rc;
}

static int set_mesh_file(mjSpec* spec, const char* mesh, const char* file) {
  mjsElement* e = mjs_findElement(spec, mjOBJ_MESH, mesh);
  if (!e) return refuse("no such mesh");
  mjs_setString(mjs_asMesh(e)->file, file);
  return FCT_OK;
}

// Sets the file that a mesh is read from when the spec is compiled.
int fct_spec_set_mesh_file(mjSpec* spec, const char* mesh, const char* file) {
  int rc = 0;
  FCT_GUARDED(rc = set_mesh_file(spec, mesh, file));
  return rc;
}

static int add_exclude(mjSpec* spec, const char* body_a, const char* body_b) {
  mjsExclude* e = mjs_addExclude(spec);
  if (!e) return refuse(mjs_getError(spec));
  mjs_setString(e->bodyname1, body_a);
  mjs_setString(e->bodyname2, body_b);
  return FCT_OK;
}

// Takes contacts between two bodies out of collision detection.
int fct_spec_add_exclude(mjSpec* spec, const char* body_a, const char* body_b) {
  int rc = 0;
  FCT_GUARDED(rc = add_exclude(spec, body_a, body_b));
  return rc;
}
