#include "server/reconstruct/residual/residual_history.h"

#include <stdlib.h>

int residual_history_create(const struct plan *plan, struct motion *motion,
                            struct residual_history **out)
{
    const size_t area = (size_t)plan->width_px * (size_t)plan->height_px * plan_views(plan);
    struct residual_history *h = calloc(1, sizeof *h);
    *out = h;
    if (!h) return ERR_MEMORY;
    h->plan = *plan;
    h->motion = motion_hold(motion);
    h->holders = 1;
    h->pixels = calloc(area, sizeof *h->pixels);
    if (h->pixels) return 0;
    residual_history_drop(out);
    return ERR_MEMORY;
}

struct residual_history *residual_history_hold(struct residual_history *history)
{
    if (history) history->holders++;
    return history;
}

void residual_history_drop(struct residual_history **history)
{
    struct residual_history *h = *history;
    *history = NULL;
    if (!h || --h->holders > 0) return;
    motion_drop(&h->motion);
    free(h->pixels);
    free(h);
}

/* Pixel (x, y) of the picture; `at` is its place in the field. */
static void take_pixel(const struct residual_history *h, const struct patch *patch,
                       const struct residual_field *f, int32_t x, int32_t y, size_t at,
                       struct residual_past *out)
{
    const size_t i = patch_pixel(patch, x, y), plane = f->features.shape.plane;
    struct motion_point point;
    motion_show(&h->plan, patch, x, y, &point);
    *out = (struct residual_past){.id = 0};
    if (point.is_far || !(f->features.share[at] > 0.0f)) return;
    for (int k = 0; k < 2; k++)
        for (size_t c = 0; c < RESIDUAL_HISTORY_LIGHT; c++)
            out->half[k][c] = f->light[c / 3].half[k][c % 3 * plane + at];
    for (size_t c = 0; c < 3; c++) {
        out->at[c] = (float)point.at[c];
        out->normal[c] = patch->normal[c][i];
        out->mean_normal[c] = f->features.normal[c * plane + at];
        out->albedo[c] = f->features.albedo[c * plane + at];
        out->tint[c] = f->features.tint[c * plane + at];
    }
    out->seen = patch->path_coverage[i] / patch->paths.spp[i];
    out->nearness = f->features.nearness[at];
    out->mixture = residual_nearness(&f->features, out->nearness) / patch->depth[i];
    out->alpha = f->features.alpha[at];
    out->id = point.id;
}

int residual_history_take(struct residual_history *history, uint32_t view,
                          const struct patch *patch)
{
    struct residual_field field;
    const struct rect r = patch->rect;
    const int error = residual_field_read(patch, &field);
    for (int32_t y = r.y0; y < r.y1 && !error; y++)
        for (int32_t x = r.x0; x < r.x1; x++)
            take_pixel(history, patch, &field, x, y,
                       residual_at(&field.features.shape, x - r.x0, y - r.y0),
                       residual_history_at(history, view, x, y));
    residual_field_fini(&field);
    return error;
}
