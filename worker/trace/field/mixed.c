#include "worker/trace/field/mixed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/half.h"
#include "worker/trace/field/field_kernels.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/path/path_leave.h"

struct mixing {
    struct path_context context; /* with counters of its own */
    struct mixed_scratch *scratch;
    struct samples *samples;
    uint32_t values, count, glow_count;
};

void mixed_scratch_init(struct mixed_scratch *s)
{
    memset(s, 0, sizeof *s);
    queries_init_rays(&s->camera);
}

void mixed_scratch_fini(struct mixed_scratch *s)
{
    mixed_finder_fini(&s->finder);
    free(s->entries);
    s->entries = NULL;
    s->capacity = 0;
}

/* -- a pixel's samples -- */

static void trace_subs(const struct mixing *m, int32_t x, int32_t y, uint32_t first, uint32_t count)
{
    struct mixed_scratch *s = m->scratch;
    const struct path_context *c = &m->context;
    primary_trace_pixel(c->queries, c->plan, x, y, first, count, &s->camera, s->subs.px, s->subs.py,
                        &s->vertex.surface);
    c->counters->value[COUNTER_RAYS_ANTIALIAS] += LANES;
}

static void resolve_subs(const struct mixing *m, int32_t x, int32_t y)
{
    struct mixed_scratch *s = m->scratch;
    struct mixed_subs *subs = &s->subs;
    struct surface *surface = &s->vertex.surface;
    if (m->values > MIXED_REFLECTANCE) {
        s->vertex.active = surface->hit;
        path_resolve(&m->context, &s->camera, &s->vertex);
        glossy_lobes_find(&s->vertex, &s->lobes);
    } else {
        hit_diffuse_albedo(m->context.queries, &s->camera, surface);
    }
    if (m->context.plan->paths.without_diffuse_direct) path_hide_from_fields(surface);
    subs->x_px = x;
    subs->y_px = y;
    subs->facing = surface->normal;
    for (int i = 0; i < LANES; i++) {
        subs->on.on[i] = surface->hit.on[i] & -(surface->distance[i] > 0.0f);
        subs->distance[i] = subs->on.on[i] ? surface_distance(surface->distance[i]) : 1.0f;
        subs->id[i] = surface_sub_id(surface->id[i]);
    }
}

static float unit(float v)
{
    return v < 1.0f ? v : 1.0f;
}

static void add_times(const float *restrict share, const float *restrict colour,
                      float *restrict sum)
{
    for (int i = 0; i < LANES; i++) sum[i] += share[i] > 0.0f ? share[i] * unit(colour[i]) : 0.0f;
}

static void add_lender(const struct mixing *m, uint32_t slot)
{
    struct mixed_scratch *s = m->scratch;
    const float *share = s->shares.share[slot];
    float(*sum)[LANES] = s->sums.value[slot];
    const struct lanes3 *albedo = &s->vertex.surface.albedo, *lobe = &s->lobes.reflectance;
    const float *colours[] = {albedo->x, albedo->y, albedo->z, lobe->x, lobe->y, lobe->z};
    for (int i = 0; i < LANES; i++) sum[MIXED_SHARE][i] += share[i];
    for (uint32_t v = MIXED_ALBEDO; v < m->values; v++) add_times(share, colours[v - 1], sum[v]);
}

/* Returns whether lane i reflects anything. Of paths only diffuse albedo is known. */
static bool reflects(const struct mixing *m, int i)
{
    if (m->context.plan->paths.spp > 0) return true;
    const struct lanes3 *a = &m->scratch->vertex.surface.albedo;
    const struct lanes3 *r = &m->scratch->lobes.reflectance;
    if (a->x[i] >= ALBEDO_BLACK || a->y[i] >= ALBEDO_BLACK || a->z[i] >= ALBEDO_BLACK) return true;
    if (m->values <= MIXED_REFLECTANCE) return false;
    return r->x[i] >= ALBEDO_BLACK || r->y[i] >= ALBEDO_BLACK || r->z[i] >= ALBEDO_BLACK;
}

