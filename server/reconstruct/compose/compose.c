#include "server/reconstruct/compose/compose.h"

#include <math.h>
#include <string.h>

#include "server/reconstruct/compose/compose_diffuse.h"
#include "server/reconstruct/compose/resolve_run.h"

/* The image's planes by what goes into them; NULL where the image has none. */
struct targets {
    const struct plane *beauty[4], *direct[3], *indirect[3], *emission[3], *albedo[3];
    bool resolved;          /* any of the above but emission alone */
    bool adds, adds_albedo; /* to what paths have put there; the latter into albedo */
    bool adds_emission;     /* and into emission, beside the whole albedo */
};

static void find_planes(const struct image *image, const char *const *names, int count,
                        const struct plane **out)
{
    for (int c = 0; c < count; c++) out[c] = image_plane(image, names[c]);
}

static void find_targets(const struct image *image, struct targets *t)
{
    static const char *const beauty[] = {"R", "G", "B", "A"};
    static const char *const direct[] = {"direct.R", "direct.G", "direct.B"};
    static const char *const indirect[] = {"indirect.R", "indirect.G", "indirect.B"};
    static const char *const emission[] = {"emission.R", "emission.G", "emission.B"};
    static const char *const albedo[] = {"albedo.R", "albedo.G", "albedo.B"};
    find_planes(image, beauty, 4, t->beauty);
    find_planes(image, direct, 3, t->direct);
    find_planes(image, indirect, 3, t->indirect);
    find_planes(image, emission, 3, t->emission);
    find_planes(image, albedo, 3, t->albedo);
    t->resolved = t->beauty[0] || t->direct[0] || t->indirect[0] || t->albedo[0];
}

/* Pixels side by side: where the first is in the image and in the patch. */
struct run {
    int32_t x, y;
    uint32_t count;
    size_t i;
};

static void put_run(const struct plane *plane, const struct run *run, const float *values)
{
    if (plane) memcpy(plane_at(plane, run->x, run->y), values, run->count * sizeof *values);
}

static void add_run(const struct plane *plane, const struct run *run, const float *restrict values)
{
    if (!plane) return;
    float *restrict to = plane_at(plane, run->x, run->y);
    for (uint32_t k = 0; k < run->count; k++) to[k] += values[k];
}

static void lay_run(const struct plane *plane, const struct run *run, const float *values,
                    bool adds)
{
    if (adds)
        add_run(plane, run, values);
    else
        put_run(plane, run, values);
}

static void put_resolved(const struct targets *t, const struct run *run,
                         const struct resolved_run *resolved, const float *const emission[3])
{
    for (int c = 0; c < 3; c++) {
        lay_run(t->beauty[c], run, resolved->total[c], t->adds);
        if (emission[c]) add_run(t->beauty[c], run, emission[c]);
        lay_run(t->direct[c], run, resolved->direct[c], t->adds);
        lay_run(t->indirect[c], run, resolved->indirect[c], t->adds);
        if (!t->adds_emission) lay_run(t->albedo[c], run, resolved->albedo[c], t->adds_albedo);
    }
    put_run(t->beauty[3], run, resolved->coverage);
}

/* What bounce rays and the few samples of a pixel's surfaces leave uncertain. */
static void put_variance(const struct resolver *r, const struct resolved *pixel, int32_t x,
                         int32_t y, struct block_variance *variance)
{
    if (!r->errors) return;
    const size_t i = block_variance_index(variance, x, y);
    for (int c = 0; c < 3; c++) {
        variance->by_source[ERROR_SOURCE_BOUNCES][c][i] = pixel->error[c] * pixel->error[c];
        variance->by_source[ERROR_SOURCE_LOBES][c][i] =
            pixel->glossy_error[c] * pixel->glossy_error[c];
        variance->by_source[ERROR_SOURCE_CENTRES][c][i] = pixel->spread[c];
    }
}

/* The least and the most emission of the pixels around. */
static void emission_range(const struct patch *p, int c, int32_t x, int32_t y, float range[2])
{
    const struct rect near = rect_intersect((struct rect){x - 1, y - 1, x + 2, y + 2}, p->core);
    range[0] = range[1] = p->emission[c][patch_pixel(p, x, y)];
    for (int32_t v = near.y0; v < near.y1; v++)
        for (int32_t u = near.x0; u < near.x1; u++) {
            const float there = p->emission[c][patch_pixel(p, u, v)];
            range[0] = there < range[0] ? there : range[0];
            range[1] = there > range[1] ? there : range[1];
        }
}

