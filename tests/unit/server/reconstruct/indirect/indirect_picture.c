#include "tests/unit/server/reconstruct/indirect/indirect_picture.h"

#include <stdlib.h>

void picture_init(struct picture *p, const struct patch *patch)
{
    const size_t area = (size_t)rect_area(patch->rect);
    *p = (struct picture){0};
    for (int c = 0; c < 3; c++) p->channel[c] = calloc(area, sizeof(float));
    p->width = calloc(area, sizeof(float));
    assert_true(p->channel[0] && p->channel[1] && p->channel[2] && p->width);
}

void picture_fini(struct picture *p)
{
    for (int c = 0; c < 3; c++) free(p->channel[c]);
    free(p->width);
}

void filter_blocks(const struct plan *plan, const struct patch *patch, struct rect inner,
                   int32_t side, struct picture *out)
{
    const float *const in[3] = {patch->indirect[0], patch->indirect[1], patch->indirect[2]};
    for (int32_t y = inner.y0; y < inner.y1; y += side) {
        for (int32_t x = inner.x0; x < inner.x1; x += side) {
            const struct rect block =
                rect_intersect((struct rect){x, y, x + side, y + side}, inner);
            assert_int_equal(indirect_filter(plan, patch, block, 3, in, out->channel, out->width,
                                             &out->statistics),
                             0);
        }
    }
}

size_t index_of(const struct patch *patch, int32_t x, int32_t y)
{
    return (size_t)(y - patch->rect.y0) * (size_t)rect_width(patch->rect) +
           (size_t)(x - patch->rect.x0);
}

struct patch *plane_patch(struct plan *plan, int32_t width, int32_t height, float distance,
                          float bounce_distance_min)
{
    struct patch *p;
    room_plan(plan, LINES, INDIRECT_FILTER_CONSTANT, 4);
    plan->width_px = width;
    plan->height_px = height;
    plan->camera.half_width = 0.3f * (float)width / (float)height;
    plan->camera.half_height = 0.3f;
    assert_int_equal(patch_create(plan, (struct rect){0, 0, width, height}, &p), 0);
    for (int32_t y = 0; y < height; y++) {
        for (int32_t x = 0; x < width; x++) {
            const size_t i = index_of(p, x, y);
            float o[3], d[3];
            plan_camera_ray(plan, (float)x + 0.5f, (float)y + 0.5f, o, d);
            p->depth[i] = distance / -d[2];
            p->id[i] = 1;
            p->bounce_distance_min[i] = bounce_distance_min;
            for (int k = 0; k < 3; k++) {
                p->normal[k][i] = k == 2 ? 1.0f : 0.0f;
                p->indirect[k][i] = 1.0f + (float)((x * 7 + y * 3 + k) % 5);
            }
        }
    }
    return p;
}
