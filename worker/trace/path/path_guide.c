#include "worker/trace/path/path_guide.h"

#include <math.h>
#include <string.h>

#include "proto/pattern_path.h"
#include "worker/scene/photons.h"
#include "worker/scene/render_scene.h"
#include "worker/shade/direction.h"
#include "worker/shade/lambert.h"
#include "worker/trace/path/path_kernels.h"

/* A lamp's sphere fills at least a cone of this half angle's sine, so that its density is a number
 * that floats keep. */
#define SINE_MIN 0.01f

#define BELOW_ONE 0x1.fffffep-1f

static const struct emitter_groups *lamps_of(const struct path_context *c)
{
    return &c->queries->scene->glazing.lamps;
}

/* Returns whether the plan leaves lamps of the scene on, as far as that can be told. */
static bool shines(const struct path_context *c)
{
    return c->lights->emitters || c->lights->count > 0;
}

static bool has_lamps(const struct path_context *c)
{
    return shines(c) && lamps_of(c)->count > 0;
}

/* Returns a map of photons; NULL: none. */
static const struct photons *caustics_of(const struct path_context *c, int which)
{
    if (which == GUIDE_SKY) return c->sky->guide ? c->sky->guide->caustics : NULL;
    return shines(c) ? c->queries->scene->caustics : NULL;
}

bool path_guide_is_needed(const struct path_context *c)
{
    const bool panes = c->sky->guide && c->sky->guide->panes > 0;
    return (c->queries->scene->has_glass && (has_lamps(c) || panes)) || caustics_of(c, GUIDE_SKY) ||
           caustics_of(c, GUIDE_LAMPS);
}

/* ---- where to ---- */

/* A lamp as a surface sees it. */
struct cone {
    float axis[3];
    float sine2; /* of half its angle, squared; 1: the surface is within the sphere */
};

static struct cone cone_around(const struct path_vertex *v, int i, float x, float y, float z,
                               float radius)
{
    const struct lanes3 *from = &v->surface.position;
    struct cone out;
    const float distance =
        direction_normalize(x - from->x[i], y - from->y[i], z - from->z[i], out.axis);
    if (!(distance > 0.0f)) out.axis[2] = 1.0f;
    const float sine = radius / fmaxf(distance, 1e-18f);
    out.sine2 = fminf(fmaxf(sine * sine, SINE_MIN * SINE_MIN), 1.0f);
    return out;
}

static struct cone cone_of(const struct path_context *c, const struct path_vertex *v, int i,
                           uint32_t k)
{
    const struct emitter_groups *lamps = lamps_of(c);
    return cone_around(v, i, lamps->x[k], lamps->y[k], lamps->z[k], lamps->radius[k]);
}

static struct cone cone_of_photon(const struct path_vertex *v, int i,
                                  const struct photon_leaf *leaf, const struct photon *p)
{
    const struct lanes3 *at = &v->surface.position;
    const float d[3] = {at->x[i] - p->place[0], at->y[i] - p->place[1], at->z[i] - p->place[2]};
    float to[3];
    for (int k = 0; k < 3; k++) to[k] = p->from[k] + direction_dot(leaf->turn[k], d);
    return cone_around(v, i, to[0], to[1], to[2], p->reach);
}

/* Returns 1 minus the cosine of half the angle, without cancellation. */
static float height_of(const struct cone *cone)
{
    return cone->sine2 / (1.0f + sqrtf(1.0f - cone->sine2));
}

/* Shares lane i's part for lamps by what each may send, unless the surface is within it. */
static float share_lamps(const struct path_context *c, const struct path_vertex *v, int i,
                         float most, struct path_guide *g)
{
    _Alignas(LANES_ALIGN) float weight[EMITTER_GROUPS];
    const struct surface *s = &v->surface;
    const uint32_t count = lamps_of(c)->count;
    const float all = light_table_is_single(c->lights) ? 0.0f : v->weights.total[i];
    float sum = 0.0f;
    c->kernels->weigh_node(lamps_of(c), &s->origin, &s->normal, i, weight);
    for (uint32_t k = 0; k < count; k++) {
        if (cone_of(c, v, i, k).sine2 >= 0.99f) weight[k] = 0.0f;
        sum += weight[k];
    }
    const float share = sum < all ? most * (sum / all) : sum > 0.0f ? most : 0.0f;
    for (uint32_t k = 0; k < count; k++)
        g->lamps[k][i] = share > 0.0f ? share * (weight[k] / sum) : 0.0f;
    return share;
}