/* At edges of lamps emission has 64 samples a pixel (worker/tile): of points that are spread over
 * it the variance is twice the power -3/2 of their number. */
#define EMISSION_SHARE 0.00390625f

/* Numbers of a mean m between `least` and `most` have a variance of (most - m) (m - least) at most,
 * which two surfaces have. */
static void add_emission_variance(const struct resolver *r, int32_t x, int32_t y,
                                  struct block_variance *variance)
{
    const size_t i = patch_pixel(r->patch, x, y), to = block_variance_index(variance, x, y);
    if (!r->errors || !r->patch->emission[0] || r->subs == 0) return;
    for (int c = 0; c < 3; c++) {
        float range[2];
        const float mean = r->patch->emission[c][i];
        emission_range(r->patch, c, x, y, range);
        variance->by_source[ERROR_SOURCE_CENTRES][c][to] +=
            EMISSION_SHARE * (range[1] - mean) * (mean - range[0]);
    }
}

/* What resolve_run leaves. */
static void resolve_rest(const struct resolver *r, const struct run *run,
                         struct resolved_run *resolved, struct block_variance *variance,
                         struct block_statistics *statistics)
{
    for (uint32_t k = 0; k < run->count; k++) {
        struct resolved pixel;
        if (resolved->plain[k]) continue;
        resolve_pixel(r, run->i + k, &pixel);
        resolved_run_set(resolved, k, &pixel);
        put_variance(r, &pixel, run->x + (int32_t)k, run->y, variance);
        add_emission_variance(r, run->x + (int32_t)k, run->y, variance);
        statistics->pixels_mixed += pixel.mixed;
        statistics->sub_samples_lone += pixel.lone;
        statistics->sub_samples_unmatched += pixel.unmatched;
        statistics->pixels_background += pixel.coverage == 0.0f;
    }
}

static void light_run(const struct resolver *r, const struct targets *t, const struct run *run,
                      struct block_variance *variance, struct block_statistics *statistics)
{
    const float *emission[3] = {NULL, NULL, NULL};
    struct resolved_run resolved;
    for (int c = 0; c < 3 && r->patch->emission[0]; c++) {
        emission[c] = r->patch->emission[c] + run->i;
        lay_run(t->emission[c], run, emission[c], t->adds_emission);
    }
    if (!t->resolved && !r->errors) return;
    resolve_run(r, run->i, run->count, &resolved);
    resolve_rest(r, run, &resolved, variance, statistics);
    put_resolved(t, run, &resolved, emission);
}

static void compose_light(const struct resolver *r, const struct targets *t, struct rect block,
                          struct block_variance *variance, struct block_statistics *statistics)
{
    for (int32_t y = block.y0; y < block.y1; y++)
        for (int32_t x = block.x0; x < block.x1; x += RESOLVE_RUN) {
            const int32_t left = block.x1 - x;
            const struct run run = {x, y, (uint32_t)(left < RESOLVE_RUN ? left : RESOLVE_RUN),
                                    patch_pixel(r->patch, x, y)};
            light_run(r, t, &run, variance, statistics);
        }
}

/* A plane of the patch as it is; NULL leaves zeros. */
static void copy_plane(const struct patch *patch, const float *in, struct rect block,
                       const struct plane *out)
{
    if (!in || !out) return;
    size_t size_bytes = (size_t)rect_width(block) * sizeof(float);
    for (int32_t y = block.y0; y < block.y1; y++) {
        memcpy(plane_at(out, block.x0, y), in + patch_pixel(patch, block.x0, y), size_bytes);
    }
}

static void compose_ids(const struct patch *patch, struct rect block, const struct plane *out)
{
    if (!out || !patch->id) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        const uint32_t *in = patch->id + patch_pixel(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        /* At most LIMIT_INSTANCES + 1, far below 2^24: exact. */
        for (int32_t x = 0; x < rect_width(block); x++) to[x] = (float)in[x];
    }
}

