#include "worker/scene/sky_tables.h"

#include <math.h>
#include <stdlib.h>

#include "worker/shade/elementary.h"

/* The part of its weight that a bin keeps where the scene seems closed to it, since few rays learn
 * the windows. */
#define CLOSED_MIN 0.02f

/* The least cosine of a bin, even below the horizon, since a table serves many normals. */
#define COSINE_MIN 0.02f

/* The least weight of a bin that sends light, so that rounding loses none. */
#define WEIGHT_MIN 1e-30f

/* The number of directions in a cell of openness, which has the angles of the map's own bins. */
#define WAYS 4u

struct sky_tables {
    float shift; /* of the map's columns against the world's, in those of openness */
    float open[SKY_TABLE_NORMALS][ENVIRONMENT_BINS]; /* weights where the scene is open */
    struct span {                                    /* cells of openness that a bin covers */
        uint8_t u, v, width, height;
    } span[ENVIRONMENT_BINS];
};

static void direction_of(float u, float v, float out[3])
{
    float around_sine, around_cosine, down_sine, down_cosine;
    elementary_sincos_turn(u, &around_sine, &around_cosine);
    elementary_sincos_turn(0.5f * v, &down_sine, &down_cosine);
    out[0] = -down_sine * around_cosine;
    out[1] = down_cosine;
    out[2] = -down_sine * around_sine;
}

/* Lists five normals that share a table: the middle one and those between it and its neighbours. */
static void normals_of(uint32_t facing, float out[5][3])
{
    const uint32_t sign[3] = {facing / 9, facing / 3 % 3, facing % 3};
    float middle[3];
    for (int k = 0; k < 3; k++) middle[k] = (float)sign[k] - 1.0f;
    const float length =
        sqrtf(middle[0] * middle[0] + middle[1] * middle[1] + middle[2] * middle[2]);
    float side[3], up[3];
    for (int k = 0; k < 3; k++) out[0][k] = middle[k] / length;
    const float *n = out[0];
    const int least = fabsf(n[0]) < 0.5f ? 0 : fabsf(n[1]) < 0.6f ? 1 : 2;
    float axis[3] = {0};
    axis[least] = 1.0f;
    for (int k = 0; k < 3; k++) side[k] = axis[k] - n[least] * n[k];
    const float scale = 1.0f / sqrtf(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
    for (int k = 0; k < 3; k++) side[k] *= scale;
    for (int k = 0; k < 3; k++)
        up[k] = n[(k + 1) % 3] * side[(k + 2) % 3] - n[(k + 2) % 3] * side[(k + 1) % 3];
    for (int i = 0; i < 4; i++) {
        const float *across = i < 2 ? side : up;
        const float tilt = i % 2 ? -0.3f : 0.3f, whole = 1.0f / sqrtf(1.0f + tilt * tilt);
        for (int k = 0; k < 3; k++) out[i + 1][k] = (n[k] + tilt * across[k]) * whole;
    }
}

static float mean_cosine(float normals[5][3], float directions[WAYS][3])
{
    float sum = 0.0f;
    for (int i = 0; i < 5; i++)
        for (uint32_t j = 0; j < WAYS; j++) {
            const float *n = normals[i], *d = directions[j];
            const float cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
            sum += cosine > 0.0f ? cosine : 0.0f;
        }
    return sum / (5.0f * (float)WAYS);
}

/* ---- bins ---- */

/* Finds the cells of openness that texels from `first` on are nearest to, of `texels` along an
 * axis. It is one cell where a map has many texels and more where it has few. */
static void find_span(uint32_t first, uint32_t count, uint32_t texels, uint32_t cells, uint8_t *at,
                      uint8_t *length)
{
    uint32_t begin = (2 * cells * first + texels - 1) / (2 * texels);
    uint32_t end = (2 * cells * (first + count) + texels) / (2 * texels);
    begin = begin < cells ? begin : cells - 1;
    end = end > begin ? (end < cells ? end : cells) : begin + 1;
    *at = (uint8_t)begin;
    *length = (uint8_t)(end - begin);
}

static void find_spans(struct sky_tables *t, const struct environment *map)
{
    float width, height;
    environment_size(map, &width, &height);
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const struct environment_rect r = environment_bin_texels(map, i);
        struct span *s = &t->span[i];
        find_span(r.x, r.width, (uint32_t)width, OPENNESS_U, &s->u, &s->width);
        find_span(r.y, r.height, (uint32_t)height, OPENNESS_V, &s->v, &s->height);
    }
}

/* Returns the mean of the cells' values over a bin. They lie row by row. */
static float mean_over(const struct span *s, const float *of)
{
    float sum = 0.0f;
    for (uint32_t v = s->v; v < (uint32_t)s->v + s->height; v++)
        for (uint32_t u = s->u; u < (uint32_t)s->u + s->width; u++) sum += of[v * OPENNESS_U + u];
    return sum / (float)(s->width * s->height);
}