/* Layers of packets without other surfaces are those of an earlier packet. */
static bool has_layers(const struct path_vertex *v)
{
    return v->any_general && v->layers.any;
}

/* Paths are sent from surfaces that light samples light well, lobes of mirrors excepted. */
static bool may_send(const struct path_vertex *v, int i)
{
    return v->active.on[i] && (v->lambert.on[i] || (has_layers(v) && v->layers.on.on[i]));
}

/* Gives what is left to places where photons arrived, as light samples choose sky and lamps. */
static void share_caustics(const struct path_context *c, const float place[3],
                           const float normal[3], float sky, int i, struct path_guide *g)
{
    const float left = GUIDE_SHARE_MAX - g->share[i];
    for (int k = 0; k < GUIDE_CAUSTICS; k++) {
        const struct photons *map = caustics_of(c, k);
        const struct photon_leaf *leaf = map ? photons_find(map, place, normal) : NULL;
        const float part = left * (k == GUIDE_SKY ? sky : 1.0f - sky);
        g->leaf[k][i] = leaf;
        g->caustic[k][i] = leaf && part > 0.0f ? part * leaf->share : 0.0f;
        g->share[i] += g->caustic[k][i];
    }
}

bool path_guide_find(const struct path_context *c, const struct path_vertex *v,
                     struct path_guide *g)
{
    const struct sky_guide *guide = c->sky->guide;
    const struct lanes3 *at = &v->surface.position, *n = &v->surface.normal;
    bool any = false;
    memset(g->lamps, 0, sizeof g->lamps);
    for (int i = 0; i < LANES; i++) {
        g->share[i] = g->sky[i] = 0.0f;
        g->sent.on[i] = 0;
        if (!may_send(v, i)) continue;
        const float sky = guide ? v->sky_share[i] : 0.0f;
        const float place[3] = {at->x[i], at->y[i], at->z[i]};
        const float normal[3] = {n->x[i], n->y[i], n->z[i]};
        if (sky > 0.0f)
            g->sky[i] =
                GUIDE_SHARE_MAX * sky * sky_guide_glazed(guide, place, normal, &g->table[i]);
        g->share[i] = g->sky[i];
        if (has_lamps(c)) g->share[i] += share_lamps(c, v, i, GUIDE_SHARE_MAX * (1.0f - sky), g);
        share_caustics(c, place, normal, sky, i, g);
        any |= g->share[i] > 0.0f;
    }
    return any;
}

/* ---- directions ---- */

/* Samples a direction of a cone, uniformly. */
static void aim_at(const struct cone *cone, float u, float w, int i, struct lanes3 *out)
{
    float s[3], t[3], turn_sine, turn_cosine;
    const float down = u * height_of(cone), sine = sqrtf(fmaxf(down * (2.0f - down), 0.0f));
    direction_frame(cone->axis, s, t);
    elementary_sincos_turn(w, &turn_sine, &turn_cosine);
    const float a = sine * turn_cosine, b = sine * turn_sine, h = 1.0f - down;
    out->x[i] = a * s[0] + b * t[0] + h * cone->axis[0];
    out->y[i] = a * s[1] + b * t[1] + h * cone->axis[1];
    out->z[i] = a * s[2] + b * t[2] + h * cone->axis[2];
}

static bool sends_to_lamps(const struct path_guide *g, int i)
{
    bool any = false;
    for (uint32_t k = 0; k < EMITTER_GROUPS; k++) any |= g->lamps[k][i] > 0.0f;
    return any;
}

/* Returns the map that x in [0, share - sky) takes, and sets *x to where in its part; or
 * GUIDE_CAUSTICS for lamps, the last part that there may be. */
