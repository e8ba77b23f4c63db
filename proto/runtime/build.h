#pragma once
/* What this build is: both sides of a worker link must say the same. */
#include "proto/error.h"

/* Returns the version and a digest of the sources, such as "0.1.0+3f9c01d2a4b5". */
const char *build_id(void);

/* Returns the instruction set that tracing uses on this CPU: "avx512", "avx2" or "sse4.2"; NULL
 * when the CPU has less. SHEARWATER_ISA in the environment may ask for a smaller one. */
const char *build_isa(void);

/* Checks the CPU. ERR_UNSUPPORTED: it lacks even SSE4.2, or SHEARWATER_ISA is no instruction
 * set. */
int build_isa_check(struct fault *fault);
