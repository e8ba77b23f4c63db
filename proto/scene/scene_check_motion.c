/* Checks of what moves while the shutter is open. */
#include "proto/scene/scene_internal.h"

static int check_count(const struct scene *s, uint32_t section, uint64_t whole, struct fault *fault)
{
    const uint64_t count = s->count[section];
    if (count == whole) return 0;
    return fault_set(fault, ERR_MISMATCH, scene_section_name(section), "%llu, where %llu belong",
                     (unsigned long long)count, (unsigned long long)whole);
}

static bool is_shared(const struct scene *s, uint64_t instance)
{
    const uint32_t mesh = s->instances[instance].mesh;
    return (instance > 0 && s->instances[instance - 1].mesh == mesh) ||
           (instance + 1 < s->count[SCENE_INSTANCES] && s->instances[instance + 1].mesh == mesh);
}

/* What stands in a base is built there once, and moves in no frame. */
static int check_mover(const struct scene_record *at, const struct scene_mover *m)
{
    const struct scene *s = at->scene;
    int error = record_index(at, "instance", m->instance, SCENE_INSTANCES);
    if (!error) error = record_value(at, "bends", m->bends, 1);
    if (error) return error;
    if (!s->base || m->instance < s->base->count[SCENE_INSTANCES])
        return record_refuse(at, "instance", ERR_MISMATCH, m->instance, "stands in all frames");
    if (at->index > 0 && m->instance <= s->movers[at->index - 1].instance)
        return record_refuse(at, "instance", ERR_RANGE, m->instance, "is out of order");
    const struct scene_instance *instance = &s->instances[m->instance];
    if (m->bends && (s->meshes[instance->mesh].flags & MESH_IN_BASE ||
                     !(instance->flags & INSTANCE_IDENTITY) || is_shared(s, m->instance)))
        return record_refuse(at, "bends", ERR_MISMATCH, m->bends, "of a mesh of several places");
    if (!m->bends && !(s->meshes[instance->mesh].flags & MESH_IN_BASE))
        return record_refuse(at, "bends", ERR_MISMATCH, m->bends, "of a mesh that no base has");
    return 0;
}

static int check_step(const struct scene_record *at, const struct scene_step *step)
{
    const struct scene *s = at->scene;
    const struct scene_mover *mover = &s->movers[at->index / SHUTTER_STEPS];
    const struct scene_mesh *mesh = &s->meshes[s->instances[mover->instance].mesh];
    const uint32_t vertices = mover->bends ? mesh->vertex_count : 0;
    const float far = LIMIT_COORDINATE;
    if (!mover->bends && (step->first_vertex != 0 || step->first_normal != 0))
        return record_refuse(at, "first_vertex", ERR_RANGE, step->first_vertex,
                             "of what bends not");
    int error = record_range(at, "first_vertex", step->first_vertex, vertices, SCENE_POSITIONS);
    if (!error)
        error = record_range(at, "first_normal", step->first_normal,
                             mesh->flags & MESH_HAS_NORMALS ? vertices : 0, SCENE_NORMALS);
    if (!error) error = record_numbers(at, "to_world", step->to_world, 12, -far, far);
    if (!error && !scene_is_invertible(step->to_world))
        error = record_refuse(at, "to_world", ERR_RANGE, (double)step->to_world[0],
                              "begins a matrix that has no inverse");
    return error;
}

int scene_check_motion(const struct scene *s, struct fault *fault)
{
    const uint64_t movers = s->count[SCENE_MOVERS], poses = s->count[SCENE_POSES];
    int error = check_count(s, SCENE_STEPS, movers * SHUTTER_STEPS, fault);
    if (!error && poses > 0)
        error = check_count(s, SCENE_POSES, s->count[SCENE_CAMERAS] * SHUTTER_STEPS, fault);
    for (uint64_t i = 0; i < movers && !error; i++)
        error = check_mover(&(struct scene_record){s, SCENE_MOVERS, i, fault}, &s->movers[i]);
    for (uint64_t i = 0; i < movers * SHUTTER_STEPS && !error; i++)
        error = check_step(&(struct scene_record){s, SCENE_STEPS, i, fault}, &s->steps[i]);
    for (uint64_t i = 0; i < poses && !error; i++)
        error = scene_check_camera(&(struct scene_record){s, SCENE_POSES, i, fault}, &s->poses[i]);
    for (uint64_t i = 0; i < poses && !error; i++)
        if (s->poses[i].type != s->cameras[i / SHUTTER_STEPS].type)
            error = fault_set(fault, ERR_MISMATCH, "poses", "pose %llu has another projection",
                              (unsigned long long)i);
    return error;
}
