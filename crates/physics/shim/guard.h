// Turns MuJoCo's fatal errors into return codes.
//
// MuJoCo reports a fatal error to the log handler and ends the process when the handler returns.
// A guarded call arms a thread-local jump buffer first; the handler then leaves by longjmp, so that
// control is back in the guarded function, in C, before any Rust frame is touched. What the call had
// in hand is lost (its stack marks in mjData above all), so the caller must discard that mjData.

#ifndef FACTOTUM_GUARD_H_
#define FACTOTUM_GUARD_H_

#include <setjmp.h>

#include <mujoco/mujoco.h>

enum {
  FCT_OK = 0,
  FCT_FATAL = 1,    // MuJoCo raised an error; text in fct_message()
  FCT_WARNING = 2,  // MuJoCo counted a warning; kind and index in the out-parameters
  FCT_REFUSED = 3,  // MuJoCo returned an error; text in fct_message()
};

typedef struct {
  jmp_buf env;
  int armed;
  char message[2048];
} fct_Guard;

extern _Thread_local fct_Guard fct_guard;

// Runs `statement`; on a fatal error the enclosing function returns FCT_FATAL.
// Locals of the enclosing function must not be written inside `statement` and read after it.
#define FCT_GUARDED(statement)      \
  do {                              \
    fct_guard.message[0] = '\0';    \
    if (_setjmp(fct_guard.env)) {   \
      fct_guard.armed = 0;          \
      return FCT_FATAL;             \
    }                               \
    fct_guard.armed = 1;            \
    statement;                      \
    fct_guard.armed = 0;            \
  } while (0)

// Installs the log handler; call once, before any other MuJoCo function.
void fct_install_handler(void);

// Text of the last error on this thread.
const char* fct_message(void);

// Copies a text into the thread's message.
void fct_set_message(const char* text);

#endif  // FACTOTUM_GUARD_H_
