#pragma once
/* hit_kernels' sanitise and camera_row. */
#include <math.h>

#include "worker/trace/hit/camera_lanes.h"
#include "worker/trace/hit/primary.h"

static uint32_t kernel_sanitise(const struct RTCRay16 *restrict r,
                                struct lanes_mask *restrict valid)
{
    int32_t rejected = 0;
    for (int i = 0; i < LANES; i++) {
        int32_t origin = (fabsf(r->org_x[i]) < ORIGIN_MAX) & (fabsf(r->org_y[i]) < ORIGIN_MAX) &
                         (fabsf(r->org_z[i]) < ORIGIN_MAX);
        int32_t direction = (fabsf(r->dir_x[i]) < INFINITY) & (fabsf(r->dir_y[i]) < INFINITY) &
                            (fabsf(r->dir_z[i]) < INFINITY);
        int32_t usable = -(origin & direction & (r->tnear[i] >= 0.0f) & (r->tfar[i] > r->tnear[i]));
        rejected -= valid->on[i] & ~usable;
        valid->on[i] &= usable;
    }
    return (uint32_t)rejected;
}

/* Computes the columns or rows of a block's pixel centres on the camera's screen, as
 * kernel_camera_rays does. It needs four divisions instead of sixteen. */
static void place_lines(int32_t first, float size, float half, float centre, float sign,
                        float out[LANES_ACROSS])
{
    for (int32_t k = 0; k < LANES_ACROSS; k++) {
        const float at = 2.0f * ((float)(first + k) + 0.5f) / size;
        out[k] = ((sign > 0.0f ? at - 1.0f : 1.0f - at) - centre) * half;
    }
}

static uint32_t kernel_camera_row(const struct plan *plan, int32_t x, int32_t y, uint32_t count,
                                  struct primary_packet *row)
{
    const struct plan_camera *c = &plan->camera;
    float across[LANES_ACROSS], down[LANES_ACROSS];
    _Alignas(LANES_ALIGN) float a[LANES], b[LANES];
    uint32_t rejected = 0;
    place_lines(y, (float)plan->height_px, c->half_height, c->centre_y, -1.0f, down);
    for (int i = 0; i < LANES; i++) b[i] = down[i / LANES_ACROSS];
    for (uint32_t k = 0; k < count; k++, x += LANES_ACROSS) {
        place_lines(x, (float)plan->width_px, c->half_width, c->centre_x, 1.0f, across);
        for (int32_t i = 0; i < LANES; i++) {
            a[i] = across[i % LANES_ACROSS];
            row[k].valid.on[i] = -1;
        }
        if (x + LANES_ACROSS > plan->width_px || y + LANES_ACROSS > plan->height_px)
            for (int32_t i = 0; i < LANES; i++)
                row[k].valid.on[i] = -((x + i % LANES_ACROSS < plan->width_px) &
                                       (y + i / LANES_ACROSS < plan->height_px));
        camera_rays_through(c, a, b, &row[k].rays.ray);
        rejected += kernel_sanitise(&row[k].rays.ray, &row[k].valid);
    }
    return rejected;
}
