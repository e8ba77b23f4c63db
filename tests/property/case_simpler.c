/* Ways to make a case simpler. Each takes something away or sets it to what is plainest; that
 * nothing of it grows is what ends the search for the simplest case that still fails. */
#include <math.h>
#include <string.h>

#include "tests/property/case.h"

typedef void change(struct property_case *c);

static void no_lens(struct property_case *c)
{
    c->aperture = c->focus = 0, c->blades = 0;
}
static void no_blades(struct property_case *c)
{
    c->blades = 0;
}
static void no_environment(struct property_case *c)
{
    memset(c->environment, 0, sizeof c->environment);
    c->map = 0;
}
static void no_map(struct property_case *c)
{
    c->map = 0;
}
static void no_tent(struct property_case *c)
{
    c->tent = 0;
}
static void perspective(struct property_case *c)
{
    c->orthographic = 0;
}
static void no_occlusion(struct property_case *c)
{
    c->occlusion = 0;
}
static void no_bounce(struct property_case *c)
{
    c->bounces = 0;
}
static void one_bounce(struct property_case *c)
{
    c->bounces = c->bounces < 1 ? c->bounces : 1;
}
static void no_filter(struct property_case *c)
{
    c->method = 4, c->indirect = c->glossy = c->lens_filter = 0;
}
static void average(struct property_case *c)
{
    c->method = c->method == 4 ? 4 : 3;
}
static void picture_alone(struct property_case *c)
{
    c->layers = 0;
}
static void indirect_auto(struct property_case *c)
{
    c->indirect = 0;
}
static void glossy_auto(struct property_case *c)
{
    c->glossy = 0;
}
static void lens_auto(struct property_case *c)
{
    c->lens_filter = 0;
}
static void sky_auto(struct property_case *c)
{
    c->environment_filter = 0;
}
static void residual_auto(struct property_case *c)
{
    c->residual = 0;
}
static void whole_fields(struct property_case *c)
{
    c->halved = 0;
}
static void no_rounds(struct property_case *c)
{
    c->mu = c->error = 0, c->most = c->lens_second_set = 0;
    if (c->indirect == CASE_ADAPTIVE) c->indirect = 0;
}
static void no_target(struct property_case *c)
{
    c->error = 0;
    if (c->indirect != CASE_ADAPTIVE) c->most = 0;
}
static void no_second_lens(struct property_case *c)
{
    c->lens_second_set = 0;
}
static void plain_mu(struct property_case *c)
{
    c->mu = 0;
}
static void fewer_at_max(struct property_case *c)
{
    c->most = c->most < 32 ? c->most : 32;
}
static void plain_cut(struct property_case *c)
{
    c->tile = 64, c->block = 64;
}
static void one_pixel(struct property_case *c)
{
    c->width = c->height = 1;
}
static void half_width(struct property_case *c)
{
    c->width = (c->width + 1) / 2;
}
static void half_height(struct property_case *c)
{
    c->height = (c->height + 1) / 2;
}
static void one_sample(struct property_case *c)
{
    c->spp = 1;
}
static void four_samples(struct property_case *c)
{
    c->spp = c->spp < 4 ? c->spp : 4;
}
static void first_seed(struct property_case *c)
{
    c->seed = 1;
}
static void plain_view(struct property_case *c)
{
    memcpy(c->eye, (double[]){0, 1, 3}, sizeof c->eye);
    memset(c->target, 0, sizeof c->target);
    c->yfov_deg = 45;
}

static change *const changes[] = {
    no_rounds,   no_target,      no_second_lens, plain_mu,      fewer_at_max, no_lens,
    no_blades,   no_environment, no_occlusion,   no_bounce,     one_bounce,   no_filter,
    average,     indirect_auto,  glossy_auto,    picture_alone, lens_auto,    plain_cut,
    one_pixel,   half_width,     half_height,    one_sample,    four_samples, first_seed,
    plain_view,  no_map,         no_tent,        perspective,   sky_auto,     residual_auto,
    whole_fields};
enum { CHANGES = sizeof changes / sizeof changes[0], OF_BODY = 9, OF_LIGHT = 5 };

/* Coarser by a factor of eight at a time. */
static double coarser(double v)
{
    for (double step = CASE_GRID * 8; step <= 1; step *= 8)
        if (fmod(v, step) != 0) return round(v / step) * step;
    return v;
}

static void change_body(struct property_case *c, int i, int way)
{
    struct case_body *b = &c->bodies[i];
    switch (way) {
    case 0:
        memmove(b, b + 1, (size_t)(c->body_count - i - 1) * sizeof *b);
        c->body_count--;
        break;
    case 1:
        b->surface = SURFACE_LAMBERT;
        break;
    case 2:
        b->shape = BODY_PANEL;
        break;
    case 3:
        for (int k = 0; k < 3; k++) b->albedo[k] = 0.5;
        break;
    case 4:
        b->sharpness = 0.5;
        break;
    case 5:
        for (int k = 0; k < 3; k++) b->centre[k] = coarser(b->centre[k]);
        break;
    case 6:
        b->dress = DRESS_PLAIN, b->texels = 0;
        break;
    case 7:
        b->smooth = 0;
        break;
    default:
        for (int k = 0; k < 3; k++) b->size[k] = coarser(b->size[k]);
    }
}

static void change_light(struct property_case *c, int i, int way)
{
    struct case_light *l = &c->lights[i];
    switch (way) {
    case 0:
        memmove(l, l + 1, (size_t)(c->light_count - i - 1) * sizeof *l);
        c->light_count--;
        break;
    case 1:
        l->kind = l->kind == CASE_GAUSSIAN ? CASE_RECTANGLE : l->kind;
        break;
    case 2:
        for (int k = 0; k < 3; k++) l->level[k] = 1;
        break;
    case 3:
        for (int k = 0; k < 3; k++) l->centre[k] = coarser(l->centre[k]);
        break;
    default:
        for (int k = 0; k < 2; k++) l->half[k] = coarser(l->half[k]);
    }
}

bool case_simpler(const struct property_case *c, int n, struct property_case *out)
{
    *out = *c;
    /* Whole things first: what goes early spares much. */
    if (n < c->body_count * OF_BODY) {
        const int way = n / c->body_count;
        if (way > 0 || c->body_count > 1) change_body(out, n % c->body_count, way);
        return true;
    }
    n -= c->body_count * OF_BODY;
    if (n < c->light_count * OF_LIGHT) {
        change_light(out, n % c->light_count, n / c->light_count);
        return true;
    }
    n -= c->light_count * OF_LIGHT;
    if (n >= CHANGES) return false;
    changes[n](out);
    return true;
}
