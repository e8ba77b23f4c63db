#include "server/import/shutter.h"

#include <string.h>

#include "server/import/sequence.h"

/* The frame at each step; the one in the middle is the frame's own. */
struct poses {
    const struct builder *at[SHUTTER_STEPS];
    struct builder others[SHUTTER_STEPS];
};

static int pose(const struct shutter_frame *f, uint32_t step, struct builder *out,
                struct fault *fault)
{
    const double share = (double)step / (SHUTTER_STEPS - 1) - 0.5;
    const double time_s = f->time_s + share * f->choice->shutter_s;
    int rc = builder_begin_frame(out, f->builder->base, f->base, fault);
    if (rc == 0) rc = gltf_read_frame(f->g, f->choice, time_s, out, fault);
    return rc == 0 ? scene_finish(out, f->choice, fault) : rc;
}

static bool is_same_part(const struct builder *a, const struct builder *b, uint64_t i)
{
    const struct scene_instance *x = &builder_instances(a)[i], *y = &builder_instances(b)[i];
    const struct scene_mesh *p = &builder_meshes(a)[x->mesh], *q = &builder_meshes(b)[y->mesh];
    return x->mesh == y->mesh && p->vertex_count == q->vertex_count &&
           p->triangle_count == q->triangle_count && p->flags == q->flags;
}

/* Returns whether all that is there at one time is there at another. */
static bool has_same_parts(const struct builder *a, const struct builder *b)
{
    static const enum scene_section sections[] = {SCENE_MESHES, SCENE_INSTANCES, SCENE_CAMERAS};
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
        if (builder_count(a, sections[i]) != builder_count(b, sections[i])) return false;
    for (uint64_t i = 0; i < builder_count(a, SCENE_INSTANCES); i++)
        if (!is_same_part(a, b, i)) return false;
    return true;
}

static bool shines(const struct builder *b, const struct scene_mesh *mesh)
{
    const struct scene_material *m = &builder_materials(b)[mesh->material];
    if (mesh->flags & MESH_IS_LIGHT) return true;
    return !(m->flags & MATERIAL_UNLIT) &&
           (m->emission[0] > 0.0f || m->emission[1] > 0.0f || m->emission[2] > 0.0f);
}

static const float *array_of(const struct builder *b, enum scene_section section, uint32_t first)
{
    return (const float *)b->sections[section].data + (size_t)3 * first;
}

static const struct scene_mesh *mesh_of(const struct builder *b, uint64_t instance)
{
    return &builder_meshes(b)[builder_instances(b)[instance].mesh];
}

static bool bends(const struct poses *p, uint64_t instance)
{
    const struct builder *own = p->at[SHUTTER_MIDDLE];
    const struct scene_mesh *mesh = mesh_of(own, instance);
    const float *positions = array_of(own, SCENE_POSITIONS, mesh->first_vertex);
    bool moved = false;
    for (uint32_t k = 0; k < SHUTTER_STEPS && !moved; k++) {
        const uint32_t first = mesh_of(p->at[k], instance)->first_vertex;
        moved = memcmp(positions, array_of(p->at[k], SCENE_POSITIONS, first),
                       (size_t)12 * mesh->vertex_count) != 0;
    }
    return moved;
}

static bool is_carried(const struct poses *p, uint64_t instance)
{
    const float *own = builder_instances(p->at[SHUTTER_MIDDLE])[instance].to_world;
    bool moved = false;
    for (uint32_t k = 0; k < SHUTTER_STEPS && !moved; k++)
        moved = memcmp(own, builder_instances(p->at[k])[instance].to_world, 48) != 0;
    return moved;
}

/* Copies the vectors of a mesh at one time; *first becomes their place in the frame. */
static int copy(const struct builder *from, enum scene_section section, uint32_t at, uint64_t count,
                struct builder *to, uint32_t *first, struct fault *fault)
{
    void *out;
    *first = (uint32_t)builder_count(to, section);
    int rc = builder_append(to, section, count, &out, fault);
    if (rc == 0 && count > 0) memcpy(out, array_of(from, section, at), 12 * (size_t)count);
    return rc;
}