static void find_weights(struct sky_tables *t, const struct environment *map, uint32_t facing,
                         float directions[OPENNESS_BINS][WAYS][3])
{
    float normals[5][3], cosines[OPENNESS_BINS];
    normals_of(facing, normals);
    for (uint32_t i = 0; i < OPENNESS_BINS; i++) cosines[i] = mean_cosine(normals, directions[i]);
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const float share = (float)environment_bin_share(map, i);
        const float weight = share * (COSINE_MIN + mean_over(&t->span[i], cosines));
        t->open[facing][i] = environment_bin_share(map, i) > 0.0 ? fmaxf(weight, WEIGHT_MIN) : 0;
    }
}

/* Computes WAYS directions of each cell of openness. */
static void find_directions(float directions[OPENNESS_BINS][WAYS][3])
{
    for (uint32_t i = 0; i < OPENNESS_BINS * WAYS; i++) {
        const uint32_t cell = i / WAYS, row = cell / OPENNESS_U, k = i % WAYS;
        const float u = (float)(cell % OPENNESS_U) + (k % 2 ? 0.75f : 0.25f);
        const float v = (float)row + (k / 2 ? 0.75f : 0.25f);
        direction_of(u / (float)OPENNESS_U, v / (float)OPENNESS_V, directions[cell][k]);
    }
}

struct sky_tables *sky_tables_create(const struct environment *map, float rotation_rad)
{
    struct sky_tables *t = calloc(1, sizeof *t);
    float(*directions)[WAYS][3] = malloc(OPENNESS_BINS * sizeof *directions);
    if (t && directions) {
        const float turns = rotation_rad * (0.5f * ELEMENTARY_INV_PI);
        t->shift = (turns - floorf(turns)) * (float)OPENNESS_U;
        find_spans(t, map);
        find_directions(directions);
        for (uint32_t facing = 0; facing < SKY_TABLE_NORMALS; facing++)
            if (facing != SKY_TABLE_NORMALS / 2) find_weights(t, map, facing, directions);
    } else {
        sky_tables_destroy(&t);
    }
    free(directions);
    return t;
}

void sky_tables_destroy(struct sky_tables **tables)
{
    free(*tables);
    *tables = NULL;
}

/* ---- tables ---- */

/* Turns openness into the map's frame, where a column lies between two of the world's. */
static void turn(const struct sky_tables *t, const float *open, float *out)
{
    const float whole = floorf(t->shift), part = t->shift - whole;
    for (uint32_t v = 0; v < OPENNESS_V; v++)
        for (uint32_t u = 0; u < OPENNESS_U; u++) {
            const uint32_t at = u + (uint32_t)whole;
            const float *row = open + (size_t)v * OPENNESS_U;
            const float a = row[at % OPENNESS_U], b = row[(at + 1) % OPENNESS_U];
            out[v * OPENNESS_U + u] = a + part * (b - a);
        }
}

/* Returns the sum of the weights. It adds up eight sums, which need not wait for each other. */
static float sum_of(const float *weights)
{
    float sums[8] = {0};
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i += 8)
        for (uint32_t k = 0; k < 8; k++) sums[k] += weights[i + k];
    return ((sums[0] + sums[4]) + (sums[1] + sums[5])) +
           ((sums[2] + sums[6]) + (sums[3] + sums[7]));
}

/* Adds units that are left over to the largest shares, or takes what is too much from them. */
static void settle(int32_t *units, int32_t left)
{
    while (left != 0) {
        int32_t largest = 0;
        uint32_t at = 0;
        for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++)
            largest = units[i] > largest ? units[i] : largest;
        while (units[at] != largest) at++;
        const int32_t change = left < -(largest / 2) ? -(largest / 2) : left;
        units[at] += change;
        left -= change;
    }
}

/* Rounds the weights to units, at least one where there is any weight. */
static void share_units(const float *weights, struct sky_table *table)
{
    int32_t units[ENVIRONMENT_BINS], sum = 0, before = 0;
    const float total = sum_of(weights);
    const float scale = total > 0.0f ? (float)SKY_TABLE_UNITS / total : 0.0f;
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const int32_t nearest = (int32_t)(weights[i] * scale + 0.5f);
        const int32_t least = weights[i] > 0.0f ? 1 : 0;
        units[i] = nearest > least ? nearest : least;
        sum += units[i];
    }
    settle(units, (int32_t)SKY_TABLE_UNITS - sum);
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        table->before[i] = (uint16_t)before;
        before += units[i];
    }
    for (uint32_t i = 0; i < SKY_TABLE_HEADS; i++)
        table->heads[i] = table->before[(size_t)i * SKY_TABLE_STRIDE];
}

void sky_tables_fill(const struct sky_tables *t, const float *open, struct sky_table *out)
{
    float turned[OPENNESS_BINS], seen[ENVIRONMENT_BINS], weights[ENVIRONMENT_BINS];
    if (open) turn(t, open, turned);
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++)
        seen[i] = open ? CLOSED_MIN + (1.0f - CLOSED_MIN) * mean_over(&t->span[i], turned) : 1;
    for (uint32_t facing = 0; facing < SKY_TABLE_NORMALS; facing++) {
        for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) weights[i] = t->open[facing][i] * seen[i];
        share_units(weights, &out[facing]);
    }
}
