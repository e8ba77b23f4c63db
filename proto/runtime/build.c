#include "proto/runtime/build.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "build_id.h"

static const char *const sets[] = {"sse4.2", "avx2", "avx512"};

const char *build_id(void)
{
    return BUILD_ID;
}

/* Index into sets, -1 for less than the least. The lists are what the compiler may use in files of
 * that set: -march=x86-64-v3 and -v4. */
static int best_set(void)
{
    if (!__builtin_cpu_supports("sse4.2") || !__builtin_cpu_supports("popcnt")) return -1;
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 0;
    if (!__builtin_cpu_supports("bmi") || !__builtin_cpu_supports("bmi2")) return 0;
    if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512dq")) return 1;
    if (!__builtin_cpu_supports("avx512cd") || !__builtin_cpu_supports("avx512bw")) return 1;
    return __builtin_cpu_supports("avx512vl") ? 2 : 1;
}

const char *build_isa(void)
{
    int best = best_set();
    if (best < 0) return NULL;
    const char *wanted = getenv("SHEARWATER_ISA");
    for (int i = 0; wanted != NULL && i < best; i++)
        if (strcmp(wanted, sets[i]) == 0) return sets[i];
    return sets[best];
}

int build_isa_check(struct fault *fault)
{
    const char *wanted = getenv("SHEARWATER_ISA");
    bool known = !wanted || !*wanted;
    if (best_set() < 0) return fault_set(fault, ERR_UNSUPPORTED, "isa", "this CPU has no SSE 4.2");
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++)
        known = known || strcmp(wanted, sets[i]) == 0;
    if (known) return 0;
    return fault_set(fault, ERR_UNSUPPORTED, "SHEARWATER_ISA",
                     "\"%.32s\" is no instruction set: sse4.2, avx2 or avx512", wanted);
}