static int bend_step(const struct builder *from, uint64_t instance, struct builder *to,
                     struct scene_step *step, struct fault *fault)
{
    const struct scene_mesh *mesh = mesh_of(from, instance);
    step->first_vertex = mesh->first_vertex;
    step->first_normal = mesh->first_normal;
    if (from == to) return 0;
    const uint64_t normals = mesh->flags & MESH_HAS_NORMALS ? mesh->vertex_count : 0;
    int rc = copy(from, SCENE_POSITIONS, mesh->first_vertex, mesh->vertex_count, to,
                  &step->first_vertex, fault);
    if (rc == 0)
        rc = copy(from, SCENE_NORMALS, mesh->first_normal, normals, to, &step->first_normal, fault);
    if (normals == 0) step->first_normal = 0;
    return rc;
}

static int add_mover(const struct poses *p, uint64_t instance, bool bent, struct builder *to,
                     struct fault *fault)
{
    void *mover, *at;
    int rc = builder_append(to, SCENE_MOVERS, 1, &mover, fault);
    if (rc == 0)
        *(struct scene_mover *)mover = (struct scene_mover){(uint32_t)instance, bent ? 1 : 0};
    if (rc == 0) rc = builder_append(to, SCENE_STEPS, SHUTTER_STEPS, &at, fault);
    struct scene_step *steps = at;
    for (uint32_t k = 0; k < SHUTTER_STEPS && rc == 0; k++) {
        memcpy(steps[k].to_world, builder_instances(p->at[k])[instance].to_world, 48);
        if (bent) rc = bend_step(p->at[k], instance, to, &steps[k], fault);
    }
    return rc;
}

static int add_movers(const struct poses *p, struct builder *to, struct fault *fault)
{
    int rc = 0;
    const uint64_t standing = builder_count(to->base, SCENE_INSTANCES);
    for (uint64_t i = standing; i < builder_count(to, SCENE_INSTANCES) && rc == 0; i++) {
        const struct scene_mesh *mesh = mesh_of(to, i);
        const bool bent = !(mesh->flags & MESH_IN_BASE) && bends(p, i);
        if (!shines(to, mesh) && (bent || is_carried(p, i))) rc = add_mover(p, i, bent, to, fault);
    }
    return rc;
}

static int add_poses(const struct poses *p, struct builder *to, struct fault *fault)
{
    const uint64_t cameras = builder_count(to, SCENE_CAMERAS);
    const size_t bytes = sizeof(struct scene_camera);
    bool moved = false;
    void *at;
    for (uint32_t k = 0; k < SHUTTER_STEPS; k++)
        moved |= memcmp(p->at[k]->sections[SCENE_CAMERAS].data, to->sections[SCENE_CAMERAS].data,
                        bytes * (size_t)cameras) != 0;
    if (!moved) return 0;
    int rc = builder_append(to, SCENE_POSES, cameras * SHUTTER_STEPS, &at, fault);
    struct scene_camera *out = at;
    for (uint64_t i = 0; i < cameras * SHUTTER_STEPS && rc == 0; i++) {
        const struct builder *from = p->at[i % SHUTTER_STEPS];
        const struct scene_camera *list = (const void *)from->sections[SCENE_CAMERAS].data;
        out[i] = list[i / SHUTTER_STEPS];
        out[i].name = 0;
    }
    return rc;
}

int shutter_add(const struct shutter_frame *f, struct fault *fault)
{
    static struct poses p; /* large, and there is one */
    bool same = true;
    int rc = 0;
    if (!(f->choice->shutter_s > 0)) return 0;
    p = (struct poses){0};
    for (uint32_t k = 0; k < SHUTTER_STEPS && rc == 0; k++) {
        p.at[k] = k == SHUTTER_MIDDLE ? f->builder : &p.others[k];
        if (k != SHUTTER_MIDDLE) rc = pose(f, k, &p.others[k], fault);
        if (rc == 0) same = same && has_same_parts(f->builder, p.at[k]);
    }
    if (rc == 0 && same) rc = add_movers(&p, f->builder, fault);
    if (rc == 0 && same) rc = add_poses(&p, f->builder, fault);
    for (uint32_t k = 0; k < SHUTTER_STEPS; k++) builder_fini(&p.others[k]);
    return rc;
}
