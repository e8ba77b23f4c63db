#include "tests/unit/proto/plan_wire.h"

#include <stdlib.h>
#include <string.h>

void encode(const struct plan *plan, struct bytes_writer *w)
{
    bytes_writer_init(w);
    plan_encode(w, plan);
    assert_false(w->failed);
}

int decode(const uint8_t *data, size_t size_bytes, struct plan *out, struct fault *fault)
{
    uint8_t *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, data, size_bytes);
    const int error = plan_decode(exact, size_bytes, out, fault);
    free(exact);
    return error;
}

void without_lens(struct plan *plan)
{
    plan->camera.aperture_radius = 0;
    plan->planes &= ~PLANES_LENS;
    plan->lens_strata_per_axis = plan->lens_relight = 0;
}
