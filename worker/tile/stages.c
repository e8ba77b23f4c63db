#include "worker/tile/stages.h"

#include "proto/samples.h"
#include "worker/trace/path/path_guide.h"

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

static bool has_other_emission(const struct render_scene *scene, const struct plan *plan)
{
    return has_rectangles(plan) || has_emissive(scene->materials);
}

/* Returns whether the plan's lights are all that emits: there is no environment, and a light stands
 * for each mesh that emits. */
static bool has_lights_only(const struct render_scene *scene, const struct plan *plan)
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

static struct stages choose(const struct plan *plan, const struct plan_pass *pass)
{
    const bool first = pass->number == 0;
    struct stages s = {
        .centres = first && ((plan->planes & ~(PLANES_PATH_ALL | PLANES_LENS_ALL |
                                               PLANES_LENS_SECOND_SET | PLANES_MATTE)) != 0 ||
                             plan->light_planes != 0),
        .lights = first,
        .lens = first && plan->lens_strata_per_axis > 0,
        .more = pass->strata_map && plan->lens_extra > 0,
        .pass = *pass,
        .bounces = (plan->planes & PLANES_BOUNCE_RAYS) != 0 && pass->strata > 0,
        .glossy = traces_lobes(plan, pass),
        .albedo = (plan->planes & PLANE_BIT(ALBEDO)) != 0 || plan->light_planes != 0,
        .first = pass->first,
        .count = plan->paths.spp > 0 && !plan_lens_has_paths(plan) ? pass->count : 0};
    s.skips_paths = plan->paths.without_diffuse_direct == DIRECT_LEFT_ALL &&
                    !(plan->planes & PLANE_BIT(PATH_VISIBILITY));
    s.centres = s.centres || s.bounces;
    s.vertices = s.bounces || plan->paths.without_diffuse_direct || s.glossy || pass->strata_map ||
                 plan->lens_mirrors > 0 || (plan->planes & PLANE_BIT(LENS_LOBE)) != 0;
    return s;
}

/* Each half of so many samples shows both turns of glass once, if there are samples for that. */
static float turn_least_of(uint32_t samples)
{
    return samples >= 4 ? 2.0f / (float)samples : 0.0f;
}

/* A target may ask for more samples than the plan has at first. */
static uint32_t samples_upto(const struct plan *plan, const struct plan_pass *pass)
{
    const uint32_t upto = pass->first + pass->count;
    return upto > plan->paths.spp ? upto : plan->paths.spp;
}

static void init_paths(const struct path_context *parts, const struct plan_pass *pass,
                       struct path_context *out)
{
    const struct plan *plan = parts->plan;
    const struct render_scene *scene = parts->queries->scene;
    *out = *parts;
    out->demodulate = (plan->planes & (PLANES_DEMODULATED | PLANES_RESIDUAL)) != 0;
    out->features = (plan->planes & PLANES_RESIDUAL) != 0;
    out->turn_least = turn_least_of(samples_upto(plan, pass));
    out->guided = path_guide_is_needed(out);
    out->blended = has_blended(scene->materials);
    out->has_emission = out->has_other_emission =
        plan->environment.kind != ENVIRONMENT_NONE || has_other_emission(scene, plan);
    if (plan->paths.without_diffuse_direct == DIRECT_LEFT_ALL)
        out->skip = SKIP_DIFFUSE;
    else if (plan->paths.without_diffuse_indirect)
        out->skip = SKIP_DIFFUSE_INDIRECT;
    if (plan->paths.without_diffuse_indirect == INDIRECT_LEFT_SKY) out->skip |= SKIP_SKY_FIELD;
    if (plan->paths.without_diffuse_direct == DIRECT_LEFT_LISTED) out->skip |= SKIP_LISTED;
    if (plan->paths.without_glossy_indirect) out->skip |= SKIP_GLOSSY_INDIRECT;
    out->chains = out->features && out->demodulate &&
                  (out->skip & ~(uint32_t)(SKIP_LISTED | SKIP_DIFFUSE)) == 0;
}

/* Begins another kind of path. It leaves no light out and keeps it in one sum. */
static void init_whole(const struct path_context *paths, struct path_context *out)
{
    *out = *paths;
    out->features = out->demodulate = out->chains = false;
    out->skip = 0;
}

static void init_field(const struct path_context *paths, const struct plan_pass *pass,
                       struct path_context *out)
{
    init_whole(paths, out);
    out->field = true;
    out->strata = pass->strata;
    out->strata_map = pass->strata_map;
    out->lobes = pass->lobes;
    out->pass = pass->number;
    out->lights_only = has_lights_only(paths->queries->scene, paths->plan);
    out->mirrors = paths->plan->lens_mirrors > 0;
}

static void init_through_lens(const struct path_context *paths, const struct path_context *whole,
                              struct path_context *out)
{
    const struct plan *plan = whole->plan;
    *out = *whole;
    out->turn_least = turn_least_of(plan->lens_strata_per_axis * plan->lens_strata_per_axis);
    if (plan_lens_has_paths(plan)) {
        out->features = paths->features;
        out->demodulate = paths->demodulate;
        out->chains = paths->chains;
    }
    out->demodulate |= plan->lens_relight != LENS_RELIGHT_OWN;
    out->mirrors = plan->lens_mirrors > 0;
    const bool sky = plan->lens_relight == LENS_RELIGHT_SKY;
    if (sky || plan->lens_relight == LENS_RELIGHT_INDIRECT) out->skip |= SKIP_DIFFUSE_INDIRECT;
    if (plan->planes & PLANE_BIT(LENS_LOBE)) out->skip |= SKIP_GLOSSY_OF_LENS;
    if (sky) out->skip |= SKIP_SOFT_SKY;
    if (sky)
        out->has_other_emission =
            has_other_emission(whole->queries->scene, plan) || whole->sky->hard;
}

void stages_init(const struct path_context *parts, struct centre_gbuffer *centres,
                 const struct plan_pass *pass, struct stages *out)
{
    *out = choose(parts->plan, pass);
    init_paths(parts, pass, &out->paths);
    init_field(&out->paths, pass, &out->field);
    init_whole(&out->paths, &out->whole);
    out->whole.lens = true;
    init_through_lens(&out->paths, &out->whole, &out->through_lens);
    if (parts->plan->lens_relight != LENS_RELIGHT_OWN && out->lens)
        out->through_lens.centres = centres;
}
