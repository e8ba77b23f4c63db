#include "worker/trace/hit/query_view.h"

#include <math.h>

const struct query_view *query_view_of(enum plan_view view)
{
    enum { REAL = INSTANCE_IS_CATCHER | INSTANCE_IS_HOLDOUT, ALL = REAL | INSTANCE_IS_VIRTUAL };
    static const struct query_view views[PLAN_VIEWS] = {
        [PLAN_VIEW_OBJECTS] = {.camera = ALL, .others = ALL, .shown = INSTANCE_IS_VIRTUAL},
        [PLAN_VIEW_WITH] = {.camera = REAL, .others = ALL, .shown = INSTANCE_IS_CATCHER},
        [PLAN_VIEW_WITHOUT] = {.camera = REAL, .others = REAL, .shown = INSTANCE_IS_CATCHER}};
    return &views[view];
}

void query_view_mask(uint32_t mask, struct RTCRayHit16 *rays)
{
    for (int i = 0; i < LANES; i++) rays->ray.mask[i] = mask;
}

void query_view_hide(const struct query_view *view, const struct render_scene *scene,
                     struct RTCRayHit16 *rays)
{
    struct RTCHit16 *hit = &rays->hit;
    for (int i = 0; i < LANES; i++) {
        if (hit->geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const uint32_t placed = hit->instID[0][i];
        const uint32_t index = placed != RTC_INVALID_GEOMETRY_ID ? placed : hit->geomID[i];
        if (instance_class(&scene->blob->instances[index]) & view->shown) continue;
        hit->geomID[i] = hit->instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        rays->ray.tfar[i] = INFINITY;
    }
}
