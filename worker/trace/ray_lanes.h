#pragma once
/* lane_kernels' sanitise and camera_row. Included by lane_kernels_body.h only, after camera_lanes.h
 * and light_lanes.h. */
#include <math.h>

#include "worker/trace/light.h"
#include "worker/trace/primary.h"

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

static uint32_t kernel_camera_row(const struct plan *plan, int32_t x, int32_t y, uint32_t count,
                                  struct primary_packet *row)
{
    uint32_t rejected = 0;
    for (uint32_t k = 0; k < count; k++, x += LANES_ACROSS) {
        _Alignas(LANES_ALIGN) float px[LANES], py[LANES];
        for (int32_t i = 0; i < LANES; i++) {
            const int32_t at_x = x + i % LANES_ACROSS, at_y = y + i / LANES_ACROSS;
            px[i] = (float)at_x + 0.5f;
            py[i] = (float)at_y + 0.5f;
            row[k].valid.on[i] = -((at_x < plan->width_px) & (at_y < plan->height_px));
        }
        kernel_camera_rays(plan, px, py, &row[k].rays.ray);
        rejected += kernel_sanitise(&row[k].rays.ray, &row[k].valid);
    }
    return rejected;
}
