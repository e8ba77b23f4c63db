#include "worker/scene/emitters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "worker/scene/alias_table.h"
#include "worker/scene/mesh.h"
#include "worker/scene/offset.h"

/* Triangles below this area, in scene units squared, are left out, since their density would
 * overflow a float. */
#define AREA_MIN 1e-30

struct emitter_triangle {
    uint32_t instance, triangle;
};

/* What emitters know of an instance of the scene. */
struct emitter_instance {
    double luminance;
    uint64_t first; /* of its triangles' groups */
};

struct emitters {
    const struct render_scene *scene; /* borrowed */
    uint32_t count;
    struct emitter_triangle *triangles; /* owned; group by group */
    struct alias_cell *cells;           /* owned; one a triangle */
    struct emitter_instance *instances; /* owned */
    uint8_t *group;                     /* owned; of all triangles of instances that shine */
    struct emitter_groups groups;
};

/* A triangle in the world. */
struct corners {
    float at[3][3];
    float magnitude; /* of the coordinates that went into it: offset.h */
};

static const struct mesh_view *mesh_of(const struct render_scene *s, uint32_t instance)
{
    return &s->meshes[s->blob->instances[instance].mesh];
}

static void place_corner(const struct scene_instance *instance, const float p[3], float out[3],
                         float *magnitude)
{
    for (size_t k = 0; k < 3; k++) {
        const float *row = instance->to_world + 4 * k;
        bool identity = instance->flags & INSTANCE_IDENTITY;
        out[k] = identity ? p[k] : row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        float sum = identity ? fabsf(p[k])
                             : fabsf(row[0] * p[0]) + fabsf(row[1] * p[1]) + fabsf(row[2] * p[2]) +
                                   fabsf(row[3]);
        *magnitude = sum > *magnitude ? sum : *magnitude;
    }
}

static void place_triangle(const struct render_scene *s, uint32_t instance, uint32_t triangle,
                           struct corners *out)
{
    const struct mesh_view *mesh = mesh_of(s, instance);
    const uint32_t *corner = mesh->triangles + (size_t)3 * triangle;
    out->magnitude = 0.0f;
    for (int i = 0; i < 3; i++)
        place_corner(&s->blob->instances[instance], mesh->positions + (size_t)3 * corner[i],
                     out->at[i], &out->magnitude);
}

/* Computes the normal of the winding times twice the area, in double, since squares of floats may
 * overflow a float. */
static void cross_edges(const struct corners *c, double out[3])
{
    double a[3], b[3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)c->at[1][k] - (double)c->at[0][k];
        b[k] = (double)c->at[2][k] - (double)c->at[0][k];
    }
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Returns the mean luminance that an instance emits: 0 if a light stands for it or it is unlit. */
static double luminance_of(const struct render_scene *s, uint32_t instance)
{
    const struct mesh_view *mesh = mesh_of(s, instance);
    float mean[3];
    if (!mesh->material->emissive || mesh->material->unlit || mesh->flags & MESH_IS_LIGHT)
        return 0.0;
    material_mean_emission(mesh->material, mean);
    return 0.2126 * (double)mean[0] + 0.7152 * (double)mean[1] + 0.0722 * (double)mean[2];
}

/* Measures each instance. Returns the number of triangles of those that shine. */
static uint64_t measure(const struct render_scene *s, struct emitter_instance *instances)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < s->blob->count[SCENE_INSTANCES]; i++) {
        instances[i].luminance = luminance_of(s, i);
        instances[i].first = triangles;
        if (instances[i].luminance > 0.0) triangles += mesh_of(s, i)->triangle_count;
    }
    return triangles;
}

/* Returns whether the instance's transform mirrors. The winding is then turned over, but not the
 * front. */
