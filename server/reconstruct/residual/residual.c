#include "server/reconstruct/residual/residual.h"

#include <math.h>

#include "server/reconstruct/residual/residual_error.h"
#include "server/reconstruct/residual/residual_lone.h"
#include "server/reconstruct/residual/residual_pass.h"
#include "server/reconstruct/residual/residual_smooth.h"
#include "server/reconstruct/residual/residual_spikes.h"
#include "server/reconstruct/residual/residual_spread.h"
#include "server/reconstruct/residual/residual_window.h"

int32_t residual_halo_px(const struct plan *plan)
{
    int32_t halo = 0;
    if (plan->residual_filter != RESIDUAL_FILTER_HALVES) return 0;
    for (int k = 0; k < RESIDUAL_PASSES; k++) halo += residual_reach_px(k);
    halo += RESIDUAL_LONE_REACH_PX;
    if (halo < RESIDUAL_SPREAD_PX) halo = RESIDUAL_SPREAD_PX;
    halo += RESIDUAL_SMOOTH_REACH_PX + RESIDUAL_SPIKES_LIMIT_PX;
    if (plan->paths.spp == 1) halo += 1; /* pixels beside lend halves */
    if (plan->temporal > 0) halo += RESIDUAL_WINDOW_REACH_PX;
    return halo + (plan->planes >> PLANE_PATH_M2 & 1u ? RESIDUAL_ERROR_REACH_PX : 0);
}

static int picture_create(struct scratch *scratch, struct rect block, struct residual_picture *out)
{
    const size_t area = (size_t)rect_area(block);
    float *next = scratch_take(scratch, 9 * area * sizeof *next);
    out->block = block;
    out->scratch = scratch;
    out->memory = next;
    if (!next) return ERR_MEMORY;
    for (int c = 0; c < 3; c++, next += 3 * area) {
        out->radiance[c] = next;
        out->diffuse_direct[c] = next + area;
        out->diffuse_indirect[c] = next + 2 * area;
    }
    return 0;
}

void residual_picture_fini(struct residual_picture *picture)
{
    scratch_give(picture->scratch, picture->memory);
    picture->memory = NULL;
}

/* Where light meets albedo again. Nothing is negative but by the filter's error. */
static void compose_pixel(const struct residual_field *f, const struct residual_spikes *s,
                          const struct patch *p, size_t i, size_t at, struct residual_picture *out,
                          size_t to)
{
    const size_t plane = f->features.shape.plane;
    for (size_t c = 0; c < 3; c++) {
        const size_t k = c * plane + at;
        float direct = f->light[RESIDUAL_DIRECT].half[0][k];
        float indirect = f->light[RESIDUAL_INDIRECT].half[0][k];
        float rest = f->light[RESIDUAL_REST].half[0][k];
        if (s->excess) {
            direct += s->excess[k];
            indirect += s->excess[3 * plane + k];
            rest += s->excess[6 * plane + k];
        }
        const float sum =
            p->path_emission[c][i] / p->paths.spp[i] +
            (f->features.albedo[k] * (direct + indirect) + rest * f->features.tint[k]);
        out->radiance[c][to] = sum > 0.0f ? sum : 0.0f;
        out->diffuse_direct[c][to] = direct;
        out->diffuse_indirect[c][to] = indirect;
    }
}

static void copy_pixel(const struct patch *p, size_t i, struct residual_picture *out, size_t to)
{
    for (int c = 0; c < 3; c++) {
        out->radiance[c][to] = p->path_radiance[c][i] / p->paths.spp[i];
        out->diffuse_direct[c][to] = p->path_diffuse_direct[c][i] / p->paths.spp[i];
        out->diffuse_indirect[c][to] =
            p->path_diffuse_indirect[c] ? p->path_diffuse_indirect[c][i] / p->paths.spp[i] : 0.0f;
    }
}

static void compose(const struct patch *patch, const struct residual_field *f,
                    const struct residual_spikes *s, struct residual_picture *out,
                    struct residual_statistics *statistics)
{
    const struct rect b = out->block;
    for (int32_t y = b.y0; y < b.y1; y++)
        for (int32_t x = b.x0; x < b.x1; x++) {
            const size_t i = patch_pixel(patch, x, y), to = residual_picture_at(out, x, y);
            const size_t at =
                residual_at(&f->features.shape, x - patch->rect.x0, y - patch->rect.y0);
            if (residual_is_filtered(&f->features, at)) {
                compose_pixel(f, s, patch, i, at, out, to);
                statistics->pixels++;
            } else {
                copy_pixel(patch, i, out, to);
            }
        }
}

/* In the patch's own coordinates. */
static struct rect own_rect(const struct patch *patch, struct rect r)
{
    return (struct rect){r.x0 - patch->rect.x0, r.y0 - patch->rect.y0, r.x1 - patch->rect.x0,
                         r.y1 - patch->rect.y0};
}

/* The block, and as much around as the passes after need. */
static struct rect area_of(const struct patch *patch, struct rect block, int number)
{
    const struct rect whole = {0, 0, rect_width(patch->rect), rect_height(patch->rect)};
    struct rect area = rect_grow(own_rect(patch, block), RESIDUAL_LONE_REACH_PX);
    for (int k = number + 1; k < RESIDUAL_PASSES; k++) area = rect_grow(area, residual_reach_px(k));
    return rect_intersect(area, whole);
}

static int run_passes(const struct patch *patch, struct rect block, struct residual_field *field,
                      struct residual_statistics *statistics)
{
    int error = 0;
    for (int k = 0; k < RESIDUAL_PASSES && !error; k++)
        error = residual_pass_run(k, area_of(patch, block, k), field, statistics);
    return error;
}

/* The least rectangle around both. */
static struct rect around(struct rect a, struct rect b)
{
    return (struct rect){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
                         a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1};
}

/* The same, with probes. */
static int run_with_errors(const struct patch *patch, struct rect block,
                           struct residual_field *field, const struct residual_variance *variance,
                           struct residual_statistics *statistics)
{
    struct residual_probes probes;
    int error = residual_probes_create(patch, field, &probes);
    if (error) return error;
    const struct rect read = rect_grow(variance->rect, RESIDUAL_ERROR_REACH_PX);
    error = run_passes(patch, around(block, read), field, statistics);
    if (!error) error = residual_error_find(&probes, patch, field, variance->rect, variance->of);
    residual_probes_fini(&probes);
    return error;
}

int residual_filter(const struct patch *patch, struct rect block,
                    const struct residual_variance *variance, struct residual_picture *out,
                    struct residual_statistics *statistics)
{
    struct residual_field field;
    int error = picture_create(patch->scratch, block, out);
    if (error) return error;
    struct residual_spikes spikes = {NULL};
    error = residual_field_create(patch, &field);
    if (!error) error = residual_spikes_take(&field, own_rect(patch, block), &spikes);
    if (!error)
        error = variance ? run_with_errors(patch, block, &field, variance, statistics)
                         : run_passes(patch, block, &field, statistics);
    if (!error) residual_lone_draw_in(&field, own_rect(patch, block));
    if (!error) compose(patch, &field, &spikes, out, statistics);
    residual_spikes_fini(&spikes);
    residual_field_fini(&field);
    if (error) residual_picture_fini(out);
    return error;
}
