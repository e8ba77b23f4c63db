#include "server/reconstruct/lighting/disocclusion.h"

#include <math.h>
#include <string.h>

#include "proto/error.h"
#include "server/reconstruct/patch/surface.h"

#define RADIUS_PX  3.5f /* at 9 samples a pixel */
#define ROOM_FIRST 4096
#define SPOTS_MAX  8 /* surfaces of a cell */
#define NOWHERE    UINT32_MAX

/* Samples whose mean shows little noise. A pixel's lighting, which is filtered, counts as
 * PIXEL_SAMPLES. */
#define ENOUGH        64.0f
#define PIXEL_SAMPLES 16.0f

/* Other surfaces that do for one's own face within 60 degrees, and are off its plane by so many
 * times what is allowed. */
#define COSINE_ABOUT 0.5f
#define OFF_ABOUT    6.0f

/* Pixels around a sample whose lighting is surely there: those beside its own. */
#define PIXELS_SQUARE 2.0f

/* A surface in a cell: the first sample's; sums of all samples' light; what they share, once
 * it was needed. */
struct disocclusion_spot {
    float point[3], normal[3], off;
    float light[3], shared[3], number;
    float rest[3], shared_rest[3], sent; /* what samples send besides, of how many */
    uint32_t cell, next;                 /* of the same cell; NOWHERE: the last */
    bool known;
};

int disocclusion_create(struct scratch *scratch, size_t width, size_t height, uint32_t l,
                        struct disocclusion *out)
{
    const size_t area = width * height;
    const float most = (float)DISOCCLUSION_REACH_PX + 0.5f;
    const float radius = RADIUS_PX * sqrtf(3.0f / (float)l);
    *out = (struct disocclusion){.scratch = scratch, .width = width, .height = height};
    out->radius = radius < most ? radius : most;
    const float rest = RADIUS_PX * 3.0f / (float)l;
    out->rest_radius = rest < most ? rest : most;
    out->first = scratch_take(scratch, area * sizeof *out->first);
    if (!out->first) return ERR_MEMORY;
    memset(out->first, 0xff, area * sizeof *out->first); /* NOWHERE */
    return 0;
}

void disocclusion_fini(struct disocclusion *d)
{
    scratch_give(d->scratch, d->list);
    scratch_give(d->scratch, d->spots);
    scratch_give(d->scratch, d->first);
}

/* Room for one more element in *list. */
static int make_room(struct scratch *scratch, void **list, size_t count, size_t *room, size_t bytes)
{
    const size_t more = *room > 0 ? 2 * *room : ROOM_FIRST;
    if (count < *room) return 0;
    void *grown = scratch_take(scratch, more * bytes);
    if (!grown) return ERR_MEMORY;
    if (count > 0) memcpy(grown, *list, count * bytes);
    scratch_give(scratch, *list);
    *list = grown;
    *room = more;
    return 0;
}

/* How another surface lies to a spot's. */
struct relation {
    float cosine, from, own;
};

static float cosine_of(const float normal[3], const float facing[3])
{
    float cosine = 0.0f;
    for (int c = 0; c < 3; c++) cosine += facing[c] * normal[c];
    return cosine;
}

static struct relation relate(const float point[3], const float normal[3], const float at[3],
                              const float facing[3])
{
    struct relation r = {.cosine = cosine_of(normal, facing)};
    for (int c = 0; c < 3; c++) {
        const float away = at[c] - point[c];
        r.from += away * normal[c];
        r.own += away * facing[c];
    }
    r.from = fabsf(r.from);
    r.own = fabsf(r.own);
    return r;
}

/* off: from each other's planes, at most. */
static bool is_same(struct relation r, float off)
{
    return r.cosine >= SURFACE_COS_FULL && r.from <= off && r.own <= off;
}

