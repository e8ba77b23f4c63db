#pragma once
/* Plans on the wire, there and back; what a change of the plan of plan_case.h is refused with, and
 * changes that several tests need. */
#include <string.h>

#include "tests/unit/proto/plan_case.h"
#include "tests/unit/unit.h"

void encode(const struct plan *plan, struct bytes_writer *w);

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
int decode(const uint8_t *data, size_t size_bytes, struct plan *out, struct fault *fault);

/* Changes one thing in the plan and expects a fault, or none for ERR_OK. */
#define EXPECT(change, expected, place)                                                            \
    do {                                                                                           \
        static struct plan plan, got;                                                              \
        struct bytes_writer w;                                                                     \
        struct fault fault = {0};                                                                  \
        plan_case(&plan);                                                                          \
        change;                                                                                    \
        encode(&plan, &w);                                                                         \
        const int error = decode(w.data, w.size_bytes, &got, &fault);                              \
        if (error != (expected) || strcmp(fault.pointer, place) != 0)                              \
            fail_msg(#change " gives %s at \"%s\": %s", error_name(error), fault.pointer,          \
                     fault.detail);                                                                \
        if (expected) assert_true(fault.code == (expected) && fault.detail[0]);                    \
        bytes_writer_fini(&w);                                                                     \
    } while (0)

void without_lens(struct plan *plan);

#define ADAPTIVE                                                                                   \
    (plan.indirect_filter = INDIRECT_FILTER_ADAPTIVE, plan.adaptive.mu = 1.5f,                     \
     plan.adaptive.rays_max = 100,                                                                 \
     plan.planes &=                                                                                \
     ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF)))
