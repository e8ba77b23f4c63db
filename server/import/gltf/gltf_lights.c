/* KHR_lights_punctual: candela are read as W/sr and lux as W/m^2. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/gltf/gltf.h"

static int read_type(const json_t *json, const char *place, uint32_t *out, struct fault *fault)
{
    const char *type;
    gltf_place at;
    int rc = gltf_text(json, place, "type", &type, fault);
    if (rc != 0) return rc;
    gltf_place_set(at, "%s.type", place);
    if (type == NULL) return fault_set(fault, ERR_MISSING, at, "a light has a type");
    if (strcmp(type, "point") == 0)
        *out = LIGHT_POINT;
    else if (strcmp(type, "spot") == 0)
        *out = LIGHT_SPOT;
    else if (strcmp(type, "directional") == 0)
        *out = LIGHT_DIRECTIONAL;
    else
        return fault_set(fault, ERR_RANGE, at, "\"%.40s\" is not point, spot or directional", type);
    return 0;
}

static int read_cone(const json_t *json, const char *place, struct scene_light *out,
                     struct fault *fault)
{
    const double right_angle = 1.5707963267948966;
    const json_t *spot;
    gltf_place at;
    double inner = 0, outer = right_angle / 2;
    gltf_place_set(at, "%s.spot", place);
    int rc = gltf_object(json, place, "spot", &spot, fault);
    if (rc == 0 && spot == NULL) rc = fault_set(fault, ERR_MISSING, at, "a spot has a cone");
    if (rc == 0) rc = gltf_number(spot, at, "innerConeAngle", 0, right_angle, &inner, fault);
    if (rc == 0)
        rc = gltf_number(spot, at, "outerConeAngle", 0, right_angle * 1.000001, &outer, fault);
    if (rc != 0) return rc;
    out->cos_inner = (float)cos(inner);
    out->cos_outer = (float)fmax(0, cos(outer));
    if (out->cos_inner > out->cos_outer) return 0;
    if (inner > outer)
        return fault_set(fault, ERR_RANGE, at, "innerConeAngle %g is not below outerConeAngle %g",
                         inner, outer);
    /* A hard edge: as narrow as a float can tell apart. */
    if (out->cos_outer > 0)
        out->cos_outer = nextafterf(out->cos_outer, 0);
    else
        out->cos_inner = nextafterf(out->cos_inner, 1);
    return 0;
}

static int read_color(const json_t *json, const char *place, struct scene_light *out,
                      struct fault *fault)
{
    double color[3] = {1, 1, 1}, intensity = 1, range = 0;
    int rc = gltf_vector(json, place, "color", 3, 0, 1, color, NULL, fault);
    if (rc == 0)
        rc = gltf_number(json, place, "intensity", 0, (double)LIMIT_RADIANCE, &intensity, fault);
    if (rc == 0) rc = gltf_number(json, place, "range", 0, (double)LIMIT_COORDINATE, &range, fault);
    for (int i = 0; i < 3; i++) out->color[i] = (float)(color[i] * intensity);
    if (out->type != LIGHT_DIRECTIONAL) out->range = (float)range;
    return rc;
}

/* The light shines along its node's -z. */
static void place_light(const struct affine *to_world, struct scene_light *out)
{
    double direction[3];
    affine_direction(to_world, (double[3]){0, 0, -1}, direction);
    if (!normalize3(direction)) memcpy(direction, (double[3]){0, 0, -1}, sizeof direction);
    for (int i = 0; i < 3; i++) {
        out->direction[i] = (float)direction[i];
        out->position[i] = (float)to_world->m[4 * i + 3];
    }
}

static int read_light(const json_t *json, const char *place, const struct affine *to_world,
                      struct scene_light *out, struct fault *fault)
{
    *out = (struct scene_light){.instance = SCENE_NONE, .cos_inner = 1};
    int rc = read_type(json, place, &out->type, fault);
    if (rc == 0) rc = read_color(json, place, out, fault);
    if (rc == 0 && out->type == LIGHT_SPOT) rc = read_cone(json, place, out, fault);
    place_light(to_world, out);
    return rc;
}

static int append_light(struct gltf *g, const struct gltf_node *node, const json_t *lights,
                        struct fault *fault)
{
    gltf_place place;
    struct scene_light light;
    const char *name;
    void *at;
    gltf_place_set(place, "extensions.KHR_lights_punctual.lights[%" PRIu32 "]", node->light);
    const json_t *json = json_array_get(lights, node->light);
    if (!json_is_object(json)) return fault_set(fault, ERR_TYPE, place, "it is not an object");
    int rc = read_light(json, place, &node->to_world, &light, fault);
    if (rc == 0) rc = gltf_text(json, place, "name", &name, fault);
    if (rc != 0) return rc;
    if (light.color[0] + light.color[1] + light.color[2] <= 0) return 0; /* it lights nothing */
    if (builder_count(g->builder, SCENE_LIGHTS) == LIMIT_LIGHTS) {
        warnings_add(&g->builder->warnings, place, "a scene has at most %d lights; it is left out",
                     LIMIT_LIGHTS);
        return 0;
    }
    rc = builder_name(g->builder, name, &light.name, fault);
    if (rc == 0) rc = builder_append(g->builder, SCENE_LIGHTS, 1, &at, fault);
    if (rc == 0) memcpy(at, &light, sizeof light);
    return rc;
}

int gltf_lights_read(struct gltf *g, struct fault *fault)
{
    const json_t *extension, *lights = NULL;
    gltf_place place;
    int rc = gltf_extension(g->root, "", "KHR_lights_punctual", &extension, place, fault);
    if (rc == 0) rc = gltf_array(extension, place, "lights", &lights, fault);
    for (uint32_t i = 0; rc == 0 && i < g->nodes.count; i++)
        if (g->nodes.list[i].light != SCENE_NONE)
            rc = append_light(g, &g->nodes.list[i], lights, fault);
    return rc;
}
