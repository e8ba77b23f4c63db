#include "worker/scene/sky_guide.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "worker/shade/elementary.h"

/* What every bin keeps of its weight where the scene seems closed to it: windows are learned by few
 * rays. */
#define CLOSED_LEAST 0.05f

/* Of bins below the horizon, too: a table is for many normals. */
#define COSINE_LEAST 0.02f

/* ---- tables ---- */

/* A bin's mean cosines, and how open it is. */
struct maker {
    const struct environment *map;
    float turn; /* of the map, in turns of the world's azimuth */
    float cosines[SKY_GUIDE_NORMALS][ENVIRONMENT_BINS];
    uint16_t bin[ENVIRONMENT_BINS]; /* row by row */
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

/* Five normals that share a table: the middle one and those between it and its neighbours. */
static void normals_of(uint32_t facing, float out[5][3])
{
    const float middle[3] = {(float)(facing / 9) - 1.0f, (float)(facing / 3 % 3) - 1.0f,
                             (float)(facing % 3) - 1.0f};
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

static float mean_cosine(float normals[5][3], float directions[4][3])
{
    float sum = 0.0f;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 4; j++) {
            const float *n = normals[i], *d = directions[j];
            sum += fmaxf(n[0] * d[0] + n[1] * d[1] + n[2] * d[2], 0.0f);
        }
    return sum / 20.0f;
}

static void maker_init(struct maker *m, const struct environment *map,
                       const struct plan_environment *plan)
{
    m->map = map;
    m->turn = plan->rotation_rad * (0.5f * ELEMENTARY_INV_PI);
    for (uint32_t v = 0; v < ENVIRONMENT_BINS_V; v++)
        for (uint32_t u = 0; u < ENVIRONMENT_BINS_U; u++)
            m->bin[v * ENVIRONMENT_BINS_U + u] = (uint16_t)environment_bin_at(u, v);
    for (uint32_t facing = 0; facing < SKY_GUIDE_NORMALS; facing++) {
        float normals[5][3], directions[4][3];
        if (facing == 13) continue;
        normals_of(facing, normals);
        for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
            for (uint32_t k = 0; k < 4; k++)
                direction_of(((float)(i % ENVIRONMENT_BINS_U) + (k % 2 ? 0.75f : 0.25f)) /
                                 ENVIRONMENT_BINS_U,
                             ((float)(i / ENVIRONMENT_BINS_U) + (k / 2 ? 0.75f : 0.25f)) /
                                 ENVIRONMENT_BINS_V,
                             directions[k]);
            m->cosines[facing][i] = mean_cosine(normals, directions);
        }
    }
}

/* How open each of the map's bins is, row by row: it lies between two of the world's. */
static void turn_openness(const struct maker *m, const float *open, float *out)
{
    const float shift = m->turn - floorf(m->turn);
    const float columns = shift * (float)OPENNESS_U, whole = floorf(columns),
                part = columns - whole;
    for (uint32_t v = 0; v < OPENNESS_V; v++)
        for (uint32_t u = 0; u < OPENNESS_U; u++) {
            const uint32_t at = u + (uint32_t)whole;
            const float *row = open + (size_t)v * OPENNESS_U;
            const float a = row[at % OPENNESS_U], b = row[(at + 1) % OPENNESS_U];
            out[v * OPENNESS_U + u] = a + part * (b - a);
        }
}

/* Units that are nearest to the weights, at least one where there is any. What they lack or are too
 * many the largest take. */
static void share_units(const double *weights, uint16_t *table)
{
    uint32_t units[ENVIRONMENT_BINS], most = 0;
    double total = 0.0;
    int32_t left = (int32_t)SKY_GUIDE_UNITS;
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) total += weights[i];
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const double exact = total > 0.0 ? weights[i] / total * (double)SKY_GUIDE_UNITS : 0.0;
        units[i] = weights[i] > 0.0 ? (exact < 1.0 ? 1 : (uint32_t)(exact + 0.5)) : 0;
        left -= (int32_t)units[i];
    }
    while (left != 0) {
        for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) most = units[i] > units[most] ? i : most;
        const int32_t half = (int32_t)(units[most] / 2);
        const int32_t change = left < -half ? -half : left;
        units[most] = (uint32_t)((int32_t)units[most] + change);
        left -= change;
    }
    uint32_t before = 0;
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        table[i] = (uint16_t)before;
        before += units[i];
    }
}

static void fill_tables(const struct maker *m, const float *open, uint16_t *tables)
{
    double weights[ENVIRONMENT_BINS];
    for (uint32_t facing = 0; facing < SKY_GUIDE_NORMALS; facing++) {
        for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
            const float seen = open ? CLOSED_LEAST + (1.0f - CLOSED_LEAST) * open[i] : 1.0f;
            weights[m->bin[i]] = environment_bin_share(m->map, m->bin[i]) *
                                 (double)(seen * (COSINE_LEAST + m->cosines[facing][i]));
        }
        share_units(weights, tables + (size_t)facing * ENVIRONMENT_BINS);
    }
}

/* Of a place that is open whatever lies around it. */
static const struct openness_grid everywhere = {
    {.size = {1, 1, 1}}, {.size = {1, 1, 1}}, .cells = 1};