/* Samples without a lender: black ones cover the pixel all the same. */
static void add_unlent(const struct mixing *m)
{
    struct mixed_scratch *s = m->scratch;
    for (int i = 0; i < LANES; i++) {
        if (!s->subs.on.on[i] || s->shares.lent.on[i]) continue;
        if (reflects(m, i))
            s->sums.lone = true;
        else
            s->sums.value[MIXED_SLOT_OWN][MIXED_SHARE][i] += 1.0f;
    }
}

static float sum_of(const float v[LANES])
{
    float sum = 0.0f;
    for (int i = 0; i < LANES; i++) sum += v[i];
    return sum;
}

static int reserve(struct mixed_scratch *s, uint32_t more)
{
    if (s->capacity - s->count >= more) return 0;
    const uint32_t capacity = 2 * s->capacity + more;
    struct mixed_found *entries = realloc(s->entries, capacity * sizeof *entries);
    if (!entries) return ERR_MEMORY;
    s->entries = entries;
    s->capacity = capacity;
    return 0;
}

/* Adds the pixel's entries. Its own is always there, and says that the pixel is mixed. */
static int put_entries(const struct mixing *m, size_t e)
{
    struct mixed_scratch *s = m->scratch;
    const int error = reserve(s, MIXED_SLOTS);
    if (error) return error;
    for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++) {
        struct mixed_found *out = &s->entries[s->count];
        *out = (struct mixed_found){.place = (uint32_t)e * MIXED_SLOTS + slot};
        for (uint32_t v = 0; v < m->values && s->sums.lenders >> slot & 1u; v++)
            out->value[v] = unit(sum_of(s->sums.value[slot][v]) / (float)m->count);
        s->count += out->value[MIXED_SHARE] > 0.0f || slot == MIXED_SLOT_OWN;
    }
    return 0;
}

/* Returns which of the 3 x 3 around show a surface. */
static uint32_t find_lenders(const struct mixing *m, int32_t x, int32_t y,
                             struct shown_surface pixels[MIXED_SLOTS])
{
    const struct mixed_finder *f = &m->scratch->finder;
    uint32_t lenders = 0;
    for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++) {
        const int32_t dx = (int32_t)(slot % 3) - 1, dy = (int32_t)(slot / 3) - 1;
        pixels[slot] = mixed_surface(&f->cells, mixed_cell(f, x + dx, y + dy));
        lenders |= (uint32_t)(pixels[slot].distance > 0.0f) << slot;
    }
    return lenders;
}

/* Whole paths know by themselves what covers a pixel: their list tells where they are more. */
static bool is_of_whole_paths(const struct plan *plan)
{
    return plan->paths.spp > 0 && !plan->paths.without_diffuse_direct;
}

static int trace_pixel(const struct mixing *m, int32_t x, int32_t y, size_t e)
{
    struct mixed_scratch *s = m->scratch;
    struct shown_surface pixels[MIXED_SLOTS];
    const struct lone_finder *lone = s->finder.lone;
    const uint32_t lenders = find_lenders(m, x, y, pixels);
    memset(&s->sums, 0, sizeof s->sums);
    s->sums.lenders = 1u << MIXED_SLOT_OWN;
    if (is_of_whole_paths(m->context.plan)) return put_entries(m, e);
    for (uint32_t first = 0; first < m->count && !s->sums.lone; first += LANES) {
        trace_subs(m, x, y, first, m->count);
        resolve_subs(m, x, y);
        lone->kernels->split_subs(&lone->view, pixels, lenders, &s->subs, &s->shares);
        for (uint32_t slot = 0; slot < MIXED_SLOTS; slot++)
            if (s->shares.lenders >> slot & 1u) add_lender(m, slot);
        s->sums.lenders |= s->shares.lenders;
        add_unlent(m);
    }
    return s->sums.lone ? 0 : put_entries(m, e);
}

/* -- lamps -- */

static void add_emission(struct mixed_scratch *s)
{
    const struct lanes3 *e = &s->vertex.surface.emission;
    for (int i = 0; i < LANES; i++) {
        const bool shines = e->x[i] + e->y[i] + e->z[i] > 0.0f;
        s->glow.bright |= shines;
        s->glow.dark |= !shines;
        s->glow.sum.x[i] += e->x[i];
        s->glow.sum.y[i] += e->y[i];
        s->glow.sum.z[i] += e->z[i];
    }
}