static int take_caustic(const struct path_guide *g, int i, float *x)
{
    int last = GUIDE_CAUSTICS;
    for (int k = 0; k < GUIDE_CAUSTICS; k++) {
        const float part = g->caustic[k][i];
        if (!(part > 0.0f)) continue;
        last = k;
        if (*x >= part) {
            *x -= part;
            continue;
        }
        *x /= part;
        return k;
    }
    if (last == GUIDE_CAUSTICS || sends_to_lamps(g, i)) return GUIDE_CAUSTICS;
    *x = BELOW_ONE; /* rounding left a little */
    return last;
}

/* Returns the photon of a leaf that x in [0, 1) takes. */
static const struct photon *take_photon(const struct path_context *c, const struct path_guide *g,
                                        int map, int i, float x)
{
    const struct photon_leaf *leaf = g->leaf[map][i];
    const uint32_t k = (uint32_t)(x * (float)leaf->count);
    return caustics_of(c, map)->photons + leaf->first + (k < leaf->count ? k : leaf->count - 1);
}

/* Returns the lamp that x in [0, share - sky) takes. */
static uint32_t take_lamp(const struct path_guide *g, int i, uint32_t count, float x)
{
    float upto = 0.0f;
    uint32_t taken = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (!(g->lamps[k][i] > 0.0f)) continue;
        taken = k;
        upto += g->lamps[k][i];
        if (x < upto) break;
    }
    return taken;
}

/* Samples the sky in the lanes of *to_sky. A direction from which nothing comes is of no length. */
static void aim_at_sky(const struct path_context *c, const struct path_guide *g,
                       const struct lanes_mask *to_sky, const float pick[LANES],
                       const float u[LANES], const float w[LANES], struct lanes3 *out)
{
    struct sky_texels texels;
    struct lanes3 direction;
    memset(&texels, 0, sizeof texels);
    for (int i = 0; i < LANES; i++) {
        if (!to_sky->on[i]) continue;
        const float at[2] = {u[i], w[i]};
        const struct sky_choice choice = sky_expect(c->sky, g->table[i], pick[i], at);
        sky_look(c->sky, &choice, sky_choose(c->sky, &choice, at), i, &texels);
    }
    c->kernels->place_sky(c->sky, &texels, u, w, &direction);
    for (int i = 0; i < LANES; i++) {
        if (!to_sky->on[i]) continue;
        const float length = texels.density[i] > 0.0f ? 1.0f : 0.0f;
        out->x[i] = length * direction.x[i];
        out->y[i] = length * direction.y[i];
        out->z[i] = length * direction.z[i];
    }
}

void path_guide_aim(const struct path_context *c, const struct path_packet *p,
                    const struct path_vertex *v, struct path_guide *g, float u[LANES],
                    float w[LANES])
{
    _Alignas(LANES_ALIGN) float which[LANES], pick[LANES];
    struct lanes_mask to_sky = {{0}};
    bool any_sky = false;
    c->kernels->path_pairs(p, PATH_GUIDE + v->depth, which, pick);
    memset(&g->direction, 0, sizeof g->direction);
    for (int i = 0; i < LANES; i++) {
        const float share = g->share[i];
        if (!(share > 0.0f)) continue;
        g->sent.on[i] = u[i] < share ? -1 : 0;
        u[i] = fminf(g->sent.on[i] ? u[i] / share : (u[i] - share) / (1.0f - share), BELOW_ONE);
        if (!g->sent.on[i]) continue;
        float x = which[i] * share - g->sky[i];
        to_sky.on[i] = x < 0.0f ? -1 : 0;
        any_sky |= x < 0.0f;
        if (x < 0.0f) continue;
        const int k = take_caustic(g, i, &x);
        const struct cone cone =
            k < GUIDE_CAUSTICS ? cone_of_photon(v, i, g->leaf[k][i], take_photon(c, g, k, i, x))
                               : cone_of(c, v, i, take_lamp(g, i, lamps_of(c)->count, x));
        aim_at(&cone, u[i], w[i], i, &g->direction);
    }
    if (any_sky) aim_at_sky(c, g, &to_sky, pick, u, w, &g->direction);
}

/* ---- weights ---- */

