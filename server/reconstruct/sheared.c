#include "server/reconstruct/sheared.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/strata.h"

#define REFUSAL     1.5f  /* sigma_y that a neighbour's own wedge may be mis-sheared by */
#define WHOLE_LEAST 1e-9f /* of denominators; below, nothing was seen */
#define BATCH       64u
#define SUMS_BYTES  64

struct sheared {
    const struct receiver_light *light;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    struct receivers *receivers;
    struct shadow_field field;
    uint8_t *needs[2];      /* of each pixel: does a walk along axis 0, 1 reach it? */
    uint32_t *order;        /* pixels by slot: those with rows first */
    uint32_t rows, columns; /* slots with rows; slots in all */
    float *cells;           /* 4 r a pixel of a batch */
};

/* Adds the lit pixels that walks along axis 1 reach, or those that only walks along axis 0 do. */
static uint32_t collect(const struct sheared *s, uint32_t axis, uint32_t first)
{
    const size_t area = (size_t)s->field.width * (size_t)s->field.height;
    uint32_t count = first;
    for (size_t i = 0; i < area; i++) {
        if (!s->needs[axis][i] || (axis == 0 && s->needs[1][i])) continue;
        if (receiver_is_lit(s->field.pixels, i)) s->order[count++] = (uint32_t)i;
    }
    return count;
}

/* Who takes part, and in which pass. */
static void find_slots(struct sheared *s, const uint32_t *pixels, uint32_t count)
{
    s->kernels->mark_walks(&s->field, 1, pixels, count, s->needs[1]);
    s->rows = collect(s, 1, 0);
    s->kernels->mark_walks(&s->field, 0, s->order, s->rows, s->needs[0]);
    s->columns = collect(s, 0, s->rows);
    for (uint32_t k = 0; k < s->columns; k++) s->receivers->pixels.slot[s->order[k]] = (int32_t)k;
}

static size_t align_up(size_t bytes)
{
    return (bytes + SUMS_BYTES - 1) / SUMS_BYTES * SUMS_BYTES;
}

static int create_sums(struct sheared *s)
{
    const size_t nodes = shadow_nodes(&s->field);
    const size_t columns = align_up(s->columns * nodes * s->field.lanes * sizeof(float));
    const size_t rows = align_up(s->rows * nodes * 2 * sizeof(float));
    s->field.columns = scratch_take(s->patch->scratch, columns + SUMS_BYTES);
    s->field.rows = scratch_take(s->patch->scratch, rows + SUMS_BYTES);
    s->cells = aligned_alloc(SUMS_BYTES, sizeof(float) * BATCH * 4 * s->field.scale);
    return s->field.columns && s->field.rows && s->cells ? 0 : ERR_MEMORY;
}

static void place_pixels(const struct sheared *s, const uint32_t *pixels, uint32_t count,
                         int32_t *x, int32_t *y)
{
    for (uint32_t k = 0; k < count; k++) {
        x[k] = s->receivers->rect.x0 + (int32_t)(pixels[k] % (uint32_t)s->field.width);
        y[k] = s->receivers->rect.y0 + (int32_t)(pixels[k] / (uint32_t)s->field.width);
    }
}

/* Pass 1a of up to BATCH pixels, whose slots follow each other from `slot` on. */
static void run_columns(struct sheared *s, uint32_t slot, uint32_t count)
{
    const uint32_t *pixels = s->order + slot, l = s->light->strata;
    const float phases = (float)s->field.phases;
    int32_t x[BATCH], y[BATCH];
    float jitter[2][BATCH];
    uint32_t seen[BATCH * SHADOW_STRATA_MAX], columns[SHADOW_STRATA_MAX];
    place_pixels(s, pixels, count, x, y);
    strata_jitters(s->light, x, y, count, jitter[0], jitter[1]);
    for (uint32_t k = 0; k < count; k++) {
        strata_columns(s->light, s->patch, patch_pixel(s->patch, x[k], y[k]), columns);
        for (uint32_t a = 0; a < l; a++) seen[k * l + a] = columns[a] | 1u << l;
        s->receivers->pixels.phase[pixels[k]] = (int32_t)(jitter[1][k] * phases); /* below 1 */
    }
    s->kernels->project_columns(&s->field, pixels, count, jitter[0], seen);
}

static void project_all(struct sheared *s)
{
    for (uint32_t k = 0; k < s->columns; k += BATCH)
        run_columns(s, k, s->columns - k < BATCH ? s->columns - k : BATCH);
}

static void run_walks(struct sheared *s, const uint32_t *pixels, uint32_t count, float *seen)
{
    float sums[2 * BATCH];
    for (uint32_t k = 0; k < s->rows; k += BATCH) {
        const uint32_t n = s->rows - k < BATCH ? s->rows - k : BATCH;
        s->kernels->walk_columns(&s->field, s->order + k, n, s->cells);
        s->kernels->project_rows(&s->field, s->order + k, n, s->cells);
    }
    for (uint32_t k = 0; k < count; k += BATCH) {
        const uint32_t n = count - k < BATCH ? count - k : BATCH;
        s->kernels->walk_rows(&s->field, pixels + k, n, sums);
        for (uint32_t i = 0; i < n; i++) {
            /* Weights of a walk may be negative. */
            const float whole = sums[2 * i + 1], share = sums[2 * i] / whole;
            const float within = share < 1.0f ? share > 0.0f ? share : 0.0f : 1.0f;
            seen[k + i] = whole > WHOLE_LEAST ? within : -1.0f;
        }
    }
}

static void describe(struct sheared *s, const struct coverage *coverage)
{
    const uint32_t l = s->light->strata;
    s->field = (struct shadow_field){
        .width = rect_width(s->receivers->rect),
        .height = rect_height(s->receivers->rect),
        .pixels = &s->receivers->pixels,
        .strata = l,
        .scale = coverage->scale,
        .window = coverage->window,
        .lanes = (l + 4) / 4 * 4, /* l + 1, rounded up */
        .phases = shadow_phases(l, coverage->scale),
        .weights = coverage->weights,
    };
    for (int i = 0; i < 2; i++) {
        const float half = s->light->rectangle.half[i];
        s->field.nodes_per_length[i] = 0.5f * (float)coverage->scale / half;
        s->field.refusal[i] = REFUSAL * s->light->sigma_y[i];
    }
}

int sheared_filter(const struct receiver_light *light, const struct patch *patch,
                   const struct coverage *coverage, const struct shadow_kernels *kernels,
                   struct receivers *receivers, const uint32_t *pixels, uint32_t count, float *seen)
{
    const size_t area = (size_t)rect_area(receivers->rect);
    struct sheared s = {.light = light, .patch = patch, .kernels = kernels, .receivers = receivers};
    int error = 0;
    describe(&s, coverage);
    uint8_t *needs = scratch_take(patch->scratch, 2 * area);
    s.order = scratch_take(patch->scratch, area * sizeof *s.order);
    if (!needs || !s.order) error = ERR_MEMORY;
    s.needs[0] = needs;
    s.needs[1] = error ? NULL : needs + area;
    if (!error) memset(needs, 0, 2 * area);
    if (!error) find_slots(&s, pixels, count);
    if (!error) error = create_sums(&s);
    if (!error) project_all(&s);
    if (!error) run_walks(&s, pixels, count, seen);
    free(s.cells);
    scratch_give(patch->scratch, s.field.rows);
    scratch_give(patch->scratch, s.field.columns);
    scratch_give(patch->scratch, s.order);
    scratch_give(patch->scratch, needs);
    return error;
}
