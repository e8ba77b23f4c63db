#include "server/import/scene/emitters.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "proto/plan.h"
#include "server/import/scene/transform.h"

/* Cosine of an angle that counts as right, and relative distance of points that count as one. */
#define RIGHT_ANGLE 1e-3
#define SAME_POINT  1e-3

struct corners {
    double p[3][3];
};

static struct corners corners_of(const float *positions, const uint32_t *triangle)
{
    struct corners c;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            c.p[k][i] = (double)positions[3 * (size_t)triangle[k] + (size_t)i];
    return c;
}

static void subtract(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[i] - b[i];
}

static double length3(const double v[3])
{
    return sqrt(dot3(v, v));
}

/* Finds the corner with the right angle; the edges from it run to the next two corners. */
static bool right_corner(const struct corners *t, int *corner, double u[3], double v[3])
{
    for (int k = 0; k < 3; k++) {
        subtract(t->p[(k + 1) % 3], t->p[k], u);
        subtract(t->p[(k + 2) % 3], t->p[k], v);
        double sides = length3(u) * length3(v);
        if (!(sides > 0) || fabs(dot3(u, v)) > RIGHT_ANGLE * sides) continue;
        *corner = k;
        return true;
    }
    return false;
}

static bool close_by(const double a[3], const double b[3], double scale)
{
    double d[3];
    subtract(a, b, d);
    return length3(d) <= SAME_POINT * scale;
}

/* True when `other` is the second half of the rectangle that corner k of t spans with u and v: it
 * has the corners q + r - p, r, q in this turn, so that both halves face the same way. */
static bool completes(const struct corners *t, int k, const double u[3], const double v[3],
                      const struct corners *other)
{
    double far_corner[3];
    double scale = fmin(length3(u), length3(v));
    for (int i = 0; i < 3; i++) far_corner[i] = t->p[k][i] + u[i] + v[i];
    for (int j = 0; j < 3; j++) {
        if (close_by(other->p[j], far_corner, scale) &&
            close_by(other->p[(j + 1) % 3], t->p[(k + 2) % 3], scale) &&
            close_by(other->p[(j + 2) % 3], t->p[(k + 1) % 3], scale))
            return true;
    }
    return false;
}

static void set_rectangle(const double corner[3], const double u[3], const double v[3],
                          struct rectangle *out)
{
    for (int i = 0; i < 3; i++) {
        out->half_u[i] = u[i] / 2;
        out->half_v[i] = v[i] / 2;
        out->centre[i] = corner[i] + out->half_u[i] + out->half_v[i];
    }
}

uint32_t emitters_pair(const float *positions, const uint32_t *triangles, uint32_t triangle_count,
                       struct rectangle out[EMITTER_RECTANGLES])
{
    bool paired[2 * EMITTER_RECTANGLES] = {false};
    uint32_t count = 0;
    if (triangle_count > 2 * EMITTER_RECTANGLES || triangle_count % 2 != 0) return 0;
    for (uint32_t a = 0; a < triangle_count; a++) {
        if (paired[a]) continue;
        struct corners t = corners_of(positions, triangles + 3 * a);
        int corner;
        double u[3], v[3];
        if (!right_corner(&t, &corner, u, v)) return 0;
        uint32_t b = a + 1;
        for (; b < triangle_count; b++) {
            if (paired[b]) continue;
            struct corners other = corners_of(positions, triangles + 3 * b);
            if (completes(&t, corner, u, v, &other)) break;
        }
        if (b == triangle_count) return 0;
        paired[b] = true;
        set_rectangle(t.p[corner], u, v, &out[count++]);
    }
    return count;
}

/* The front of a rectangle as a light; `back` turns it over. False when it has no area. */
static bool make_light(const struct rectangle *r, bool back, struct scene_light *out)
{
    const double *u = back ? r->half_v : r->half_u, *v = back ? r->half_u : r->half_v;
    double direction[3];
    cross3(u, v, direction);
    if (!normalize3(direction)) return false;
    out->type = LIGHT_RECTANGLE;
    out->profile = PROFILE_UNIFORM;
    out->cos_inner = 1;
    for (int i = 0; i < 3; i++) {
        out->position[i] = (float)r->centre[i];
        out->half_u[i] = (float)u[i];
        out->half_v[i] = (float)v[i];
        out->direction[i] = (float)direction[i];
    }
    return true;
}