static bool mirrors(const struct scene_instance *instance)
{
    const float *m = instance->to_world;
    double d[3] = {(double)m[5] * (double)m[10] - (double)m[6] * (double)m[9],
                   (double)m[6] * (double)m[8] - (double)m[4] * (double)m[10],
                   (double)m[4] * (double)m[9] - (double)m[5] * (double)m[8]};
    return (double)m[0] * d[0] + (double)m[1] * d[1] + (double)m[2] * d[2] < 0.0;
}

/* Computes the shape of a triangle. Returns false if it has hardly any area. */
static bool shape_of(const struct emitters *e, uint32_t instance, uint32_t triangle,
                     struct emitter_shape *out)
{
    struct corners corners;
    double normal[3];
    place_triangle(e->scene, instance, triangle, &corners);
    cross_edges(&corners, normal);
    const double area = 0.5 * length(normal);
    if (!(area >= AREA_MIN)) return false;
    const double scale = mirrors(&e->scene->blob->instances[instance]) ? -0.5 / area : 0.5 / area;
    memcpy(out->corner, corners.at, sizeof out->corner);
    for (int k = 0; k < 3; k++) out->normal[k] = (float)(normal[k] * scale);
    out->power = area * e->instances[instance].luminance;
    out->both_sides = mesh_of(e->scene, instance)->material->double_sided;
    return true;
}

/* Lists the triangles that are not degenerate. */
static void list_triangles(struct emitters *e, struct emitter_triangle *triangles,
                           struct emitter_shape *shapes)
{
    for (uint32_t i = 0; i < e->scene->blob->count[SCENE_INSTANCES]; i++) {
        if (!(e->instances[i].luminance > 0.0)) continue;
        for (uint32_t t = 0; t < mesh_of(e->scene, i)->triangle_count; t++)
            if (shape_of(e, i, t, &shapes[e->count]))
                triangles[e->count++] = (struct emitter_triangle){i, t};
    }
}

struct ordered {
    const struct emitter_shape *shapes;
    const uint32_t *order;
};

static double power_at(const void *ordered, uint32_t i)
{
    const struct ordered *o = ordered;
    return o->shapes[o->order[i]].power;
}

/* Puts the triangles in the groups' order and builds a table for each. */
static void fill_groups(struct emitters *e, const struct emitter_triangle *triangles,
                        const struct emitter_shape *shapes, const uint32_t *order)
{
    for (uint32_t g = 0; g < e->groups.count; g++) {
        const uint32_t first = e->groups.first[g], count = e->groups.first[g + 1] - first;
        const struct ordered of = {shapes, order + first};
        double sum = 0.0;
        for (uint32_t i = 0; i < count; i++) {
            const struct emitter_triangle *t = &triangles[order[first + i]];
            e->triangles[first + i] = *t;
            e->group[e->instances[t->instance].first + t->triangle] = (uint8_t)g;
            sum += power_at(&of, i);
        }
        alias_build(power_at, &of, count, sum, e->cells + first);
    }
}

/* Lists the triangles, groups them and builds the tables. e->count stays 0 if no triangle has an
 * area. */
static int fill(struct emitters *e, uint64_t most)
{
    struct emitter_triangle *triangles = malloc(most * sizeof *triangles);
    struct emitter_shape *shapes = malloc(most * sizeof *shapes);
    uint32_t *order = malloc(most * sizeof *order);
    e->group = calloc(most, sizeof *e->group);
    int rc = ERR_MEMORY;
    if (!triangles || !shapes || !order || !e->group) goto done;
    list_triangles(e, triangles, shapes);
    rc = 0;
    if (e->count == 0) goto done;
    e->triangles = malloc(e->count * sizeof *e->triangles);
    e->cells = malloc(e->count * sizeof *e->cells);
    rc = e->triangles && e->cells ? emitter_groups_find(shapes, e->count, order, &e->groups)
                                  : ERR_MEMORY;
    if (rc == 0) fill_groups(e, triangles, shapes, order);
done:
    free(order);
    free(shapes);
    free(triangles);
    return rc;
}

