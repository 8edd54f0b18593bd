// The log handler and its thread-local jump buffer. See guard.h.

#include "guard.h"

#include <stdio.h>
#include <string.h>

_Thread_local fct_Guard fct_guard;

void fct_set_message(const char* text) {
  snprintf(fct_guard.message, sizeof fct_guard.message, "%s", text ? text : "");
}

const char* fct_message(void) { return fct_guard.message; }

// Keeps warnings and information silent: warnings are read from mjData.warning and from the spec.
// An installed handler also replaces MuJoCo's own, which would write MUJOCO_LOG.TXT.
static void on_message(const mjLogMessage* message) {
  if (message->level != mjLOG_ERROR) return;
  const char* body = message->body ? message->body : "";
  snprintf(fct_guard.message, sizeof fct_guard.message, "%s%s%s%s%s",
           message->func ? message->func : "", message->func ? ": " : "", message->subject,
           body[0] ? "; " : "", body);
  if (fct_guard.armed) longjmp(fct_guard.env, 1);
}

void fct_install_handler(void) { mju_setLogHandler(on_message); }