static const uint16_t open_number = 0;

struct sky_guide *sky_guide_create(const struct environment *map,
                                   const struct plan_environment *plan, const struct openness *o)
{
    const uint32_t cells = 1 + (o ? openness_cells(o) : 0);
    const size_t each = (size_t)SKY_GUIDE_NORMALS * ENVIRONMENT_BINS;
    struct sky_guide *g = calloc(1, sizeof *g);
    struct maker *m = calloc(1, sizeof *m);
    uint16_t *tables = malloc(cells * each * sizeof *tables);
    if (g) g->tables = tables;
    if (!g || !m || !tables) {
        free(m);
        sky_guide_destroy(&g);
        return NULL;
    }
    g->cosine = elementary_cos(plan->rotation_rad);
    g->sine = elementary_sin(plan->rotation_rad);
    g->grid = o ? openness_grid(o) : &everywhere;
    g->number = o ? openness_numbers(o) : &open_number;
    maker_init(m, map, plan);
    fill_tables(m, NULL, tables);
    for (uint32_t k = 1; k < cells; k++) {
        float open[OPENNESS_BINS];
        turn_openness(m, openness_of(o, k - 1), open);
        fill_tables(m, open, tables + k * each);
    }
    free(m);
    return g;
}

void sky_guide_destroy(struct sky_guide **guide)
{
    struct sky_guide *g = *guide;
    *guide = NULL;
    if (!g) return;
    free((void *)(uintptr_t)g->tables);
    free(g);
}

/* ---- what a scene keeps ---- */

/* Guides that no tile uses are kept up to so many: pictures of a scene come with few skies. */
#define KEPT 3

struct kept {
    struct plan_environment of;
    struct sky_guide *guide;
    uint32_t users;
    uint64_t last; /* when it was taken */
};

struct sky_guides {
    struct openness *openness;
    pthread_mutex_t lock;
    struct kept *kept;
    uint32_t count;
    uint64_t taken;
};

struct sky_guides *sky_guides_create(const struct render_scene *scene)
{
    struct sky_guides *g = calloc(1, sizeof *g);
    if (!g) return NULL;
    pthread_mutex_init(&g->lock, NULL);
    g->openness = openness_create(scene);
    if (!g->openness) sky_guides_destroy(&g);
    return g;
}

void sky_guides_destroy(struct sky_guides **guides)
{
    struct sky_guides *g = *guides;
    *guides = NULL;
    if (!g) return;
    for (uint32_t i = 0; i < g->count; i++) sky_guide_destroy(&g->kept[i].guide);
    pthread_mutex_destroy(&g->lock);
    openness_destroy(&g->openness);
    free(g->kept);
    free(g);
}

static bool is_of(const struct kept *k, const struct plan_environment *plan)
{
    return memcmp(&k->of.map, &plan->map, sizeof plan->map) == 0 &&
           k->of.rotation_rad == plan->rotation_rad;
}

static struct kept *find(const struct sky_guides *g, const struct plan_environment *plan)
{
    for (uint32_t i = 0; i < g->count; i++)
        if (is_of(&g->kept[i], plan)) return &g->kept[i];
    return NULL;
}

/* The place of the one that was last used longest ago, if there are many; else a new place. */
static struct kept *make_room(struct sky_guides *g)
{
    struct kept *oldest = NULL;
    for (uint32_t i = 0; g->count >= KEPT && i < g->count; i++)
        if (g->kept[i].users == 0 && (!oldest || g->kept[i].last < oldest->last))
            oldest = &g->kept[i];
    if (oldest) {
        sky_guide_destroy(&oldest->guide);
        *oldest = g->kept[--g->count];
    }
    struct kept *more = realloc(g->kept, (g->count + 1) * sizeof *more);
    if (!more) return NULL;
    g->kept = more;
    return &more[g->count];
}

static struct kept *make(struct sky_guides *g, const struct environment *map,
                         const struct plan_environment *plan)
{
    struct kept *k = make_room(g);
    if (!k) return NULL;
    *k = (struct kept){.of = *plan, .guide = sky_guide_create(map, plan, g->openness)};
    if (!k->guide) return NULL;
    g->count++;
    return k;
}

const struct sky_guide *sky_guides_take(struct sky_guides *guides, const struct environment *map,
                                        const struct plan_environment *plan)
{
    const struct sky_guide *taken = NULL;
    openness_learn(guides->openness);
    pthread_mutex_lock(&guides->lock);
    struct kept *k = find(guides, plan);
    if (!k) k = make(guides, map, plan);
    if (k) {
        k->users++;
        k->last = ++guides->taken;
        taken = k->guide;
    }
    pthread_mutex_unlock(&guides->lock);
    return taken;
}

void sky_guides_give(struct sky_guides *guides, const struct sky_guide *guide)
{
    if (!guide) return;
    pthread_mutex_lock(&guides->lock);
    for (uint32_t i = 0; i < guides->count; i++)
        if (guides->kept[i].guide == guide) guides->kept[i].users--;
    pthread_mutex_unlock(&guides->lock);
}
