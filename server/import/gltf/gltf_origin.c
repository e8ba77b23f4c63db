/* Moves a scene that lies far away to its own middle, before anything is rounded to floats. */
#include <math.h>
#include <string.h>

#include "server/import/gltf/gltf.h"
#include "server/import/scene/origin.h"

/* A box that grows; hints only, so that what a file leaves out is passed over. */
struct box {
    double lowest[3], highest[3];
};

static void add_point(struct box *box, const struct affine *to_world, const double p[3])
{
    double at[3];
    affine_direction(to_world, p, at);
    for (int i = 0; i < 3; i++) {
        at[i] += to_world->m[4 * i + 3];
        box->lowest[i] = fmin(box->lowest[i], at[i]);
        box->highest[i] = fmax(box->highest[i], at[i]);
    }
}

/* Reads an accessor's min or max. */
static bool read_bound(const json_t *accessor, const char *key, double out[3])
{
    const json_t *bound = json_object_get(accessor, key);
    for (size_t i = 0; i < 3; i++) {
        out[i] = json_number_value(json_array_get(bound, i));
        if (!(fabs(out[i]) <= (double)LIMIT_COORDINATE)) return false;
    }
    return json_array_size(bound) == 3;
}

static void add_primitive(struct box *box, const struct gltf *g, const json_t *primitive,
                          const struct affine *to_world)
{
    double bounds[2][3];
    const json_t *position = json_object_get(json_object_get(primitive, "attributes"), "POSITION");
    const json_t *accessor = NULL;
    if (json_is_integer(position) && json_integer_value(position) >= 0)
        accessor = json_array_get(json_object_get(g->root, "accessors"),
                                  (size_t)json_integer_value(position));
    if (!read_bound(accessor, "min", bounds[0]) || !read_bound(accessor, "max", bounds[1])) return;
    for (unsigned corner = 0; corner < 8; corner++)
        add_point(box, to_world,
                  (double[3]){bounds[corner & 1][0], bounds[corner >> 1 & 1][1],
                              bounds[corner >> 2 & 1][2]});
}

static void add_mesh(struct box *box, const struct gltf *g, const struct gltf_node *node)
{
    size_t i;
    json_t *primitive;
    const json_t *mesh = json_array_get(json_object_get(g->root, "meshes"), node->mesh);
    json_array_foreach (json_object_get(mesh, "primitives"), i, primitive)
        add_primitive(box, g, primitive, &node->to_world);
}

static void add_joint(struct box *box, const struct affine *to_world, const struct affine *joint)
{
    add_point(box, to_world, (const double[3]){joint->m[3], joint->m[7], joint->m[11]});
}

/* A skin's vertices are somewhere about its joints. */
static void add_joints(struct box *box, const struct gltf *g, const struct gltf_node *of)
{
    size_t i;
    json_t *joint;
    const json_t *json = json_array_get(json_object_get(g->root, "skins"), of->skin);
    json_array_foreach (json_object_get(json, "joints"), i, joint) {
        const json_int_t node = json_is_integer(joint) ? json_integer_value(joint) : -1;
        if (node >= 0 && (size_t)node < gltf_count(g->root, "nodes") && g->nodes.visited[node])
            add_joint(box, &of->to_world, &g->nodes.world[node]);
    }
}

static void move(struct affine *to_world, const double origin[3])
{
    for (int i = 0; i < 3; i++) to_world->m[4 * i + 3] -= origin[i];
}

bool gltf_nodes_bounds(const struct gltf *g, uint32_t moved, double lowest[3], double highest[3])
{
    struct box box;
    for (int i = 0; i < 3; i++) box.lowest[i] = INFINITY, box.highest[i] = -INFINITY;
    for (uint32_t i = 0; i < g->nodes.count; i++) {
        const struct gltf_node *node = &g->nodes.list[i];
        if (node->mesh == SCENE_NONE || (moved != 0 && !(node->moved & moved))) continue;
        if (node->skin == SCENE_NONE)
            add_mesh(&box, g, node);
        else
            add_joints(&box, g, node);
    }
    memcpy(lowest, box.lowest, sizeof box.lowest);
    memcpy(highest, box.highest, sizeof box.highest);
    return box.lowest[0] <= box.highest[0];
}

void gltf_origin_choose(struct gltf *g)
{
    double lowest[3], highest[3];
    gltf_nodes_bounds(g, 0, lowest, highest);
    origin_choose(lowest, highest, g->builder->origin);
}

/* Vertices of skins are about the origin before they are placed. */
static void move_skin(struct affine *to_world, const double origin[3])
{
    double *m = to_world->m;
    for (int i = 0; i < 3; i++, m += 4)
        m[3] += m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2] - origin[i];
}

void gltf_origin_move(struct gltf *g)
{
    const double *origin = g->builder->origin;
    if (origin[0] == 0 && origin[1] == 0 && origin[2] == 0) return;
    for (uint32_t i = 0; i < g->nodes.count; i++) {
        struct gltf_node *node = &g->nodes.list[i];
        if (node->skin == SCENE_NONE)
            move(&node->to_world, origin);
        else
            move_skin(&node->to_world, origin);
    }
    for (size_t i = 0; g->nodes.world != NULL && i < gltf_count(g->root, "nodes"); i++)
        if (g->nodes.visited[i]) move(&g->nodes.world[i], origin);
}
