/* A plan of light fields: one primary ray a pixel and three beside it, strata over each light, one
 * bounce. */
#include <stdio.h>

#include "proto/json.h"
#include "proto/message.h"
#include "proto/samples.h"
#include "server/job/plan.h"

#define PLANE_BIT(plane) (1u << PLANE_##plane)

#define LAYERS_OF_PATHS (LAYER_ERROR | LAYER_OCCLUSION)
#define BOUNCES_MOST    1

/* An unlit surface reflects nothing: what else it says does not matter. */
static bool is_lambert(const struct scene_material *m)
{
    if (m->alpha_mode == ALPHA_BLEND) return false;
    if (m->flags & MATERIAL_UNLIT) return true;
    return m->model == MODEL_GLTF && !(m->metallic > 0) && !(m->specular > 0) &&
           !(m->transmission > 0);
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

static uint32_t first_bit(uint32_t bits)
{
    return bits & (~bits + 1);
}

bool plan_light_field_covers(const struct job *job, const struct scene *scene,
                             const struct plan *plan, const struct plan_emitters *emitters,
                             char why[PLAN_WHY_BYTES])
{
    uint32_t other_layers = job->layers & LAYERS_OF_PATHS;
    const struct scene_material *other;
    if (plan->environment.kind != ENVIRONMENT_NONE)
        snprintf(why, PLAN_WHY_BYTES, "there is an environment");
    else if (plan->camera.aperture_radius > 0)
        snprintf(why, PLAN_WHY_BYTES, "there is a lens");
    else if (job->indirect_bounces > BOUNCES_MOST)
        snprintf(why, PLAN_WHY_BYTES, "effects.indirect_bounces is %u, above %d",
                 job->indirect_bounces, BOUNCES_MOST);
    else if (job->pixel_filter != PIXEL_FILTER_BOX)
        snprintf(why, PLAN_WHY_BYTES, "image.pixel_filter is not box");
    else if (other_layers)
        snprintf(why, PLAN_WHY_BYTES, "they do not give the layer %s",
                 layer_name((enum layer)first_bit(other_layers)));
    else if (emitters->flux > 0)
        snprintf(why, PLAN_WHY_BYTES, "meshes shine that are no rectangular lights");
    else if ((other = first_other(scene)))
        say_material(scene, other, why);
    else
        return true;
    return false;
}

static void plan_surfaces(bool emission, struct plan *plan, struct plan_report *report)
{
    plan->planes = PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) | PLANE_BIT(ALBEDO) | PLANE_BIT(ID) |
                   PLANE_BIT(SUB_DEPTH) | PLANE_BIT(SUB_NORMAL) | PLANE_BIT(SUB_ALBEDO) |
                   PLANE_BIT(SUB_ID);
    plan->sub_samples = LIMIT_SUB_SAMPLES;
    report->effects |= EFFECT_PRIMARY | EFFECT_ANTIALIAS;
    if (emission) {
        plan->planes |= PLANE_BIT(EMISSION);
        report->effects |= EFFECT_EMISSION;
    } else {
        plan_skip(report, "plane emission", "no material emits light");
    }
}

/* Whether there is a light without area. */
static bool has_sharp_light(const struct plan *plan)
{
    for (uint32_t k = 0; k < plan->light_count; k++)
        if (plan->lights[k].type != LIGHT_RECTANGLE) return true;
    return false;
}

static void plan_direct(struct plan *plan, struct plan_report *report)
{
    if (plan->light_count == 0) {
        plan_skip(report, "effect direct", "there is no light");
        return;
    }
    report->effects |= EFFECT_DIRECT | EFFECT_SHADOWS;
    if (plan->shadow_filter == SHADOW_FILTER_NONE || has_sharp_light(plan))
        plan->light_planes |= 1u << LIGHT_PLANE_IRRADIANCE;
    else
        plan_skip(report, "plane irradiance", "the filter makes it of visibility and slopes");
    plan->capabilities |= CAPABILITY_DIRECT;
    plan_strata_planes(plan, report);
}

static void plan_indirect(const struct job *job, bool lit, struct plan *plan,
                          struct plan_report *report)
{
    static const char why[] = "no filter of this plan reads it";
    if (job->indirect_bounces == 0 || !lit) {
        plan_skip(report, "effect indirect", "%s",
                  lit ? "effects.indirect_bounces is 0" : "nothing lights the scene");
        return;
    }
    plan->bounces = job->indirect_bounces;
    plan->indirect_strata_per_axis =
        job_strata_per_axis(job->indirect_spp ? job->indirect_spp : job->spp);
    plan->planes |= PLANE_BIT(INDIRECT_MEAN);
    plan->capabilities |= CAPABILITY_INDIRECT;
    report->effects |= EFFECT_INDIRECT;
    plan_skip(report, "plane indirect_halves", why);
    plan_skip(report, "plane reflector", why);
    plan_skip(report, "plane indirect_strata", why);
}

void plan_light_field(const struct job *job, struct plan *plan, struct plan_report *report)
{
    plan_surfaces(report->emitters.any_seen, plan, report);
    plan_filter(job, plan, report);
    plan_direct(plan, report);
    plan_indirect(job, plan->light_count > 0 || report->emitters.any_unlit, plan, report);
}
