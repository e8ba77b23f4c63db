#include "worker/trace/light/sky.h"

#include <math.h>
#include <string.h>

#include "worker/shade/elementary.h"

void sky_init(struct sky *sky, const struct plan_environment *plan, const struct environment *map,
              const struct sky_guide *guide)
{
    *sky = (struct sky){
        .kind = plan->kind, .map = map, .guide = guide, .cosine = 1.0f, .soft_max = INFINITY};
    memcpy(sky->radiance, plan->radiance, sizeof sky->radiance);
    if (plan->kind != ENVIRONMENT_MAP) return;
    sky->cosine = elementary_cos(plan->rotation_rad);
    sky->sine = elementary_sin(plan->rotation_rad);
    environment_size(map, &sky->width, &sky->height);
    sky->soft_max = SKY_SOFT_TIMES * environment_mean(map);
    sky->hard = environment_max(map) > sky->soft_max;
}

static struct environment_spot spot_of(const struct sky_view *view, int lane)
{
    return (struct environment_spot){view->u[lane], view->v[lane]};
}

void sky_ask(const struct sky *sky, const struct sky_view *view, int lane)
{
    if (sky->kind == ENVIRONMENT_MAP) environment_ask(sky->map, spot_of(view, lane));
}

float sky_radiance(const struct sky *sky, const struct sky_view *view, int lane, float radiance[3])
{
    memcpy(radiance, sky->radiance, 3 * sizeof radiance[0]);
    if (sky->kind != ENVIRONMENT_MAP) return 1.0f;
    environment_read(sky->map, spot_of(view, lane), radiance);
    const float bright = 0.2126f * radiance[0] + 0.7152f * radiance[1] + 0.0722f * radiance[2];
    for (int c = 0; c < 3; c++) radiance[c] *= sky->radiance[c];
    return bright > sky->soft_max ? sky->soft_max / bright : 1.0f;
}

float sky_pdf(const struct sky *sky, const struct sky_view *view, int lane, uint32_t table)
{
    const struct lanes3 *d = &view->direction;
    const float direction[3] = {d->x[lane], d->y[lane], d->z[lane]};
    const struct environment_density at =
        environment_density(sky->map, direction, spot_of(view, lane));
    return sky_table_probability(&sky->guide->tables[table], at.bin) * at.within;
}

struct sky_choice sky_expect(const struct sky *sky, uint32_t table, float choice, const float u[2])
{
    struct sky_choice out = {.within = choice};
    const struct sky_table *bins = &sky->guide->tables[table];
    out.bin = sky_table_choose(bins, &out.within);
    out.probability = sky_table_probability(bins, out.bin);
    environment_expect(sky->map, out.bin, out.within, u);
    return out;
}

uint32_t sky_choose(const struct sky *sky, const struct sky_choice *choice, const float u[2])
{
    return environment_choose(sky->map, choice->bin, choice->within, u);
}

void sky_look(const struct sky *sky, const struct sky_choice *choice, uint32_t texel, int lane,
              struct sky_texels *out)
{
    const struct environment_texel t = environment_texel_of(sky->map, texel);
    out->near[lane] = t.near;
    out->far[lane] = t.far;
    out->column[lane] = t.column;
    out->density[lane] = t.density * choice->probability;
    out->below.on[lane] = t.below ? -1 : 0;
}
