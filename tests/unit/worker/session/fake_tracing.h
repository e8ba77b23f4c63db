#pragma once
/* Tracing without rays, for tests of what stands around it: it costs nothing, waits or hangs when
 * it is told to, and counts what it is asked for. */
#include <stdbool.h>

#include "proto/scene/environment.h"
#include "tests/unit/unit.h"
#include "worker/session/tracing.h"

#define LOAD_STEP_MS 20

/* Blobs that begin so are bases; or frames, whose base's digest comes next. */
#define FAKE_BASE  "FAKEBASE"
#define FAKE_FRAME "FAKEFRAM"

extern _Atomic bool hold;        /* tiles wait, and end when they are stopped */
extern _Atomic unsigned tracing; /* tiles that a thread has begun */
extern _Atomic unsigned loads, unloads;
extern _Atomic uint32_t traced_pass;
extern _Atomic uint32_t traced_strata; /* their sum; 0: the last tile had none */
extern _Atomic uint32_t traced_lobes;
extern _Atomic uint32_t load_steps;     /* that the next load makes, one each LOAD_STEP_MS */
extern _Atomic int load_error;          /* 0: loads succeed */
extern _Atomic bool load_error_of_base; /* of bases alone */
extern _Atomic bool load_hangs;         /* until it is set to false */
extern _Atomic bool load_spins;         /* meanwhile it uses a CPU */
extern _Atomic bool traced_map;         /* the last tile had an environment */

extern const struct tracing fake_tracing;