/* Pairs a mesh as instance `i` places it in the world. */
static uint32_t pair_instance(const struct builder *b, uint64_t i,
                              struct rectangle out[EMITTER_RECTANGLES])
{
    const struct scene_instance *instance = &builder_instances(b)[i];
    const struct scene_mesh *mesh = &builder_meshes(b)[instance->mesh];
    const struct builder *home = builder_home(b, mesh);
    const uint32_t *triangles = builder_triangles(home) + 3 * (size_t)mesh->first_triangle;
    const float *positions = builder_positions(home) + 3 * (size_t)mesh->first_vertex;
    float placed[3 * 6 * EMITTER_RECTANGLES];
    uint32_t renamed[6 * EMITTER_RECTANGLES];
    struct affine to_world;
    if (mesh->triangle_count > 2 * EMITTER_RECTANGLES) return 0;
    for (int k = 0; k < 12; k++) to_world.m[k] = (double)instance->to_world[k];
    for (uint32_t k = 0; k < 3 * mesh->triangle_count; k++) {
        affine_point(&to_world, positions + 3 * (size_t)triangles[k], placed + 3 * k);
        renamed[k] = k;
    }
    return emitters_pair(placed, renamed, mesh->triangle_count, out);
}

static bool emits(const struct scene_material *m)
{
    return m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0;
}

/* Instances first..end place one mesh. Returns how many lights it needs, 0 when it cannot be one;
 * *why tells then. */
static uint64_t count_lights(const struct builder *b, uint64_t first, uint64_t end,
                             const struct scene_material *m, const char **why)
{
    uint64_t rectangles = 0;
    struct rectangle list[EMITTER_RECTANGLES];
    *why = "it is not made of few rectangles";
    if (m->emission_texture.texture != SCENE_NONE) *why = "its emission is textured";
    if (m->alpha_mode != ALPHA_OPAQUE) *why = "it has transparent parts";
    if (m->emission_texture.texture != SCENE_NONE || m->alpha_mode != ALPHA_OPAQUE) return 0;
    for (uint64_t i = first; i < end && rectangles <= LIMIT_LIGHTS; i++) {
        uint32_t count = pair_instance(b, i, list);
        if (count == 0) return 0;
        for (uint32_t k = 0; k < count; k++) {
            struct scene_light light;
            if (!make_light(&list[k], false, &light)) return 0;
        }
        rectangles += count;
    }
    uint64_t lights = rectangles * (m->flags & MATERIAL_DOUBLE_SIDED ? 2 : 1);
    if (lights <= LIMIT_LIGHTS - builder_count(b, SCENE_LIGHTS)) return lights;
    *why = "the scene has too many lights";
    return 0;
}

static int append_lights(struct builder *b, uint64_t first, uint64_t end,
                         const struct scene_material *m, struct fault *fault)
{
    struct rectangle list[EMITTER_RECTANGLES];
    int sides = m->flags & MATERIAL_DOUBLE_SIDED ? 2 : 1;
    for (uint64_t i = first; i < end; i++) {
        uint32_t count = pair_instance(b, i, list);
        for (uint32_t k = 0; k < count; k++) {
            for (int side = 0; side < sides; side++) {
                void *at;
                int rc = builder_append(b, SCENE_LIGHTS, 1, &at, fault);
                if (rc != 0) return rc;
                struct scene_light *light = at;
                make_light(&list[k], side == 1, light);
                memcpy(light->color, m->emission, sizeof light->color);
                light->instance = (uint32_t)i;
                light->name = builder_instances(b)[i].name;
            }
        }
    }
    return 0;
}

/* A lamp that is not in the photograph is no light of the scene that the photograph shows: paths
 * sample it where it is there. */
static bool has_virtual(const struct builder *b, uint64_t first, uint64_t end)
{
    bool found = false;
    for (uint64_t i = first; i < end; i++)
        found |= !(builder_instances(b)[i].flags & (INSTANCE_CATCHER | INSTANCE_HOLDOUT));
    return b->is_composite && found;
}

static int find_in_mesh(struct builder *b, uint64_t first, uint64_t end, struct fault *fault)
{
    struct scene_mesh *mesh = &builder_meshes(b)[builder_instances(b)[first].mesh];
    const struct scene_material *m = &builder_materials(b)[mesh->material];
    const char *why;
    if (!emits(m) || has_virtual(b, first, end)) return 0;
    if (count_lights(b, first, end, m, &why) > 0) {
        mesh->flags |= MESH_IS_LIGHT;
        return append_lights(b, first, end, m, fault);
    }
    char place[LIMIT_POINTER_BYTES];
    const char *names = (const char *)b->sections[SCENE_NAMES].data;
    snprintf(place, sizeof place, "mesh %" PRIu32 " (%.180s)", builder_instances(b)[first].mesh,
             names + m->name);
    warnings_add(&b->warnings, place,
                 "the emissive mesh is no light, since %s: only paths sample what it emits", why);
    return 0;
}

int emitters_find(struct builder *b, struct fault *fault)
{
    uint64_t count = builder_count(b, SCENE_INSTANCES);
    int rc = 0;
    for (uint64_t first = 0, end; rc == 0 && first < count; first = end) {
        uint32_t mesh = builder_instances(b)[first].mesh;
        for (end = first; end < count && builder_instances(b)[end].mesh == mesh;) end++;
        rc = find_in_mesh(b, first, end, fault);
    }
    return rc;
}
