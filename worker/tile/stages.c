#include "worker/tile/stages.h"

#include "proto/samples.h"

static bool has_rectangles(const struct plan *plan)
{
    for (uint32_t k = 0; k < plan->light_count; k++)
        if (plan->lights[k].type == LIGHT_RECTANGLE) return true;
    return false;
}

static bool has_blended(const struct material_table *materials)
{
    for (uint32_t k = 0; k < materials->count; k++)
        if (materials->materials[k].blend) return true;
    return false;
}

static bool has_emissive(const struct material_table *materials)
{
    for (uint32_t k = 0; k < materials->count; k++)
        if (materials->materials[k].emissive) return true;
    return false;
}

static bool shines_beside(const struct render_scene *scene, const struct plan *plan)
{
    return has_rectangles(plan) || has_emissive(scene->materials);
}

/* Whether all that shines is listed: no environment, and no mesh that no light stands for. */
static bool is_listed(const struct render_scene *scene, const struct plan *plan)
{
    if (plan->environment.kind != ENVIRONMENT_NONE) return false;
    for (uint64_t k = 0; k < scene->blob->count[SCENE_MESHES]; k++) {
        const struct mesh_view *mesh = &scene->meshes[k];
        if (mesh->material->emissive && !(mesh->flags & MESH_IS_LIGHT)) return false;
    }
    return true;
}

#define PLANES_DEMODULATED (PLANE_BIT(PATH_DIFFUSE_DIRECT) | PLANE_BIT(PATH_DIFFUSE_INDIRECT))

/* With bounce rays, but those of second sets. */
static bool traces_lobes(const struct plan *plan, const struct plan_pass *pass)
{
    return (plan->planes & PLANES_GLOSSY) != 0 && pass->strata > 0 && !pass->strata_map;
}

void stages_init(const struct path_context *parts, struct centre_gbuffer *centres,
                 const struct plan_pass *pass, struct stages *out)
{
    const struct plan *plan = parts->plan;
    const struct render_scene *scene = parts->queries->scene;
    const bool first = pass->number == 0;
    *out = (struct stages){
        .centres = first &&
                   ((plan->planes & ~(PLANES_PATH_ALL | PLANES_LENS_ALL | PLANES_LENS_MORE)) != 0 ||
                    plan->light_planes != 0),
        .lights = first,
        .lens = first && plan->lens_strata_per_axis > 0,
        .more = pass->strata_map && plan->lens_extra > 0,
        .pass = *pass,
        .bounces = (plan->planes & PLANES_BOUNCE_RAYS) != 0 && pass->strata > 0,
        .glossy = traces_lobes(plan, pass),
        .first = pass->first,
        .count = plan->paths.spp > 0 ? pass->count : 0};
    out->centres = out->centres || out->bounces;
    out->vertices = out->bounces || plan->paths.without_diffuse_direct || out->glossy ||
                    pass->strata_map || plan->lens_mirrors > 0 ||
                    (plan->planes & PLANE_BIT(LENS_LOBE)) != 0;
    out->albedo = (plan->planes & PLANE_BIT(ALBEDO)) != 0 || plan->light_planes != 0;
    out->paths = *parts;
    out->paths.demodulate = (plan->planes & PLANES_DEMODULATED) != 0;
    out->paths.features = (plan->planes & PLANES_RESIDUAL) != 0;
    out->paths.blended = has_blended(scene->materials);
    out->paths.shines = out->paths.shines_beside =
        plan->environment.kind != ENVIRONMENT_NONE || shines_beside(scene, plan);
    out->paths.leaves_surface = plan->paths.without_diffuse_direct != 0;
    out->paths.leaves_diffuse =
        plan->paths.without_diffuse_indirect != 0 && !out->paths.leaves_surface;
    out->paths.leaves_glossy = plan->paths.without_glossy_indirect != 0;
    out->field = out->paths;
    out->field.field = true;
    out->field.strata = pass->strata;
    out->field.strata_map = pass->strata_map;
    out->field.lobes = pass->lobes;
    out->field.pass = pass->number;
    out->field.listed = is_listed(scene, plan);
    out->field.mirrors = plan->lens_mirrors > 0;
    out->field.features = out->field.demodulate = out->field.leaves_diffuse =
        out->field.leaves_glossy = out->field.leaves_surface = false;
    out->whole = out->paths;
    out->whole.lens = true;
    out->whole.features = out->whole.demodulate = out->whole.leaves_diffuse =
        out->whole.leaves_glossy = out->whole.leaves_surface = false;
    out->through_lens = out->whole;
    out->through_lens.demodulate = plan->lens_light != LENS_LIGHT_OWN;
    out->through_lens.mirrors = plan->lens_mirrors > 0;
    out->through_lens.leaves_lobes = (plan->planes & PLANE_BIT(LENS_LOBE)) != 0;
    out->through_lens.leaves_sky = plan->lens_light == LENS_LIGHT_SKY;
    out->through_lens.leaves_diffuse =
        plan->lens_light == LENS_LIGHT_INDIRECT || plan->lens_light == LENS_LIGHT_SKY;
    if (out->through_lens.leaves_sky)
        out->through_lens.shines_beside = shines_beside(scene, plan) || parts->sky->hard;
    if (plan->lens_light != LENS_LIGHT_OWN && out->lens) out->through_lens.centres = centres;
}
