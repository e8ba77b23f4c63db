#include "server/reconstruct/shadow/sheared.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "server/reconstruct/shadow/strata.h"

#define REFUSAL    1.5f  /* sigma_y that a neighbour's own wedge may be mis-sheared by */
#define WHOLE_MIN  1e-9f /* of denominators; below, nothing was seen */
#define BATCH      64u
#define SUMS_BYTES 64

/* Rows of pixels by which each pass advances before the next pass does. Results of a pass are read
 * from SHADOW_REACH_PX rows above to as many below, and kept for KEPT_PX rows: those of a whole
 * block would fit into no cache and take several times the memory. */
#define STRIPE_PX 8
#define KEPT_PX   (2 * SHADOW_REACH_PX + STRIPE_PX)
_Static_assert(SHADOW_REACH_PX % STRIPE_PX == 0, "stripes of all passes end together");

/* Pixels row by row, and how many of them a pass has processed. */
struct sheared_list {
    const uint32_t *pixels;
    uint32_t count, done;
};

struct sheared {
    const struct receiver_light *light;
    const struct patch *patch;
    const struct shadow_kernels *kernels;
    struct receivers *receivers;
    struct shadow_field field;
    uint8_t *needs[2]; /* of each pixel: whether a walk along axis 0, 1 reaches it */
    uint32_t *order;   /* pixels of both lists */
    struct sheared_list columns, rows, asked;
    uint32_t slots; /* room in slots, which pixels take in turn */
    float *cells;   /* 4 r a pixel of a batch */
};

/* Lists the lit pixels that walks along axis 1 reach, and with `both` those along axis 0, too. */
static uint32_t collect(const struct sheared *s, bool both, uint32_t *out)
{
    const size_t area = (size_t)s->field.width * (size_t)s->field.height;
    uint32_t count = 0;
    for (size_t i = 0; i < area; i++) {
        if (!s->needs[1][i] && !(both && s->needs[0][i])) continue;
        if (receiver_is_lit(s->field.pixels, i)) out[count++] = (uint32_t)i;
    }
    return count;
}

/* Returns the first pixel of row y, where there are rows above. */
static uint32_t row_start(const struct sheared *s, int32_t y)
{
    return y > 0 ? (uint32_t)y * (uint32_t)s->field.width : 0;
}

/* Returns the most pixels of the list in KEPT_PX rows that end with a stripe. */
static uint32_t most_kept(const struct sheared *s, const struct sheared_list *list)
{
    uint32_t first = 0, end = 0, most = 0;
    for (int32_t y = STRIPE_PX; end < list->count; y += STRIPE_PX) {
        while (end < list->count && list->pixels[end] < row_start(s, y)) end++;
        while (first < end && list->pixels[first] < row_start(s, y - KEPT_PX)) first++;
        most = end - first > most ? end - first : most;
    }
    return most;
}

/* Finds the pixels of each pass. */
static void find_slots(struct sheared *s)
{
    const size_t area = (size_t)s->field.width * (size_t)s->field.height;
    uint32_t *const rows = s->order, *const columns = s->order + area;
    s->kernels->mark_walks(&s->field, 1, s->asked.pixels, s->asked.count, s->needs[1]);
    s->rows = (struct sheared_list){rows, collect(s, false, rows), 0};
    s->kernels->mark_walks(&s->field, 0, rows, s->rows.count, s->needs[0]);
    s->columns = (struct sheared_list){columns, collect(s, true, columns), 0};
    s->slots = most_kept(s, &s->columns);
    for (uint32_t k = 0; k < s->columns.count; k++) {
        assert(s->slots > 0); /* listed pixels are kept */
        s->receivers->pixels.slot[columns[k]] = (int32_t)(k % s->slots);
    }
}

static size_t align_up(size_t bytes)
{
    return (bytes + SUMS_BYTES - 1) / SUMS_BYTES * SUMS_BYTES;
}

/* Creates the sums. Taps of weight 0 read the first slot, before it is in use. */
static int create_sums(struct sheared *s)
{
    const size_t nodes = shadow_nodes(&s->field);
    const size_t column = nodes * s->field.lanes * sizeof(float), row = nodes * 2 * sizeof(float);
    s->field.columns =
        scratch_take(s->patch->scratch, align_up(s->slots * column) + SUMS_BYTES + column);
    s->field.rows = scratch_take(s->patch->scratch, align_up(s->slots * row) + SUMS_BYTES + row);
    s->cells = aligned_alloc(SUMS_BYTES, sizeof(float) * BATCH * 4 * s->field.scale);
    if (!s->field.columns || !s->field.rows || !s->cells) return ERR_MEMORY;
    memset(s->field.columns, 0, column);
    memset(s->field.rows, 0, row);
    return 0;
}