int emitters_create(const struct render_scene *scene, struct emitters **out)
{
    size_t instances = (size_t)scene->blob->count[SCENE_INSTANCES];
    struct emitters *e = calloc(1, sizeof *e);
    *out = NULL;
    if (!e) return ERR_MEMORY;
    e->scene = scene;
    e->instances = calloc(instances + 1, sizeof *e->instances);
    int rc = ERR_MEMORY;
    if (!e->instances) goto done;
    uint64_t most = measure(scene, e->instances);
    rc = most > LIMIT_TRIANGLES ? ERR_LIMIT : 0;
    if (rc != 0 || most == 0) goto done;
    rc = fill(e, most);
    if (rc != 0 || e->count == 0) goto done;
    *out = e;
    e = NULL;
done:
    emitters_destroy(&e);
    return rc;
}

void emitters_destroy(struct emitters **emitters)
{
    struct emitters *e = *emitters;
    if (!e) return;
    free(e->triangles);
    free(e->cells);
    free(e->instances);
    free(e->group);
    free(e);
    *emitters = NULL;
}

const struct emitter_groups *emitters_groups(const struct emitters *e)
{
    return &e->groups;
}

/* Maps the unit square to barycentric coordinates by Heitz's map (2019, "A low-distortion map
 * between triangle and square"), which keeps strata in shape. */
static void square_to_triangle(const float square[2], float *u, float *v)
{
    *u = square[0];
    *v = square[1];
    if (*v > *u) {
        *u *= 0.5f;
        *v -= *u;
    } else {
        *v *= 0.5f;
        *u -= *v;
    }
}

/* Computes the radiance that leaves the point, times the surface's opacity. */
static void emit(const struct mesh_view *mesh, uint32_t triangle, float u, float v,
                 float radiance[3])
{
    const struct mesh_point point = mesh_point_at(mesh, triangle, u, v);
    struct material_uv uv;
    mesh_uv(&point, &uv);
    material_emission(mesh->material, &uv, radiance);
    float opacity = material_opacity(mesh->material, &uv);
    for (int i = 0; i < 3; i++) radiance[i] *= opacity;
}

/* Returns the density per area of an instance's points within a group. */
static float density_of(const struct emitters *e, uint32_t instance, uint32_t group)
{
    return (float)(e->instances[instance].luminance / e->groups.sum[group]);
}

void emitters_sample(const struct emitters *e, uint32_t group, float choice, const float u[2],
                     struct emitter_point *out)
{
    const uint32_t first = e->groups.first[group], count = e->groups.first[group + 1] - first;
    uint32_t cell = alias_choose(e->cells + first, count, alias_refine(choice, u));
    const struct emitter_triangle *chosen = &e->triangles[first + cell];
    const struct mesh_view *mesh = mesh_of(e->scene, chosen->instance);
    struct corners c;
    float a, b;
    double normal[3];
    place_triangle(e->scene, chosen->instance, chosen->triangle, &c);
    square_to_triangle(u, &a, &b);
    cross_edges(&c, normal);
    double scale = 1.0 / length(normal); /* listed triangles have an area */
    if (mirrors(&e->scene->blob->instances[chosen->instance])) scale = -scale;
    for (int k = 0; k < 3; k++) {
        out->position[k] = (1.0f - a - b) * c.at[0][k] + a * c.at[1][k] + b * c.at[2][k];
        out->normal[k] = (float)(normal[k] * scale);
    }
    emit(mesh, chosen->triangle, a, b, out->radiance);
    out->offset = offset_distance(c.magnitude);
    out->double_sided = mesh->material->double_sided;
    out->pdf_area = density_of(e, chosen->instance, group);
}

float emitters_pdf_area(const struct emitters *e, uint32_t instance, uint32_t triangle,
                        uint32_t *group)
{
    *group = 0;
    if (!e || !(e->instances[instance].luminance > 0.0)) return 0.0f;
    *group = e->group[e->instances[instance].first + triangle];
    return density_of(e, instance, *group);
}