static void compose_geometry(const struct patch *patch, struct rect block, struct image *image)
{
    static const char *const normal[] = {"normal.X", "normal.Y", "normal.Z"};
    for (int c = 0; c < 3; c++) {
        copy_plane(patch, patch->normal[c], block, image_plane(image, normal[c]));
    }
    copy_plane(patch, patch->depth, block, image_plane(image, "depth.Z"));
    compose_ids(patch, block, image_plane(image, "id.I"));
}

static uint32_t light_strata(const struct plan *plan, uint32_t k)
{
    return plan->lights[k].strata_per_axis * plan->lights[k].strata_per_axis;
}

static uint32_t bounce_rays(const struct plan *plan)
{
    return plan->indirect_strata_per_axis * plan->indirect_strata_per_axis;
}

/* Adds so many rays, the pixel's bounce rays and those of its glossy lobe to the pixels that show a
 * surface. */
static void add_samples(const struct plan *plan, const struct patch *patch, uint32_t rays,
                        struct rect block, const struct plane *out)
{
    const float bounces = (float)bounce_rays(plan);
    if (!out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        size_t i = patch_pixel(patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++, i++) {
            if (!patch_has_surface(patch, i)) continue;
            const int lent = patch->lent ? patch->lent[i] : 0;
            to[x] += (float)rays;
            if (!(lent & PATCH_LENT_BOUNCES)) to[x] += patch->bounces ? patch->bounces[i] : bounces;
            if (patch->glossy_alpha && patch_is_glossy(patch, i) && !(lent & PATCH_LENT_LOBE))
                to[x] += patch->glossy_rays ? patch->glossy_rays[i] : bounces;
        }
    }
}

static void compose_samples(const struct resolver *r, struct rect block, const struct plane *out)
{
    const struct plan *plan = r->plan;
    uint32_t rays = 0;
    if (!out) return;
    for (uint32_t k = 0; k < plan->light_count; k++) rays += light_strata(plan, k);
    for (int32_t y = block.y0; y < block.y1 && plan->paths.spp == 0; y++)
        memset(plane_at(out, block.x0, y), 0, (size_t)rect_width(block) * sizeof(float));
    add_samples(plan, r->patch, rays, block, out);
}

/* Linear fits of a share may exceed 1. */
static void compose_occlusion(const struct resolver *r, struct rect block, const struct plane *out)
{
    const float *visible = r->lighting->visibility;
    if (!out || !r->patch->ambient_visibility) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        size_t i = patch_pixel(r->patch, block.x0, y);
        float *to = plane_at(out, block.x0, y);
        for (int32_t x = 0; x < rect_width(block); x++, i++)
            to[x] = patch_has_surface(r->patch, i) ? fminf(visible[i], 1.0f) : 1.0f;
    }
}

static uint32_t seen_strata(const struct patch *patch, uint32_t k, uint32_t bytes, size_t i)
{
    size_t area = (size_t)rect_area(patch->rect);
    uint32_t seen = 0;
    for (uint32_t b = 0; b < bytes; b++) {
        seen += (uint32_t)__builtin_popcount(patch->lights[k].visibility[b * area + i]);
    }
    return seen;
}

static float visibility(const struct plan *plan, const struct patch *patch, size_t i)
{
    uint32_t seen = 0, all = 0;
    if (!patch_has_surface(patch, i)) return 0.0f;
    for (uint32_t k = 0; k < plan->light_count; k++) {
        uint32_t strata = light_strata(plan, k);
        if (!patch->lights[k].visibility || plan->lights[k].type != LIGHT_RECTANGLE) continue;
        seen += seen_strata(patch, k, (strata + 7) / 8, i);
        all += strata;
    }
    return all > 0 ? (float)seen / (float)all : 1.0f;
}

static void compose_visibility(const struct plan *plan, const struct patch *patch,
                               struct rect block, const struct plane *out)
{
    if (!out) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        size_t i = patch_pixel(patch, block.x0, y);
        for (int32_t x = block.x0; x < block.x1; x++, i++) {
            *plane_at(out, x, y) = visibility(plan, patch, i);
        }
    }
}

