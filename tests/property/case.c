/* Drawing cases. Ordinary scenes are a few bodies under a few lights; one draw in four is
 * degenerate in some way: no area, coincident, needles, grazing light, blockers at the receiver or
 * at the light, pictures of one pixel. */
#include "tests/property/case.h"

#include <math.h>
#include <string.h>

const char *const case_methods[] = {"auto", "sheared", "axis_aligned", "average", "none", NULL};
const char *const case_indirects[] = {"auto",  "average", "constant", "linear",
                                      "blend", "sheared", "adaptive", NULL};
const char *const case_glossies[] = {"auto", "average",    "virtual_hit", "bandlimit",
                                     "sg",   "sg_mixture", "asg",         NULL};
const char *const case_lenses[] = {"auto", "average", "axis_aligned", "sheared", NULL};
const char *const case_environments[] = {"auto", "average", "axis_aligned", NULL};
const char *const case_residuals[] = {"auto", "none", "halves", NULL};

static double on_grid(double v)
{
    return round(v / CASE_GRID) * CASE_GRID;
}

static double between(struct random *r, double least, double most)
{
    return least + (most - least) * (double)random_unit(r);
}

static int below(struct random *r, int n)
{
    return (int)(random_bits(r) % (uint64_t)n);
}

static bool one_in(struct random *r, int n)
{
    return below(r, n) == 0;
}

static int names(const char *const *list)
{
    int n = 0;
    while (list[n]) n++;
    return n;
}

static void draw_body(struct random *r, struct case_body *b)
{
    static const enum body_shape shapes[] = {BODY_PANEL, BODY_PANEL,  BODY_BOX,  BODY_BOX,
                                             BODY_BOX,   BODY_NEEDLE, BODY_POINT};
    /* Lambert half of the time: light fields cover nothing else. */
    b->shape = shapes[below(r, 7)];
    b->surface = one_in(r, 2) ? SURFACE_LAMBERT : (enum body_surface)below(r, SURFACE_FURNACE);
    for (int i = 0; i < 3; i++) {
        b->centre[i] = on_grid(between(r, -1.5, 1.5));
        b->size[i] = on_grid(between(r, 0.05, 0.8));
        b->albedo[i] = between(r, 0, 0.9);
    }
    if (one_in(r, 12)) b->size[below(r, 3)] = 0;
    b->facing = below(r, 6);
    b->sharpness = one_in(r, 6) ? 0 : one_in(r, 6) ? 1 : (double)random_unit(r);
}

static void draw_light(struct random *r, struct case_light *l)
{
    static const enum case_light_kind kinds[] = {CASE_RECTANGLE, CASE_RECTANGLE, CASE_GAUSSIAN,
                                                 CASE_POINT,     CASE_SPOT,      CASE_SUN};
    l->kind = kinds[below(r, 6)];
    l->facing = one_in(r, 3) ? below(r, 6) : 4;
    for (int i = 0; i < 3; i++) {
        l->centre[i] = on_grid(between(r, i == 1 ? 0.5 : -1.5, i == 1 ? 2.5 : 1.5));
        l->level[i] = between(r, 0, 8);
    }
    for (int i = 0; i < 2; i++) l->half[i] = on_grid(between(r, 0.02, 0.8));
    if (one_in(r, 12)) l->half[below(r, 2)] = one_in(r, 4) ? 0 : CASE_GRID / 4096;
    /* So near above the floor that its light grazes, or that blockers lie at it. */
    if (one_in(r, 10)) l->centre[1] = -1 + CASE_GRID;
}

static void draw_filters(struct random *r, struct property_case *c)
{
    static const int counts[] = {1, 4, 4, 9, 9, 16, 25};
    c->spp = counts[below(r, 7)];
    c->method = below(r, names(case_methods));
    c->indirect = below(r, CASE_ADAPTIVE); /* which draw_rounds deals */
    c->glossy = below(r, names(case_glossies));
    c->lens_filter = below(r, names(case_lenses));
    c->bounces = one_in(r, 3) ? 0 : one_in(r, 4) ? 8 : 1 + below(r, 3);
    c->occlusion = one_in(r, 4) ? on_grid(between(r, 0.1, 4)) : 0;
}

static void draw_view(struct random *r, struct property_case *c)
{
    c->width = one_in(r, 6) ? 1 : 4 + below(r, 44);
    c->height = one_in(r, 6) ? 1 : 4 + below(r, 44);
    c->tile = 16 << below(r, 3);
    c->block = 32 << below(r, 2);
    c->seed = (unsigned)below(r, 1000);
    for (int i = 0; i < 3; i++) c->target[i] = on_grid(between(r, -0.5, 0.5));
    c->eye[0] = on_grid(between(r, -2, 2));
    c->eye[1] = on_grid(between(r, 0, 2.5));
    c->eye[2] = on_grid(between(r, 2, 4));
    c->yfov_deg = between(r, 15, 80);
    c->layers = one_in(r, 2);
    if (!one_in(r, 3)) return;
    /* Paths alone have other layers through a lens. */
    c->layers = one_in(r, 8);
    c->aperture = one_in(r, 4) ? 0 : on_grid(between(r, 0.02, 0.3));
    c->focus = on_grid(between(r, 0.5, 6));
    c->blades = one_in(r, 2) ? 0 : 3 + below(r, 5);
}