static void place_pixels(const struct sheared *s, const uint32_t *pixels, uint32_t count,
                         int32_t *x, int32_t *y)
{
    for (uint32_t k = 0; k < count; k++) {
        x[k] = s->receivers->rect.x0 + (int32_t)(pixels[k] % (uint32_t)s->field.width);
        y[k] = s->receivers->rect.y0 + (int32_t)(pixels[k] / (uint32_t)s->field.width);
    }
}

/* Returns the number of the next pixels of the list above row `end`, at most BATCH. */
static uint32_t next_batch(const struct sheared *s, struct sheared_list *list, int32_t end,
                           const uint32_t **pixels)
{
    const uint32_t limit = row_start(s, end), left = list->count - list->done;
    uint32_t count = 0;
    *pixels = list->pixels + list->done;
    while (count < BATCH && count < left && (*pixels)[count] < limit) {
        assert(count == 0 || (*pixels)[count] > (*pixels)[count - 1]);
        count++;
    }
    list->done += count;
    return count;
}

/* Runs pass 1a. */
static void project_columns(struct sheared *s, const uint32_t *pixels, uint32_t count)
{
    const uint32_t l = s->light->strata;
    const float phases = (float)s->field.phases;
    int32_t x[BATCH], y[BATCH];
    assert(count > 0 && count <= BATCH);
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

/* Runs passes 1b and 2a. */
static void project_rows(struct sheared *s, const uint32_t *pixels, uint32_t count)
{
    s->kernels->walk_columns(&s->field, pixels, count, s->cells);
    s->kernels->project_rows(&s->field, pixels, count, s->cells);
}

/* Runs pass 2b. */
static void walk_rows(struct sheared *s, const uint32_t *pixels, uint32_t count, float *seen)
{
    float sums[2 * BATCH];
    s->kernels->walk_rows(&s->field, pixels, count, sums);
    for (uint32_t i = 0; i < count; i++) {
        /* Weights of a walk may be negative. */
        const float whole = sums[2 * i + 1], share = sums[2 * i] / whole;
        const float within = share < 1.0f ? share > 0.0f ? share : 0.0f : 1.0f;
        seen[i] = whole > WHOLE_MIN ? within : -1.0f;
    }
}

/* Runs all passes, stripe by stripe, each as far behind the one before as it reads ahead. */
static void run_passes(struct sheared *s, float *seen)
{
    const uint32_t *pixels;
    uint32_t count;
    for (int32_t end = STRIPE_PX; s->asked.done < s->asked.count; end += STRIPE_PX) {
        while ((count = next_batch(s, &s->columns, end, &pixels)) > 0)
            project_columns(s, pixels, count);
        while ((count = next_batch(s, &s->rows, end - SHADOW_REACH_PX, &pixels)) > 0)
            project_rows(s, pixels, count);
        while ((count = next_batch(s, &s->asked, end - 2 * SHADOW_REACH_PX, &pixels)) > 0)
            walk_rows(s, pixels, count, seen + (pixels - s->asked.pixels));
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
    struct sheared s = {.light = light,
                        .patch = patch,
                        .kernels = kernels,
                        .receivers = receivers,
                        .asked = {pixels, count, 0}};
    int error = 0;
    describe(&s, coverage);
    uint8_t *needs = scratch_take(patch->scratch, 2 * area);
    s.order = scratch_take(patch->scratch, 2 * area * sizeof *s.order);
    if (!needs || !s.order) error = ERR_MEMORY;
    s.needs[0] = needs;
    s.needs[1] = error ? NULL : needs + area;
    if (!error) memset(needs, 0, 2 * area);
    if (!error) find_slots(&s);
    if (!error) error = create_sums(&s);
    if (!error) run_passes(&s, seen);
    free(s.cells);
    scratch_give(patch->scratch, s.field.rows);
    scratch_give(patch->scratch, s.field.columns);
    scratch_give(patch->scratch, s.order);
    scratch_give(patch->scratch, needs);
    return error;
}
