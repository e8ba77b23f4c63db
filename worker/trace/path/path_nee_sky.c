/* Light samples of the environment. Each step is done for all lanes before the next, since most
 * reads of a map miss the cache. */
#include <math.h>
#include <string.h>

#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"

/* The lanes that sample the environment. */
struct skies {
    int lane[LANES], count;
    struct lanes3 direction;
    struct sky_texels texels;
};

static void find_lanes(const struct light_selection *selection, struct skies *s)
{
    s->count = 0;
    memset(&s->texels, 0, sizeof s->texels); /* other lanes are placed, too */
    for (int i = 0; i < LANES; i++)
        if (selection->chosen[i] == LIGHT_CHOICE_ENVIRONMENT) s->lane[s->count++] = i;
}

/* Samples directions and their densities. */
static void place(const struct path_context *c, const struct path_vertex *v,
                  const struct light_selection *selection, struct skies *s)
{
    const int count = s->count;
    struct sky_choice choice[LANES];
    uint32_t texel[LANES];
    for (int k = 0; k < count; k++) {
        const int i = s->lane[k];
        choice[k] = sky_expect(c->sky, v->sky_table[i], selection->pick[i],
                               (float[]){selection->u[i], selection->v[i]});
    }
    for (int k = 0; k < count; k++) {
        const int i = s->lane[k];
        texel[k] = sky_choose(c->sky, &choice[k], (float[]){selection->u[i], selection->v[i]});
    }
    for (int k = 0; k < count; k++) sky_look(c->sky, &choice[k], texel[k], s->lane[k], &s->texels);
    c->kernels->place_sky(c->sky, &s->texels, selection->u, selection->v, &s->direction);
}

/* Sets lane i's cosine and ray. False: no light comes from there. */
static bool aim(const struct path_vertex *v, const struct skies *s, int i, struct light_packet *p)
{
    const float way[3] = {s->direction.x[i], s->direction.y[i], s->direction.z[i]};
    struct RTCRay16 *r = &p->rays.ray;
    p->density[i] = s->texels.density[i];
    if (!(p->density[i] > 0.0f)) {
        p->skip[i] = LIGHT_FACING_AWAY;
        return false;
    }
    if (!path_nee_aim(v, i, way, 1.0f, p)) return false;
    p->irradiance[i] /= p->density[i];
    r->dir_x[i] = way[0];
    r->dir_y[i] = way[1];
    r->dir_z[i] = way[2];
    r->tfar[i] = INFINITY;
    return true;
}

void path_nee_sample_sky(const struct path_context *c, const struct path_vertex *v,
                         struct light_selection *selection, struct nee_sample *out)
{
    struct skies s;
    struct sky_view view;
    int seen = 0;
    find_lanes(selection, &s);
    if (s.count == 0) return;
    place(c, v, selection, &s);
    for (int k = 0; k < s.count; k++)
        if (aim(v, &s, s.lane[k], &out->packet)) s.lane[seen++] = s.lane[k];
    if (seen == 0) return;
    const struct lanes3 *d = &s.direction;
    c->kernels->find_sky(c->sky, d->x, d->y, d->z, &view);
    for (int k = 0; k < seen; k++) sky_ask(c->sky, &view, s.lane[k]);
    for (int k = 0; k < seen; k++) {
        const int i = s.lane[k];
        float radiance[3];
        selection->soft[i] = sky_radiance(c->sky, &view, i, radiance);
        out->color.x[i] = radiance[0];
        out->color.y[i] = radiance[1];
        out->color.z[i] = radiance[2];
    }
}
