#pragma once
/* Plans on the wire, there and back; what a change of the plan of plan_case.h is refused with, and
 * changes that several tests need. */
#include <stdlib.h>

#include "tests/unit/proto/plan_case.h"
#include "tests/unit/unit.h"

static inline void encode(const struct plan *plan, struct bytes_writer *w)
{
    bytes_writer_init(w);
    plan_encode(w, plan);
    assert_false(w->failed);
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static inline int decode(const uint8_t *data, size_t size_bytes, struct plan *out,
                         struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    const int error = plan_decode(exact, size_bytes, out, fault);
    free(exact);
    return error;
}

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

static inline void without_lens(struct plan *plan)
{
    plan->camera.aperture_radius = 0;
    plan->planes &= ~PLANES_LENS;
    plan->lens_strata_per_axis = plan->lens_light = 0;
}

#define RATE                                                                                       \
    (plan.indirect_filter = INDIRECT_FILTER_RATE, plan.rate.mu = 1.5f, plan.rate.rays_most = 100,  \
     plan.planes &=                                                                                \
     ~(PLANE_BIT(INDIRECT_HALVES) | PLANE_BIT(INDIRECT_STRATA) | PLANE_BIT(GLOSSY_HALF)))