static void turn_lambert(const struct path_vertex *v, const struct path_guide *g, int i,
                         struct path_scattering *s)
{
    const struct surface *at = &v->surface;
    const struct lanes3 *d = &g->direction, *n = &at->normal, *f = &at->facet;
    const float cosine = d->x[i] * n->x[i] + d->y[i] * n->y[i] + d->z[i] * n->z[i];
    const float facet = d->x[i] * f->x[i] + d->y[i] * f->y[i] + d->z[i] * f->z[i];
    s->on.on[i] = cosine > 0.0f && facet > 0.0f ? -1 : 0;
    s->direction.x[i] = d->x[i];
    s->direction.y[i] = d->y[i];
    s->direction.z[i] = d->z[i];
    s->pdf[i] = cosine * LAMBERT_INV_PI;
}

/* Returns the density of a cone's directions; 0 for others. */
static float cone_density(const struct cone *cone, const float d[3])
{
    const float *a = cone->axis;
    const float x = d[1] * a[2] - d[2] * a[1], y = d[2] * a[0] - d[0] * a[2];
    const float z = d[0] * a[1] - d[1] * a[0];
    if (!(direction_dot(d, a) > 0.0f && x * x + y * y + z * z <= cone->sine2)) return 0.0f;
    return 1.0f / (2.0f * ELEMENTARY_PI * height_of(cone));
}

static float caustic_density(const struct path_context *c, const struct path_vertex *v,
                             const struct path_guide *g, int which, int i, const float d[3])
{
    const struct photon_leaf *leaf = g->leaf[which][i];
    const struct photon *p = caustics_of(c, which)->photons + leaf->first;
    float sum = 0.0f;
    for (uint32_t k = 0; k < leaf->count; k++) {
        const struct cone cone = cone_of_photon(v, i, leaf, &p[k]);
        sum += cone_density(&cone, d);
    }
    return sum / (float)leaf->count;
}

/* Returns the density with which lane i's paths are sent into its direction, times the share. */
static float density_of(const struct path_context *c, const struct path_vertex *v,
                        const struct path_guide *g, const struct path_scattering *s,
                        const struct sky_view *view, int i)
{
    const float d[3] = {s->direction.x[i], s->direction.y[i], s->direction.z[i]};
    float sum = 0.0f;
    if (g->sky[i] > 0.0f) sum += g->sky[i] * sky_pdf(c->sky, view, i, g->table[i]);
    for (int k = 0; k < GUIDE_CAUSTICS; k++)
        if (g->caustic[k][i] > 0.0f) sum += g->caustic[k][i] * caustic_density(c, v, g, k, i, d);
    for (uint32_t k = 0; has_lamps(c) && k < lamps_of(c)->count; k++) {
        if (!(g->lamps[k][i] > 0.0f)) continue;
        const struct cone cone = cone_of(c, v, i, k);
        sum += g->lamps[k][i] * cone_density(&cone, d);
    }
    return sum;
}

static void scale(float by, int i, struct lanes3 *v)
{
    v->x[i] *= by;
    v->y[i] *= by;
    v->z[i] *= by;
}

void path_guide_turn(const struct path_context *c, const struct path_vertex *v,
                     const struct path_guide *g, struct path_scattering *s)
{
    const struct lanes3 *d = &s->direction;
    struct sky_view view;
    for (int i = 0; i < LANES; i++)
        if (g->sent.on[i] && v->lambert.on[i]) turn_lambert(v, g, i, s);
    if (has_layers(v)) c->kernels->layers_turn(v, &g->sent, &g->direction, s);
    if (c->sky->guide) c->kernels->find_sky(c->sky, d->x, d->y, d->z, &view);
    for (int i = 0; i < LANES; i++) {
        if (!(s->on.on[i] && g->share[i] > 0.0f)) continue;
        const float own = s->pdf[i];
        const float all = (1.0f - g->share[i]) * own + density_of(c, v, g, s, &view, i);
        scale(own / all, i, &s->weight);
        scale(own / all, i, &s->specular);
        s->diffuse[i] *= own / all;
        s->promise[i] *= all / own;
    }
}