/* Returns the weight of another surface. */
static float about(struct relation r, float off)
{
    const float turn = (r.cosine - COSINE_ABOUT) / (1.0f - COSINE_ABOUT);
    const float near = 1.0f - fmaxf(r.from, r.own) / (OFF_ABOUT * off); /* off is above 0 */
    return turn > 0.0f && near > 0.0f ? turn * turn * near : 0.0f;
}

/* Adds a surface that the cell does not have. Returns NOWHERE if there are too many, or without
 * memory. */
static uint32_t add_spot(struct disocclusion *d, size_t cell, const float point[3],
                         const float normal[3], float off, int *error)
{
    void *spots = d->spots;
    *error = make_room(d->scratch, &spots, d->spot_count, &d->spot_room, sizeof *d->spots);
    d->spots = spots;
    if (*error) return NOWHERE;
    struct disocclusion_spot *spot = &d->spots[d->spot_count];
    *spot = (struct disocclusion_spot){.off = off, .cell = (uint32_t)cell, .next = d->first[cell]};
    memcpy(spot->point, point, sizeof spot->point);
    memcpy(spot->normal, normal, sizeof spot->normal);
    d->first[cell] = (uint32_t)d->spot_count;
    return (uint32_t)d->spot_count++;
}

int disocclusion_add(struct disocclusion *d, const struct lens_relight_row *r, uint32_t i,
                     const float light[3], const float rest[3], uint32_t shares, size_t at)
{
    const size_t column = (size_t)r->column[i] + (r->across[i] >= 0.5f ? 1 : 0);
    const size_t row = (size_t)r->row[i] + (r->down[i] >= 0.5f ? 1 : 0);
    const size_t cell = row * d->width + column;
    const float point[3] = {r->point[0][i], r->point[1][i], r->point[2][i]};
    const float normal[3] = {r->normal[0][i], r->normal[1][i], r->normal[2][i]};
    uint32_t spot = d->first[cell], count = 0;
    int error = 0;
    for (; spot != NOWHERE; spot = d->spots[spot].next, count++) {
        const struct disocclusion_spot *s = &d->spots[spot];
        if (is_same(relate(s->point, s->normal, point, normal), r->off[i])) break;
    }
    if (spot == NOWHERE && count == SPOTS_MAX) return 0;
    if (spot == NOWHERE) spot = add_spot(d, cell, point, normal, r->off[i], &error);
    void *list = d->list;
    if (!error) error = make_room(d->scratch, &list, d->count, &d->room, sizeof *d->list);
    d->list = list;
    if (error) return error;
    struct disocclusion_spot *s = &d->spots[spot];
    const float light_share = shares & DISOCCLUSION_LIGHT ? 1.0f : 0.0f;
    const float rest_share = shares & DISOCCLUSION_REST ? 1.0f : 0.0f;
    for (int c = 0; c < 3; c++) s->light[c] += light_share * light[c];
    for (int c = 0; c < 3; c++) s->rest[c] += rest_share * rest[c];
    s->number += light_share;
    s->sent += rest_share;
    d->list[d->count++] = (struct disocclusion_sample){.at = at,
                                                       .spot = spot,
                                                       .shares = shares,
                                                       .light = {light[0], light[1], light[2]},
                                                       .rest = {rest[0], rest[1], rest[2]}};
    return 1;
}

/* Light, and of how many samples: [0] of the spot's own surface, [1] of what does for it. */
struct sums {
    float light[2][3], number[2];
    float rest[3], sent; /* what samples of the spot's own surface send besides, of how many */
};

static void add(struct sums *s, int other, const float light[3], float weight, float number)
{
    for (int c = 0; c < 3; c++) s->light[other][c] += weight * light[c];
    s->number[other] += weight * number;
}

