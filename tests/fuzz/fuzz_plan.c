/* The frame plan. What decodes must encode back to the same bytes, must have room for its samples
 * or say so, and its rays must be finite. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "proto/samples.h"

static void check_ray(const struct plan *plan, float px, float py)
{
    float origin[3], direction[3];
    plan_camera_ray(plan, px, py, origin, direction);
    for (int i = 0; i < 3; i++)
        if (!isfinite(origin[i]) || !isfinite(direction[i])) abort();
    if (!isfinite(plan_pixel_size(plan, 1.0f))) abort();
}

static void check_layout(const struct plan *plan)
{
    struct samples_layout layout;
    const int error = samples_layout_init(&layout, plan, 0, plan->tile_px, plan->tile_px);
    if (error == ERR_LIMIT) return;
    if (error || layout.total_bytes > LIMIT_FRAME_BYTES) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes)
{
    static struct plan plan;
    struct fault fault = {0};
    struct bytes_writer w;
    if (plan_decode(data, size_bytes, &plan, &fault) != 0) {
        if (fault.code >= 0 || fault.detail[0] == '\0') abort();
        return 0;
    }
    bytes_writer_init(&w);
    plan_encode(&w, &plan);
    if (w.failed || w.size_bytes != size_bytes) abort();
    if (memcmp(w.data, data, size_bytes) != 0) abort();
    bytes_writer_fini(&w);
    check_ray(&plan, 0.0f, 0.0f);
    check_ray(&plan, (float)plan.width_px, 0.5f * (float)plan.height_px);
    check_layout(&plan);
    return 0;
}
