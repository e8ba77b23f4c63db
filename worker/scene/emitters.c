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

/* Shapes of more triangles are not kept, but found again for each sample. */
#define SHAPES_KEPT (1u << 22)

struct emitter_triangle {
    uint32_t instance, triangle;
};

/* What emitters know of an instance of the scene. */
struct emitter_instance {
    double luminance;
    uint64_t first; /* of its triangles' leaves */
};

struct emitters {
    const struct render_scene *scene; /* borrowed */
    uint32_t count;
    struct emitter_triangle *triangles; /* owned; leaf by leaf */
    struct emitter_shape *shapes;       /* owned; of these, or NULL */
    struct alias_cell *cells;           /* owned; one a triangle */
    struct emitter_instance *instances; /* owned */
    uint32_t *leaf;                     /* owned; of all triangles of instances that shine */
    struct emitter_tree tree;
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
                           struct emitter_shape *out)
{
    const struct mesh_view *mesh = mesh_of(s, instance);
    const uint32_t *corner = mesh->triangles + (size_t)3 * triangle;
    out->magnitude = 0.0f;
    for (int i = 0; i < 3; i++)
        place_corner(&s->blob->instances[instance], mesh->positions + (size_t)3 * corner[i],
                     out->corner[i], &out->magnitude);
}

/* Computes the normal of the winding times twice the area, in double, since squares of floats may
 * overflow a float. */
static void cross_edges(const struct emitter_shape *s, double out[3])
{
    double a[3], b[3];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)s->corner[1][k] - (double)s->corner[0][k];
        b[k] = (double)s->corner[2][k] - (double)s->corner[0][k];
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
    double normal[3];
    place_triangle(e->scene, instance, triangle, out);
    cross_edges(out, normal);
    const double area = 0.5 * length(normal);
    if (!(area >= AREA_MIN)) return false;
    const double scale = mirrors(&e->scene->blob->instances[instance]) ? -0.5 / area : 0.5 / area;
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

static double power_at(const void *shapes, uint32_t i)
{
    return ((const struct emitter_shape *)shapes)[i].power;
}

/* Puts the triangles in the tree's order and builds a table for each leaf. */
static void fill_leaves(struct emitters *e, const struct emitter_triangle *triangles,
                        const struct emitter_shape *shapes, const uint32_t *order)
{
    for (uint32_t k = 0; k < e->tree.leaf_count; k++) {
        const struct emitter_leaf *leaf = &e->tree.leaves[k];
        for (uint32_t i = leaf->first; i < leaf->first + leaf->count; i++) {
            const struct emitter_triangle *t = &triangles[order[i]];
            e->triangles[i] = *t;
            e->leaf[e->instances[t->instance].first + t->triangle] = k;
        }
        alias_build(power_at, shapes + leaf->first, leaf->count, leaf->power,
                    e->cells + leaf->first);
    }
}

/* Lists the triangles, builds their tree and the tables. e->count stays 0 if no triangle has an
 * area. */
static int fill(struct emitters *e, uint64_t most)
{
    struct emitter_triangle *triangles = malloc(most * sizeof *triangles);
    struct emitter_shape *shapes = malloc(most * sizeof *shapes);
    uint32_t *order = malloc(most * sizeof *order);
    e->leaf = calloc(most, sizeof *e->leaf);
    int rc = ERR_MEMORY;
    if (!triangles || !shapes || !order || !e->leaf) goto done;
    list_triangles(e, triangles, shapes);
    rc = 0;
    if (e->count == 0) goto done;
    e->triangles = malloc(e->count * sizeof *e->triangles);
    e->cells = malloc(e->count * sizeof *e->cells);
    rc = e->triangles && e->cells ? emitter_tree_init(&e->tree, shapes, e->count, order)
                                  : ERR_MEMORY;
    if (rc == 0) fill_leaves(e, triangles, shapes, order);
    if (rc == 0 && e->count <= SHAPES_KEPT) e->shapes = shapes;
done:
    free(order);
    if (!e->shapes) free(shapes);
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
    free(e->shapes);
    free(e->cells);
    free(e->instances);
    free(e->leaf);
    emitter_tree_fini(&e->tree);
    free(e);
    *emitters = NULL;
}

const struct emitter_tree *emitters_tree(const struct emitters *e)
{
    return e ? &e->tree : NULL;
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
    const struct material *m = mesh->material;
    if (!m->emission_texture.texels && m->alpha_cutoff == 0.0f) {
        memcpy(radiance, m->emission, sizeof m->emission);
        return;
    }
    const struct mesh_point point = mesh_point_at(mesh, triangle, u, v);
    struct material_uv uv;
    mesh_uv(&point, &uv);
    material_emission(m, &uv, radiance);
    float opacity = material_opacity(m, &uv);
    for (int i = 0; i < 3; i++) radiance[i] *= opacity;
}

float emitters_density(const struct emitters *e, uint32_t instance, uint32_t leaf)
{
    return (float)(e->instances[instance].luminance / e->tree.leaves[leaf].power);
}

uint32_t emitters_choose(const struct emitters *e, uint32_t leaf, float choice, const float u[2])
{
    const uint32_t first = e->tree.leaves[leaf].first, count = e->tree.leaves[leaf].count;
    const uint32_t chosen = first + alias_choose(e->cells + first, count, alias_refine(choice, u));
    __builtin_prefetch(&e->triangles[chosen]);
    if (e->shapes) __builtin_prefetch(&e->shapes[chosen]);
    return chosen;
}

void emitters_sample(const struct emitters *e, uint32_t leaf, uint32_t chosen, const float u[2],
                     struct emitter_point *out)
{
    const struct emitter_triangle *triangle = &e->triangles[chosen];
    const struct mesh_view *mesh = mesh_of(e->scene, triangle->instance);
    struct emitter_shape s;
    float a, b;
    if (e->shapes)
        s = e->shapes[chosen];
    else
        shape_of(e, triangle->instance, triangle->triangle, &s); /* it has an area */
    square_to_triangle(u, &a, &b);
    for (int k = 0; k < 3; k++)
        out->position[k] =
            (1.0f - a - b) * s.corner[0][k] + a * s.corner[1][k] + b * s.corner[2][k];
    memcpy(out->normal, s.normal, sizeof out->normal);
    emit(mesh, triangle->triangle, a, b, out->radiance);
    out->offset = offset_distance(s.magnitude);
    out->instance = triangle->instance;
    out->double_sided = mesh->material->double_sided;
    out->pdf_area = emitters_density(e, triangle->instance, leaf);
}

bool emitters_find(const struct emitters *e, uint32_t instance, uint32_t triangle, uint32_t *leaf)
{
    *leaf = 0;
    if (!e || !(e->instances[instance].luminance > 0.0)) return false;
    *leaf = e->leaf[e->instances[instance].first + triangle];
    return true;
}
