#include "worker/scene/sky_guide.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/pages.h"
#include "worker/scene/caustics.h"
#include "worker/shade/elementary.h"

/* The grid of a scene that is open everywhere. */
static const struct openness_grid everywhere = {
    {.size = {1, 1, 1}}, {.size = {1, 1, 1}}, .cells = 1};
static const uint16_t open_number = 0;
static const float not_glazed = 0.0f;

static void fill(const struct sky_tables *t, const struct openness *o, struct sky_table *tables)
{
    sky_tables_fill(t, NULL, tables);
    for (uint32_t k = 0; o && k < openness_cells(o); k++)
        sky_tables_fill(t, openness_of(o, k), tables + (size_t)(k + 1) * SKY_TABLE_NORMALS);
    tables += (size_t)(1 + (o ? openness_cells(o) : 0)) * SKY_TABLE_NORMALS;
    for (uint32_t k = 0; o && k < openness_panes(o); k++)
        sky_tables_fill(t, openness_through(o, k), tables + (size_t)k * SKY_TABLE_NORMALS);
}

struct sky_guide *sky_guide_create(const struct environment *map,
                                   const struct plan_environment *plan, const struct openness *o)
{
    const size_t learned = o ? (size_t)openness_cells(o) + openness_panes(o) : 0;
    const size_t count = SKY_TABLE_NORMALS * (1 + learned);
    struct sky_guide *g = calloc(1, sizeof *g);
    struct sky_tables *t = sky_tables_create(map, plan->rotation_rad);
    struct sky_table *tables = aligned_alloc(_Alignof(struct sky_table), count * sizeof *tables);
    if (g && t && tables) {
        pages_prefer_huge(tables, count * sizeof *tables);
        g->cosine = elementary_cos(plan->rotation_rad);
        g->sine = elementary_sin(plan->rotation_rad);
        g->grid = o ? openness_grid(o) : &everywhere;
        g->number = o ? openness_numbers(o) : &open_number;
        g->pane = o ? openness_pane_numbers(o) : &open_number;
        g->glazed = o ? openness_glazed(o) : &not_glazed;
        g->first_pane = o ? openness_cells(o) : 0;
        g->panes = o ? openness_panes(o) : 0;
        g->tables = tables;
        fill(t, o, tables);
    } else {
        free(tables);
        free(g);
        g = NULL;
    }
    sky_tables_destroy(&t);
    return g;
}

void sky_guide_destroy(struct sky_guide **guide)
{
    struct sky_guide *g = *guide;
    *guide = NULL;
    if (!g) return;
    photons_destroy(&g->caustics);
    free((void *)(uintptr_t)g->tables);
    free(g);
}

/* ---- what a scene keeps ---- */

/* The number of guides kept although no tile uses them. Pictures of a scene have few skies. */
#define KEPT 3

struct kept {
    struct plan_environment of;
    struct sky_guide *guide;
    uint32_t users;
    uint64_t last; /* when it was taken */
};

struct sky_guides {
    const struct render_scene *scene;
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
    g->scene = scene;
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

/* Returns the guide that was taken longest ago among those that no tile uses. */
static struct kept *oldest_idle(const struct sky_guides *g)
{
    struct kept *oldest = NULL;
    for (uint32_t i = 0; i < g->count; i++)
        if (g->kept[i].users == 0 && (!oldest || g->kept[i].last < oldest->last))
            oldest = &g->kept[i];
    return oldest;
}

/* Returns room for a new guide, after it has dropped old ones if need be. */
static struct kept *make_room(struct sky_guides *g)
{
    for (struct kept *k; g->count >= KEPT && (k = oldest_idle(g)) != NULL;) {
        sky_guide_destroy(&k->guide);
        *k = g->kept[--g->count];
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
    if (caustics_of_sky(g->scene, map, k->guide->cosine, k->guide->sine, &k->guide->caustics)) {
        sky_guide_destroy(&k->guide);
        return NULL;
    }
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

uint32_t sky_guides_count(struct sky_guides *guides)
{
    pthread_mutex_lock(&guides->lock);
    const uint32_t count = guides->count;
    pthread_mutex_unlock(&guides->lock);
    return count;
}
