/* A plan of light fields: one primary ray a pixel and three beside it, strata over each light. */
#include <stdio.h>

#include "proto/json.h"
#include "proto/link/message.h"
#include "proto/samples.h"
#include "server/job/plan/plan_parts.h"

bool plan_has_layers(const struct scene_material *m, bool surely)
{
    const float *c = m->sheen_color;
    const struct {
        float amount;
        uint32_t texture;
    } layers[] = {{m->clearcoat, m->clearcoat_texture.texture},
                  {c[0] + c[1] + c[2], m->sheen_color_texture.texture},
                  {m->iridescence, m->iridescence_texture.texture},
                  {m->diffuse_transmission, m->diffuse_transmission_texture.texture}};
    for (size_t i = 0; i < sizeof layers / sizeof *layers; i++)
        if (layers[i].amount > 0 && !(surely && layers[i].texture != SCENE_NONE)) return true;
    return false;
}

/* An unlit surface reflects nothing: what else it says does not matter. */
static bool is_lambert(const struct scene_material *m)
{
    if (m->alpha_mode == ALPHA_BLEND) return false;
    if (m->flags & MATERIAL_UNLIT) return true;
    return m->model == MODEL_GLTF && !(m->metallic > 0) && !(m->specular > 0) &&
           !(m->transmission > 0) && !plan_has_layers(m, false);
}

static const struct scene_material *first_other(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const struct scene_material *m = &scene->materials[mesh->material];
        if (!is_lambert(m)) return m;
    }
    return NULL;
}

/* Names come from a file: what is printed of them is ASCII. */
static void say_material(const struct scene *scene, const struct scene_material *m,
                         char why[PLAN_WHY_BYTES])
{
    char name[56];
    json_printable(scene_name(scene, m->name), name, sizeof name);
    snprintf(why, PLAN_WHY_BYTES, "material %u \"%s\" %s", (unsigned)(m - scene->materials), name,
             m->alpha_mode == ALPHA_BLEND ? "lets light through by its alpha" : "is not Lambert");
}

/* Returns a surface that is transparent by its alpha. */
static const struct scene_material *first_blended(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const struct scene_material *m = &scene->materials[mesh->material];
        if (m->alpha_mode == ALPHA_BLEND) return m;
    }
    return NULL;
}

bool plan_has_bumps(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        if (scene->materials[mesh->material].normal_texture.texture != SCENE_NONE) return true;
    }
    return false;
}

bool plan_has_volumes(const struct scene *scene)
{
    for (uint64_t i = 0; i < scene->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        const struct scene_material *m = &scene->materials[mesh->material];
        if ((m->transmission > 0 || m->diffuse_transmission > 0) && m->thickness > 0) return true;
    }
    return false;
}

bool plan_light_field_possible(const struct job *job, const struct scene *scene,
                               char why[PLAN_WHY_BYTES])
{
    const struct scene_material *blended;
    if (job->pixel_filter != PIXEL_FILTER_BOX)
        snprintf(why, PLAN_WHY_BYTES, "image.pixel_filter is not box");
    else if ((blended = first_blended(scene)))
        say_material(scene, blended, why);
    else
        return true;
    return false;
}

/* Returns whether the error is wanted: for a layer, or for a target error. */
bool plan_wants_error(const struct job *job)
{
    return (job->layers & LAYER_ERROR) != 0 || job->target_error > 0.0f;
}

bool plan_has_rectangle(const struct plan *plan)
{
    bool any = false;
    for (uint32_t k = 0; k < plan->light_count; k++) any |= plan->lights[k].type == LIGHT_RECTANGLE;
    return any;
}

/* Returns whether a rectangle's light is left as it is: then halves of pixels tell no error of
 * it. */
static bool has_plain_rectangle(const struct job *job, const struct plan *plan)
{
    char why[PLAN_FILTER_WHY_BYTES];
    return plan_has_rectangle(plan) && plan_choose_filter(job, plan, why) == SHADOW_FILTER_NONE;
}

bool plan_light_field_covers(const struct job *job, const struct scene *scene,
                             const struct plan *plan, const struct plan_emitters *emitters,
                             char why[PLAN_WHY_BYTES])
{
    const struct scene_material *other;
    if (plan->environment.kind != ENVIRONMENT_NONE)
        snprintf(why, PLAN_WHY_BYTES, "there is an environment");
    else if (emitters->flux > 0)
        snprintf(why, PLAN_WHY_BYTES, "some meshes that emit light are not rectangles");
    else if ((other = first_other(scene)))
        say_material(scene, other, why);
    else if (job->target_error > 0.0f)
        snprintf(why, PLAN_WHY_BYTES, "sampling.target_error needs samples of whole pixels");
    else if (plan_wants_error(job) && has_plain_rectangle(job, plan))
        snprintf(why, PLAN_WHY_BYTES, "the error of area lights is known only along paths");
    else
        return true;
    return false;
}

static void plan_emission(struct plan *plan, struct plan_report *report)
{
    if (!report->emitters.any_seen) {
        plan_skip(report, "plane emission", "no material emits light");
        return;
    }
    plan->planes |= PLANE_BIT(EMISSION);
    report->effects |= EFFECT_EMISSION;
}

/* Returns whether there is a light without area. */
static bool has_sharp_light(const struct plan *plan)
{
    for (uint32_t k = 0; k < plan->light_count; k++)
        if (plan->lights[k].type != LIGHT_RECTANGLE) return true;
    return false;
}

void plan_direct(struct plan *plan, struct plan_report *report)
{
    if (plan->light_count == 0) {
        plan_skip(report, "effect direct", "there is no light");
        return;
    }
    report->effects |= EFFECT_DIRECT | EFFECT_SHADOWS;
    if (plan->shadow_filter == SHADOW_FILTER_NONE || has_sharp_light(plan))
        plan->light_planes |= 1u << LIGHT_PLANE_IRRADIANCE;
    else
        plan_skip(report, "plane irradiance", "the filter makes it from visibility and slopes");
    if (report->by_lobe && plan_has_rectangle(plan))
        plan->light_planes |= 1u << LIGHT_PLANE_DIFFUSE_WEIGHT;
    plan->capabilities |= CAPABILITY_DIRECT;
    plan_strata_planes(plan, report);
}

void plan_light_field(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan_surfaces(plan, report);
    plan_emission(plan, report);
    plan_filter(job, plan, report);
    plan_direct(plan, report);
}
