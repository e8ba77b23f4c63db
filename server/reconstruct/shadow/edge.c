#include "server/reconstruct/shadow/edge.h"

#include "server/reconstruct/shadow/strata.h"

/* Pixels at 9 samples; they shrink with m(N), as the penumbra's own width does. */
#define NARROW_PX 1.0f /* filters this wide and narrower are replaced */
#define WIDE_PX   1.5f /* from here on none is */

#define PLANES 3 /* of numbers; then the words of bits */

struct edges {
    const struct receiver_light *light;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    const struct receivers *receivers;
    float scale;
    uint32_t count;   /* narrow pixels */
    uint32_t *pixels; /* their places, */
    uint32_t *asked;  /* their numbers among all that were asked for, */
    float *sigma_px, *seen;
    void *lists; /* owned: these four */
    float *estimate, *jitter[2];
    uint32_t *bits;
    size_t stride;
    void *planes; /* owned: these four */
};

/* Returns how much of the sheared filter's answer stays. */
static float kept_share(const struct edges *e, float sigma_px)
{
    const float s = (sigma_px / e->scale - NARROW_PX) / (WIDE_PX - NARROW_PX);
    const float within = s > 0.0f ? s < 1.0f ? s : 1.0f : 0.0f;
    return within * within * (3.0f - 2.0f * within);
}

/* Lists the pixels whose filter is narrow. All answers begin as not found. */
static int find_narrow(struct edges *e, const uint32_t *pixels, uint32_t count,
                       struct edge_answer *out)
{
    uint32_t *lists = e->lists = scratch_take(e->patch->scratch, 4 * sizeof *lists * (count + 1));
    if (!lists) return ERR_MEMORY;
    e->pixels = lists;
    e->asked = lists + count;
    e->sigma_px = (float *)(void *)(lists + 2 * (size_t)count);
    e->seen = (float *)(void *)(lists + 3 * (size_t)count);
    for (uint32_t k = 0; k < count; k++) {
        const float sigma_px = e->receivers->pixels.width_px[pixels[k]];
        out[k] = (struct edge_answer){-1.0f, 1.0f, sigma_px};
        if (!(sigma_px < WIDE_PX * e->scale)) continue;
        e->pixels[e->count] = pixels[k];
        e->asked[e->count] = k;
        e->sigma_px[e->count++] = sigma_px;
    }
    return 0;
}

static int create_planes(struct edges *e)
{
    const uint32_t strata = e->light->strata * e->light->strata;
    float **const planes[PLANES] = {&e->estimate, &e->jitter[0], &e->jitter[1]};
    e->stride = (size_t)rect_area(e->receivers->rect) + SHADOW_PLANE_PAD;
    float *memory = e->planes =
        scratch_take(e->patch->scratch, (PLANES + (strata + 31) / 32) * e->stride * sizeof *memory);
    if (!memory) return ERR_MEMORY;
    for (size_t k = 0; k < PLANES; k++, memory += e->stride) *planes[k] = memory;
    e->bits = (uint32_t *)(void *)memory;
    return 0;
}

/* Loads pixels of a row from image pixel (x, y) on, at most STRATA_RUN. */
static void load_run(const struct edges *e, int32_t x, int32_t y, uint32_t count)
{
    const size_t at = patch_pixel(e->patch, x, y), to = receivers_pixel(e->receivers, x, y);
    strata_bits(e->light, e->patch, at, count, e->bits + to, e->stride);
    strata_row_jitters(e->light, x, y, count, e->jitter[0] + to, e->jitter[1] + to);
    strata_estimate(e->light, e->patch, e->kernels, x, y, count, e->estimate + to);
}

/* Loads pixels x0 .. x1 - 1 of a row in the receivers' rect. Pixels off the patch are not lit. */
static void load_row(const struct edges *e, int32_t x0, int32_t x1, int32_t y)
{
    const struct rect seen = rect_intersect((struct rect){x0, y, x1, y + 1}, e->patch->rect);
    if (rect_is_empty(seen)) return;
    for (int32_t x = seen.x0; x < seen.x1; x += STRATA_RUN) {
        const int32_t left = seen.x1 - x;
        load_run(e, x, y, (uint32_t)(left < STRATA_RUN ? left : STRATA_RUN));
    }
}

/* Every row from the first to the last pixel that a window on it can reach. */
static int load_windows(const struct edges *e)
{
    const struct rect rect = e->receivers->rect;
    const int32_t width = rect_width(rect), height = rect_height(rect);
    int32_t *first = scratch_take(e->patch->scratch, 2 * (size_t)height * sizeof *first);
    if (!first) return ERR_MEMORY;
    int32_t *last = first + height;
    for (int32_t y = 0; y < height; y++) {
        first[y] = width;
        last[y] = -1;
    }
    for (uint32_t k = 0; k < e->count; k++) {
        const int32_t x = (int32_t)e->pixels[k] % width, y = (int32_t)e->pixels[k] / width;
        for (int32_t v = y - EDGE_REACH_PX; v <= y + EDGE_REACH_PX; v++) {
            first[v] = x - EDGE_REACH_PX < first[v] ? x - EDGE_REACH_PX : first[v];
            last[v] = x + EDGE_REACH_PX > last[v] ? x + EDGE_REACH_PX : last[v];
        }
    }
    for (int32_t y = 0; y < height; y++)
        if (first[y] <= last[y])
            load_row(e, rect.x0 + first[y], rect.x0 + last[y] + 1, rect.y0 + y);
    scratch_give(e->patch->scratch, first);
    return 0;
}

static void run(const struct edges *e)
{
    const struct edge_field field = {.light = e->light,
                                     .width = rect_width(e->receivers->rect),
                                     .scale = e->scale,
                                     .pixels = &e->receivers->pixels,
                                     .seen = e->estimate,
                                     .jitter = {e->jitter[0], e->jitter[1]},
                                     .bits = e->bits,
                                     .stride = e->stride};
    e->kernels->filter_edges(&field, e->pixels, e->sigma_px, e->count, e->seen);
}

int edges_filter(const struct receiver_light *light, const struct patch *patch,
                 const struct shadow_kernels *kernels, const struct receivers *receivers,
                 const uint32_t *pixels, uint32_t count, struct edge_answer *out)
{
    struct edges e = {.light = light,
                      .patch = patch,
                      .kernels = kernels,
                      .receivers = receivers,
                      .scale = wedge_scale(light->plan, light->strata)};
    int error = find_narrow(&e, pixels, count, out);
    if (!error && e.count > 0) error = create_planes(&e);
    if (!error && e.count > 0) error = load_windows(&e);
    if (!error && e.count > 0) run(&e);
    for (uint32_t k = 0; !error && k < e.count; k++) {
        if (e.seen[k] < 0.0f) continue;
        out[e.asked[k]] =
            (struct edge_answer){e.seen[k], kept_share(&e, e.sigma_px[k]), e.sigma_px[k]};
    }
    scratch_give(patch->scratch, e.planes);
    scratch_give(patch->scratch, e.lists);
    return error;
}

float edge_join(const struct edge_answer *edge, float sheared)
{
    if (edge->seen < 0.0f) return sheared;
    if (sheared < 0.0f) return edge->seen;
    return edge->seen + edge->kept * (sheared - edge->seen); /* exact where both agree */
}