static void compose_slopes(const struct plan *plan, const struct patch *patch, struct rect block,
                           struct image *image)
{
    for (uint32_t k = 0; k < plan->light_count; k++) {
        const struct patch_light *light = &patch->lights[k];
        if (!light->slope_min) continue;
        copy_plane(patch, light->slope_min, block, image_plane(image, "slope_min.S"));
        copy_plane(patch, light->slope_max, block, image_plane(image, "slope_max.S"));
        return;
    }
}

void compose_centre(const struct plan *plan, const struct patch *patch, struct rect block,
                    struct image *image)
{
    compose_geometry(patch, block, image);
    compose_visibility(plan, patch, block, image_plane(image, "visibility.V"));
    compose_slopes(plan, patch, block, image);
}

static void compose_rest(const struct resolver *r, struct rect block, struct image *image)
{
    compose_occlusion(r, block, image_plane(image, "occlusion.O"));
    copy_plane(r->patch, r->lighting->width_px, block, image_plane(image, "filter_width.W"));
}

void compose_light_field(const struct resolver *resolver, struct rect block, struct image *image,
                         struct block_variance *variance, struct block_statistics *statistics)
{
    struct targets targets;
    struct resolver own = *resolver;
    find_targets(image, &targets);
    own.parts = targets.direct[0] || targets.indirect[0];
    targets.adds = own.plan->paths.spp > 0;
    targets.adds_emission = own.plan->paths.without_diffuse_direct == DIRECT_LEFT_LISTED;
    targets.adds_albedo = own.patch->path_albedo[0] != NULL;
    compose_light(&own, &targets, block, variance, statistics);
    compose_diffuse_direct(resolver, block, image);
    compose_diffuse_indirect(resolver, block, image);
    compose_samples(resolver, block, image_plane(image, "samples.N"));
    compose_rest(resolver, block, image);
}

static void add(const struct plane *plane, int32_t x, int32_t y, float value)
{
    if (plane) *plane_at(plane, x, y) += value;
}

static void add_indirect(const struct resolver *r, const struct targets *t, struct rect block,
                         struct block_variance *variance, struct block_statistics *statistics)
{
    if (!t->beauty[0] && !t->indirect[0] && !r->errors) return;
    for (int32_t y = block.y0; y < block.y1; y++) {
        size_t i = patch_pixel(r->patch, block.x0, y);
        for (int32_t x = block.x0; x < block.x1; x++, i++) {
            struct resolved pixel;
            resolve_pixel(r, i, &pixel);
            for (int c = 0; c < 3; c++) {
                add(t->beauty[c], x, y, pixel.indirect[c]);
                add(t->indirect[c], x, y, pixel.indirect[c]);
            }
            put_variance(r, &pixel, x, y, variance);
            statistics->pixels_mixed += pixel.mixed;
            statistics->sub_samples_lone += pixel.lone;
            statistics->sub_samples_unmatched += pixel.unmatched;
        }
    }
}

void compose_beside_paths(const struct resolver *resolver, struct rect block, struct image *image,
                          struct block_variance *variance, struct block_statistics *statistics)
{
    struct targets targets;
    if (resolver->plan->paths.without_diffuse_indirect) {
        find_targets(image, &targets);
        add_indirect(resolver, &targets, block, variance, statistics);
        compose_diffuse_indirect(resolver, block, image);
    }
    add_samples(resolver->plan, resolver->patch, 0, block, image_plane(image, "samples.N"));
    compose_rest(resolver, block, image);
}

void compose_error(const struct block_variance *variance, struct image *image)
{
    static const char *const names[] = {"error.R", "error.G", "error.B"};
    const struct rect r = variance->rect;
    for (int c = 0; c < 3; c++) {
        const struct plane *out = image_plane(image, names[c]);
        if (!out) continue;
        for (int32_t y = r.y0; y < r.y1; y++) {
            size_t i = block_variance_index(variance, r.x0, y);
            for (int32_t x = r.x0; x < r.x1; x++, i++)
                *plane_at(out, x, y) = sqrtf(variance->by_source[ERROR_SOURCE_PATHS][c][i] +
                                             variance->by_source[ERROR_SOURCE_BOUNCES][c][i] +
                                             variance->by_source[ERROR_SOURCE_LOBES][c][i] +
                                             variance->by_source[ERROR_SOURCE_CENTRES][c][i]);
        }
    }
}