/* Samples of a cell around. */
static void add_cell(const struct disocclusion *d, const struct disocclusion_spot *own, size_t cell,
                     float weight, float rest_weight, struct sums *sums)
{
    for (uint32_t k = d->first[cell]; k != NOWHERE; k = d->spots[k].next) {
        const struct disocclusion_spot *s = &d->spots[k];
        if (s != own && cosine_of(own->normal, s->normal) <= COSINE_ABOUT) continue;
        const struct relation r = relate(own->point, own->normal, s->point, s->normal);
        const bool same = s == own || is_same(r, own->off);
        const float alike = same ? 1.0f : about(r, own->off);
        if (!(alike > 0.0f)) continue;
        add(sums, same ? 0 : 1, s->light, weight * alike, s->number);
        /* Other surfaces reflect another part: what little bright ones took from large dim ones,
         * these would not take from them. */
        for (int c = 0; same && c < 3; c++) sums->rest[c] += rest_weight * s->rest[c];
        sums->sent += same ? rest_weight * s->sent : 0.0f;
    }
}

/* Lighting of a pixel around. */
static void add_pixel(const struct light_lookup_pixel *l, const struct disocclusion_spot *own,
                      float weight, struct sums *sums)
{
    const float point[3] = {l->point[0], l->point[1], l->point[2]};
    const float normal[3] = {l->plane[0], l->plane[1], l->plane[2]};
    const float light[3] = {PIXEL_SAMPLES * l->light[0], PIXEL_SAMPLES * l->light[1],
                            PIXEL_SAMPLES * l->light[2]};
    if (!(l->light[3] > 0.0f)) return;
    const float alike = about(relate(own->point, own->normal, point, normal), own->off);
    if (alike > 0.0f) add(sums, 1, light, weight * alike, PIXEL_SAMPLES);
}

/* Mixes in as much of [1] as makes both enough, and divides by the total. */
static void mean(float of[2][3], const float number[2], float out[3])
{
    const float lacks = fmaxf(ENOUGH - number[0], 0.0f);
    const float take = number[1] > lacks ? lacks / number[1] : 1.0f;
    const float all = number[0] + take * number[1];
    for (int c = 0; c < 3; c++) out[c] = all > 0.0f ? (of[0][c] + take * of[1][c]) / all : 0.0f;
}

static void share(const struct disocclusion *d, const struct light_lookup_pixel *pixels,
                  struct disocclusion_spot *own)
{
    const int32_t x = (int32_t)(own->cell % d->width), y = (int32_t)(own->cell / d->width);
    struct sums sums = {.number = {0}};
    for (int32_t v = y - DISOCCLUSION_REACH_PX; v <= y + DISOCCLUSION_REACH_PX; v++)
        for (int32_t u = x - DISOCCLUSION_REACH_PX; u <= x + DISOCCLUSION_REACH_PX; u++) {
            if (u < 0 || v < 0 || u >= (int32_t)d->width || v >= (int32_t)d->height) continue;
            const size_t q = (size_t)v * d->width + (size_t)u;
            const float square = (float)((u - x) * (u - x) + (v - y) * (v - y));
            const float weight = 1.0f - square / (d->radius * d->radius);
            const float rest = fmaxf(1.0f - square / (d->rest_radius * d->rest_radius), 0.0f);
            if (weight > 0.0f) add_cell(d, own, q, weight, rest, &sums);
            if (weight > 0.0f && square <= PIXELS_SQUARE) add_pixel(pixels + q, own, weight, &sums);
        }
    mean(sums.light, sums.number, own->shared);
    for (int c = 0; c < 3; c++)
        own->shared_rest[c] = sums.sent > 0.0f ? sums.rest[c] / sums.sent : 0.0f;
    own->known = true;
}

void disocclusion_share(const struct disocclusion *d, const struct light_lookup_pixel *pixels,
                        const struct disocclusion_sample *s, float light[3], float rest[3])
{
    struct disocclusion_spot *own = &d->spots[s->spot];
    if (!own->known) share(d, pixels, own);
    memcpy(light, s->shares & DISOCCLUSION_LIGHT ? own->shared : s->light, sizeof s->light);
    memcpy(rest, s->shares & DISOCCLUSION_REST ? own->shared_rest : s->rest, sizeof s->rest);
}