/* Two that lie in one place, and one that all but touches another. */
static void draw_coincident(struct random *r, struct property_case *c)
{
    struct case_body *a = &c->bodies[below(r, c->body_count)],
                     *b = &c->bodies[below(r, c->body_count)];
    const enum body_surface surface = b->surface;
    *b = *a;
    b->surface = surface;
    if (one_in(r, 2)) b->centre[below(r, 3)] += CASE_GRID;
}

/* Of a third of all, dresses that pure Lambert scenes may have, too; of another, any. */
static void draw_dresses(struct random *r, struct property_case *c)
{
    static const enum body_dress pure[] = {DRESS_COLOR, DRESS_MASK, DRESS_NORMAL};
    const int kind = below(r, 3);
    for (int i = 0; i < c->body_count; i++) {
        struct case_body *b = &c->bodies[i];
        b->smooth = one_in(r, 6);
        if (kind == 0 || !one_in(r, 2)) continue;
        b->dress = kind == 1 ? pure[below(r, 3)] : (enum body_dress)(1 + below(r, DRESSES - 1));
        b->texels = (unsigned)below(r, 1000);
    }
}

static void draw_sky(struct random *r, struct property_case *c)
{
    if (!one_in(r, 4)) return;
    for (int i = 0; i < 3; i++) c->environment[i] = between(r, 0, 1);
    if (one_in(r, 2)) c->map = 1 + (unsigned)below(r, 1000);
}

/* Sampling that goes on after what the schedule has, of two cases in five. */
static void draw_rounds(struct random *r, struct property_case *c)
{
    static const int most[] = {32, 64, 144};
    static const double mus[] = {0.5, 1, 1, 2};
    const int kind = below(r, 5);
    if (kind > 1) return;
    c->most = most[below(r, 3)];
    if (c->focus > 0 && !one_in(r, 4)) {
        c->lens_second_set = one_in(r, 3) ? 36 : 1 + below(r, 12);
        c->most = 0;
        /* No other filter mixes second sets in. */
        if (!one_in(r, 8)) c->lens_filter = CASE_LENS_SHEARED;
        if (c->spp < 4) c->spp = 4;
    } else if (kind == 0) {
        c->indirect = CASE_ADAPTIVE;
        c->mu = mus[below(r, 4)];
        if (c->bounces == 0 && c->occlusion == 0) c->bounces = 1 + below(r, 3);
    } else {
        c->error = between(r, 0.01, 0.2);
        if (c->spp < 4) c->spp = 4;
    }
}

/* Where light comes along paths and not by fields, or the other way round, or by fewer rays. */
static void draw_division(struct random *r, struct property_case *c)
{
    if (one_in(r, 3)) c->environment_filter = below(r, names(case_environments));
    if (one_in(r, 3)) c->residual = below(r, names(case_residuals));
    c->halved = one_in(r, 3);
}

void case_draw(uint64_t seed, struct property_case *out)
{
    /* Streams of seeds that follow one another must not be one stream, shifted. */
    struct random start = {seed}, r = {random_bits(&start)};
    memset(out, 0, sizeof *out);
    draw_view(&r, out);
    draw_filters(&r, out);
    out->body_count = 1 + below(&r, CASE_BODIES - 1);
    for (int i = 0; i < out->body_count; i++) draw_body(&r, &out->bodies[i]);
    if (out->body_count > 1 && one_in(&r, 6)) draw_coincident(&r, out);
    /* Most have a floor. */
    if (!one_in(&r, 6))
        out->bodies[out->body_count++] = (struct case_body){
            .shape = BODY_PANEL,
            .surface =
                one_in(&r, 6) ? (enum body_surface)below(&r, SURFACE_FURNACE) : SURFACE_LAMBERT,
            .centre = {0, -1, 0},
            .size = {3, 0, 3},
            .facing = 1,
            .albedo = {0.6, 0.6, 0.6},
            .sharpness = 0.5};
    /* Half of all are pure Lambert: fields alone make these. */
    if (one_in(&r, 2))
        for (int i = 0; i < out->body_count; i++)
            if (out->bodies[i].surface != SURFACE_BLACK) out->bodies[i].surface = SURFACE_LAMBERT;
    out->light_count = one_in(&r, 10) ? 0 : 1 + below(&r, 3);
    for (int i = 0; i < out->light_count; i++) draw_light(&r, &out->lights[i]);
    draw_sky(&r, out);
    draw_rounds(&r, out);
    draw_dresses(&r, out);
    out->orthographic = one_in(&r, 6);
    out->tent = one_in(&r, 10);
    draw_division(&r, out);
}
