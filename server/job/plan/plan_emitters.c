/* Finds the meshes that shine besides the lights of the list, and their flux. */
#include <math.h>

#include "server/job/plan/plan_parts.h"

/* So many triangles of stretched instances are measured one by one, and the rest is estimated: a
 * file of a few bytes can place billions. */
#define MEASURED_MAX 100000000u

/* A similarity may have lengths with this relative difference, and axes with this cosine. */
#define SIMILAR 1e-4

/* The columns of an instance's matrix, which tell how it changes lengths. */
struct stretch {
    double column[3][3];
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double cross_length(const double a[3], const double b[3])
{
    double n[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = a[j] * b[k] - a[k] * b[j];
    }
    return sqrt(dot(n, n));
}

static struct stretch stretch_of(const struct scene_instance *instance)
{
    static const struct stretch identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    struct stretch s;
    if (instance->flags & INSTANCE_IDENTITY) return identity;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            s.column[column][row] = (double)instance->to_world[4 * row + column];
    return s;
}

/* Returns whether all areas grow by one factor. *factor is it, or else a mean over orientations. */
static bool is_similarity(const struct stretch *s, double *factor)
{
    double squared[3], most = 0, least = INFINITY, skew = 0;
    for (int i = 0; i < 3; i++) {
        squared[i] = dot(s->column[i], s->column[i]);
        most = fmax(most, squared[i]);
        least = fmin(least, squared[i]);
        skew = fmax(skew, fabs(dot(s->column[i], s->column[(i + 1) % 3])));
    }
    *factor = cbrt(squared[0] * squared[1] * squared[2]);
    return most - least <= 2 * SIMILAR * most && skew <= SIMILAR * most;
}

static double triangle_area(const struct scene *scene, const struct scene_mesh *mesh,
                            uint32_t triangle, const struct stretch *s)
{
    const uint32_t *corner = scene->triangles + 3 * ((size_t)mesh->first_triangle + triangle);
    const float *p[3];
    double edge[2][3] = {{0}};
    for (int c = 0; c < 3; c++)
        p[c] = scene->positions + 3 * ((size_t)mesh->first_vertex + corner[c]);
    for (int e = 0; e < 2; e++)
        for (int axis = 0; axis < 3; axis++) {
            double d = (double)p[e + 1][axis] - (double)p[0][axis];
            for (int i = 0; i < 3; i++) edge[e][i] += d * s->column[axis][i];
        }
    return cross_length(edge[0], edge[1]) / 2;
}

static double mesh_area(const struct scene *scene, const struct scene_mesh *mesh,
                        const struct stretch *s)
{
    double sum = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) sum += triangle_area(scene, mesh, t, s);
    return sum;
}

/* Returns the area in the world of instances first .. end - 1, which place one mesh. */
static double placed_area(const struct scene *scene, uint64_t first, uint64_t end,
                          uint64_t *measured)
{
    static const struct stretch identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[first].mesh];
    const struct scene *home = scene_mesh_home(scene, mesh);
    double sum = 0, own = mesh_area(home, mesh, &identity);
    for (uint64_t i = first; i < end; i++) {
        struct stretch s = stretch_of(&scene->instances[i]);
        double factor;
        bool similar = is_similarity(&s, &factor);
        if (!similar && *measured + mesh->triangle_count <= MEASURED_MAX) {
            *measured += mesh->triangle_count;
            sum += mesh_area(home, mesh, &s);
        } else {
            sum += own * factor;
        }
    }
    return sum;
}

static bool emits(const struct scene_material *m)
{
    return m->emission[0] > 0 || m->emission[1] > 0 || m->emission[2] > 0;
}

/* Adds instances first .. end - 1, which place one mesh. */
static void add_instances(const struct scene *scene, uint64_t first, uint64_t end,
                          uint64_t *measured, struct plan_emitters *out)
{
    const struct scene_mesh *mesh = &scene->meshes[scene->instances[first].mesh];
    const struct scene_material *m = &scene->materials[mesh->material];
    bool unlit = (m->flags & MATERIAL_UNLIT) != 0;
    out->any_seen = out->any_seen || unlit || emits(m);
    out->any_unlit = out->any_unlit || unlit;
    if (unlit || !emits(m) || (mesh->flags & MESH_IS_LIGHT)) return;
    double sides = m->flags & MATERIAL_DOUBLE_SIDED ? 2 : 1;
    out->instances += end - first;
    out->flux +=
        sides * M_PI * plan_luminance(m->emission) * placed_area(scene, first, end, measured);
}

void plan_find_emitters(const struct scene *scene, struct plan_emitters *out)
{
    uint64_t count = scene->count[SCENE_INSTANCES], measured = 0;
    *out = (struct plan_emitters){0};
    for (uint64_t first = 0, end; first < count; first = end) {
        uint32_t mesh = scene->instances[first].mesh;
        for (end = first; end < count && scene->instances[end].mesh == mesh;) end++;
        add_instances(scene, first, end, &measured, out);
    }
}
