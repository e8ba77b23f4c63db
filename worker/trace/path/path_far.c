#include "worker/trace/path/path_far.h"

#include <string.h>

static void turn(struct lanes3 *v)
{
    for (int i = 0; i < LANES; i++) {
        v->x[i] = -v->x[i];
        v->y[i] = -v->y[i];
        v->z[i] = -v->z[i];
    }
}

/* The other side's origin lies as far behind the position as this side's before it. */
static void step_behind(struct surface *s)
{
    for (int i = 0; i < LANES; i++) {
        s->origin.x[i] = 2.0f * s->position.x[i] - s->origin.x[i];
        s->origin.y[i] = 2.0f * s->position.y[i] - s->origin.y[i];
        s->origin.z[i] = 2.0f * s->position.z[i] - s->origin.z[i];
    }
}

bool path_far_find(const struct path_vertex *v, struct path_vertex *far)
{
    struct lanes_mask on;
    bool any = false;
    for (int i = 0; v->any_general && i < LANES; i++) {
        const bool is = v->active.on[i] && !v->lambert.on[i] && bsdf_is_translucent(&v->bsdf[i]);
        on.on[i] = is ? -1 : 0;
        any |= is;
    }
    if (!any) return false;
    *far = *v;
    far->active = on;
    far->is_far = true;
    far->any_lambert = false;
    memset(&far->lambert, 0, sizeof far->lambert);
    memset(&far->surface.lift, 0, sizeof far->surface.lift);
    far->layers.any = false;
    far->layers.others = true;
    memset(&far->layers.on, 0, sizeof far->layers.on);
    turn(&far->surface.plane);
    turn(&far->surface.facet);
    turn(&far->surface.normal);
    step_behind(&far->surface);
    return true;
}
