#include "server/import/scene/moves.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define RADIANS_PER_DEGREE 0.017453292519943295

bool moves_name_matches(const char *own, const char *name)
{
    char names[2][LIMIT_NAME_BYTES];
    if (own == NULL) return false;
    snprintf(names[0], sizeof names[0], "%s", own);
    snprintf(names[1], sizeof names[1], "%s", name);
    text_make_printable(names[0]);
    text_make_printable(names[1]);
    return strcmp(names[0], names[1]) == 0;
}

int moves_refuse_name(uint32_t move, const char *name, struct fault *fault)
{
    char place[64], printable[LIMIT_NAME_BYTES];
    snprintf(place, sizeof place, "/scene/moves/%u/node", move);
    snprintf(printable, sizeof printable, "%s", name);
    text_make_printable(printable);
    return fault_set(fault, ERR_NOT_FOUND, place, "the scene has no node \"%s\"", printable);
}

struct affine moves_transform(const struct job_move *move, const double middle[3])
{
    const double angle = (double)move->rotation_deg * RADIANS_PER_DEGREE;
    const double c = cos(angle), s = sin(angle);
    double to[3];
    for (int i = 0; i < 3; i++) to[i] = middle[i] + (double)move->translation[i];
    return (struct affine){{c, 0, -s, to[0] - (c * middle[0] - s * middle[2]), /* x */
                            0, 1, 0, (double)move->translation[1],             /* y */
                            s, 0, c, to[2] - (s * middle[0] + c * middle[2])}};
}

static const char *name_of(const struct builder *b, const struct scene_instance *instance)
{
    return (const char *)b->sections[SCENE_NAMES].data + instance->name;
}

/* Widens the box by an instance, whose mesh stands in the world. */
static void add_instance(const struct builder *b, const struct scene_instance *instance,
                         double lowest[3], double highest[3])
{
    const struct scene_mesh *mesh = &builder_meshes(b)[instance->mesh];
    const float *at = builder_positions(b) + (size_t)3 * mesh->first_vertex;
    for (size_t i = 0; i < (size_t)3 * mesh->vertex_count; i++) {
        lowest[i % 3] = fmin(lowest[i % 3], (double)at[i]);
        highest[i % 3] = fmax(highest[i % 3], (double)at[i]);
    }
}

static int apply(struct builder *b, uint32_t index, const struct job_move *move,
                 struct fault *fault)
{
    double lowest[3] = {INFINITY, INFINITY, INFINITY};
    double highest[3] = {-INFINITY, -INFINITY, -INFINITY}, middle[3];
    const uint64_t count = builder_count(b, SCENE_INSTANCES);
    struct scene_instance *instances = builder_instances(b);
    for (uint64_t i = 0; i < count; i++)
        if (moves_name_matches(name_of(b, &instances[i]), move->node))
            add_instance(b, &instances[i], lowest, highest);
    if (lowest[0] > highest[0]) return moves_refuse_name(index, move->node, fault);
    for (int c = 0; c < 3; c++) middle[c] = 0.5 * (lowest[c] + highest[c]);
    const struct affine by = moves_transform(move, middle);
    for (uint64_t i = 0; i < count; i++) {
        if (!moves_name_matches(name_of(b, &instances[i]), move->node)) continue;
        instances[i].flags &= ~(uint32_t)INSTANCE_IDENTITY;
        for (int k = 0; k < 12; k++) instances[i].to_world[k] = (float)by.m[k];
    }
    return 0;
}

int moves_apply(struct builder *b, const struct job_moves *moves, struct fault *fault)
{
    int rc = 0;
    for (uint32_t i = 0; moves != NULL && i < moves->count && rc == 0; i++)
        rc = apply(b, i, &moves->list[i], fault);
    return rc;
}