/* Samples the pixel's emission; `out` is the mean over so many. */
static void sample_glow(const struct mixing *m, int32_t x, int32_t y, uint32_t count, float out[3])
{
    struct mixed_scratch *s = m->scratch;
    memset(&s->glow, 0, sizeof s->glow);
    for (uint32_t first = 0; first < count; first += LANES) {
        trace_subs(m, x, y, first, count);
        add_emission(s);
    }
    const float share = 1.0f / (float)count;
    out[0] = sum_of(s->glow.sum.x) * share;
    out[1] = sum_of(s->glow.sum.y) * share;
    out[2] = sum_of(s->glow.sum.z) * share;
}

/* Returns how many samples more than `count` would show: none where the pixel is white in any
 * case. */
static uint32_t glow_wanted(const struct mixed_glow *glow, const float mean[3])
{
    if (!glow->dark) return 0;
    if (!glow->bright) return GLOW_SAMPLES_DIM;
    const float least = fminf(mean[0], fminf(mean[1], mean[2]));
    return least < 1.0f ? GLOW_SAMPLES_SLIVER : 0;
}

/* Finds the emission of a mixed pixel beside a lamp from many samples. */
static void trace_glow(const struct mixing *m, int32_t x, int32_t y, size_t e)
{
    struct mixed_scratch *s = m->scratch;
    float mean[3];
    uint32_t count = m->glow_count;
    do sample_glow(m, x, y, count, mean);
    while (glow_wanted(&s->glow, mean) > count && (count = glow_wanted(&s->glow, mean)));
    for (uint32_t c = 0; c < 3; c++) {
        const float scaled = mean[c] * m->context.plan->radiance_scale;
        half_from_floats(&scaled, &samples_u16(m->samples, PLANE_EMISSION, c)[e], 1);
    }
}

/* -- a tile's -- */

static bool is_stopped(const struct path_context *c)
{
    return c->stop && atomic_load_explicit(c->stop, memory_order_relaxed);
}

static int trace_pixels(const struct mixing *m)
{
    const struct mixed_finder *f = &m->scratch->finder;
    const struct rect t = f->tile;
    const bool shines = samples_u16(m->samples, PLANE_EMISSION, 0) != NULL;
    size_t e = 0;
    for (int32_t y = t.y0; y < t.y1; y++) {
        for (int32_t x = t.x0; x < t.x1; x++, e++) {
            if (!f->mixed[e]) continue;
            if (shines && mixed_is_beside_lamp(f, x, y)) trace_glow(m, x, y, e);
            const int error = trace_pixel(m, x, y, e);
            if (error) return error;
        }
        if (is_stopped(&m->context)) return ERR_STATE;
    }
    return 0;
}

static int make_list(const struct mixing *m)
{
    const struct mixed_scratch *s = m->scratch;
    struct sparse_list *list;
    if (s->count == 0) return 0;
    if (sparse_list_create(m->values, s->count, &list) != 0) return ERR_MEMORY;
    for (uint32_t n = 0; n < s->count; n++) list->words[n] = s->entries[n].place;
    for (uint32_t v = 0; v < m->values; v++) {
        float *out = sparse_list_numbers(list, v);
        for (uint32_t n = 0; n < s->count; n++) out[n] = s->entries[n].value[v];
    }
    m->samples->mixed = list;
    return 0;
}

int mixed_trace(const struct path_context *c, struct lone_finder *lone,
                struct mixed_scratch *scratch, struct samples *samples)
{
    struct mixing m = {.context = *c,
                       .scratch = scratch,
                       .samples = samples,
                       .values = samples->layout.mixed_values,
                       .count = mixed_samples(c->plan),
                       .glow_count = mixed_glow_samples(c->plan)};
    memset(&scratch->counters, 0, sizeof scratch->counters);
    m.context.counters = &scratch->counters;
    scratch->count = 0;
    int error = mixed_finder_look(&scratch->finder, &m.context, lone, samples);
    if (!error) error = trace_pixels(&m);
    if (!error) error = make_list(&m);
    const uint64_t *v = scratch->counters.value;
    c->counters->value[COUNTER_RAYS_ANTIALIAS] +=
        v[COUNTER_RAYS_ANTIALIAS] + v[COUNTER_RAYS_PRIMARY];
    return error;
}
