#include "server/import/gltf/gltf_animation.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/import/gltf/gltf_pointer.h"
#include "server/import/gltf/gltf_sampler.h"

/* The animations that play. */
struct playing {
    struct gltf *g;
    double time_s;
    bool only_found; /* nothing is moved */
    json_t *taken;   /* owned; an object with a member for each pointer that is moved already */
    struct gltf_key_times times;
};

/* A channel, or a part of one, with its place. */
struct channel {
    const json_t *json, *target, *samplers;
    gltf_place place, target_place, samplers_place;
};

/* Writes the JSON pointer of what the channel moves. "": nothing that is known here. */
static int read_pointer(struct gltf *g, const struct channel *c, char *out, size_t capacity,
                        struct fault *fault)
{
    const char *path, *pointer = NULL;
    const json_t *extension = NULL;
    gltf_place at;
    uint32_t node;
    out[0] = '\0';
    int rc = gltf_text(c->target, c->target_place, "path", &path, fault);
    if (rc != 0) return rc;
    if (path == NULL) return fault_set(fault, ERR_MISSING, c->target_place, "a target has a path");
    if (strcmp(path, "pointer") == 0) {
        rc = gltf_extension(c->target, c->target_place, "KHR_animation_pointer", &extension, at,
                            fault);
        if (rc == 0) rc = gltf_text(extension, at, "pointer", &pointer, fault);
        if (rc == 0 && pointer == NULL)
            return fault_set(fault, ERR_MISSING, c->target_place, "its pointer is missing");
        if (rc == 0) snprintf(out, capacity, "%s", pointer);
        return rc;
    }
    rc = gltf_index(c->target, c->target_place, "node", gltf_count(g->root, "nodes"), &node, fault);
    if (rc == 0 && node != SCENE_NONE) /* else an extension says what moves */
        snprintf(out, capacity, "/nodes/%" PRIu32 "/%s", node, path);
    return rc;
}

/* Notes that a pointer is moved. False when it was already. */
static bool take(struct playing *p, const char *pointer, const char *place)
{
    if (json_object_get(p->taken, pointer) == NULL)
        return json_object_set_new(p->taken, pointer, json_true()) == 0;
    warnings_add(&p->g->builder->warnings, place,
                 "an earlier channel moves the same; it counts, unless scene.animation names "
                 "another animation");
    return false;
}

/* Notes what moves by a pointer that gltf_pointer_find has found. */
static void note(struct gltf_moving *moving, const char *text)
{
    unsigned index = 0;
    moving->any = moving->plays = true;
    if (sscanf(text, "/nodes/%u/", &index) == 1)
        (strstr(text, "/weights") ? moving->node_weights : moving->nodes)[index] = 1;
    else if (sscanf(text, "/meshes/%u/", &index) == 1)
        moving->mesh_weights[index] = 1;
    else if (sscanf(text, "/materials/%u/", &index) == 1)
        moving->materials[index] = 1;
}

static int apply_sampler(struct playing *p, const struct channel *c,
                         const struct gltf_pointer *pointer, struct fault *fault)
{
    uint32_t index, count;
    double *values;
    gltf_place place;
    int rc = gltf_index(c->json, c->place, "sampler", json_array_size(c->samplers), &index, fault);
    if (rc != 0) return rc;
    if (index == SCENE_NONE)
        return fault_set(fault, ERR_MISSING, c->place, "a channel has a sampler");
    gltf_place_set(place, "%s[%" PRIu32 "]", c->samplers_place, index);
    const json_t *sampler = json_array_get(c->samplers, index);
    if (!json_is_object(sampler)) return fault_set(fault, ERR_TYPE, place, "it is not an object");
    rc = gltf_sampler_read(p->g, sampler, place, p->time_s, pointer->kind, pointer->targets,
                           &p->times, &values, &count, fault);
    if (rc == 0) rc = gltf_pointer_set(pointer, values, count, place, fault);
    free(values);
    return rc;
}

static int apply_channel(struct playing *p, struct channel *c, struct fault *fault)
{
    char text[LIMIT_POINTER_BYTES];
    struct gltf_pointer pointer;
    if (!json_is_object(c->json))
        return fault_set(fault, ERR_TYPE, c->place, "it is not an object");
    int rc = gltf_object(c->json, c->place, "target", &c->target, fault);
    if (rc != 0) return rc;
    gltf_place_set(c->target_place, "%s.target", c->place);
    if (c->target == NULL)
        return fault_set(fault, ERR_MISSING, c->target_place, "a channel has a target");
    rc = read_pointer(p->g, c, text, sizeof text, fault);
    if (rc != 0 || text[0] == '\0' || !take(p, text, c->place)) return rc;
    rc = gltf_pointer_find(p->g, text, c->target_place, &pointer, fault);
    if (rc != 0 || pointer.holder == NULL) return rc;
    if (!p->only_found) return apply_sampler(p, c, &pointer, fault);
    note(&p->g->moving, text);
    return 0;
}

static int apply_animation(struct playing *p, size_t index, struct fault *fault)
{
    const json_t *json, *channels;
    gltf_place place;
    struct channel c = {0};
    int rc = gltf_item(p->g->root, "animations", index, &json, place, fault);
    if (rc == 0) rc = gltf_array(json, place, "channels", &channels, fault);
    if (rc == 0) rc = gltf_array(json, place, "samplers", &c.samplers, fault);
    gltf_place_set(c.samplers_place, "%s.samplers", place);
    for (size_t i = 0; rc == 0 && i < json_array_size(channels); i++) {
        c.json = json_array_get(channels, i);
        gltf_place_set(c.place, "%s.channels[%zu]", place, i);
        rc = apply_channel(p, &c, fault);
    }
    return rc;
}

static const char *name_of(const struct gltf *g, size_t index)
{
    const json_t *animation = json_array_get(json_object_get(g->root, "animations"), index);
    return json_string_value(json_object_get(animation, "name"));
}

/* Finds the animation of a name; the first where several have it. */
static int find(const struct gltf *g, const char *name, size_t *out, struct fault *fault)
{
    const size_t count = gltf_count(g->root, "animations");
    char known[256] = "none";
    size_t used = 0;
    for (*out = 0; *out < count; ++*out) {
        const char *own = name_of(g, *out);
        if (own == NULL) continue;
        if (strcmp(own, name) == 0) return 0;
        if (used > sizeof known - 40) continue;
        used += (size_t)snprintf(known + used, sizeof known - used, "%s\"%.30s\"",
                                 used > 0 ? ", " : "", own);
    }
    return fault_set(fault, ERR_NOT_FOUND, "animations",
                     "the scene has no animation \"%.100s\"; it has %s", name, known);
}

static int play(struct playing p, const struct scene_choice *choice, struct fault *fault)
{
    struct gltf *g = p.g;
    const size_t count = gltf_count(g->root, "animations");
    size_t only = 0;
    p.taken = json_object();
    int rc = p.taken == NULL ? fault_set(fault, ERR_MEMORY, "animations", "no memory for them") : 0;
    if (rc == 0 && choice->animation != NULL) {
        rc = find(g, choice->animation, &only, fault);
        if (rc == 0) rc = apply_animation(&p, only, fault);
    } else {
        for (size_t i = 0; rc == 0 && i < count; i++) rc = apply_animation(&p, i, fault);
    }
    json_decref(p.taken);
    free(p.times.list);
    return rc;
}

int gltf_animations_apply(struct gltf *g, const struct scene_choice *choice, double time_s,
                          struct fault *fault)
{
    return play((struct playing){.g = g, .time_s = time_s}, choice, fault);
}

int gltf_animations_find(struct gltf *g, const struct scene_choice *choice, struct fault *fault)
{
    struct gltf_moving *m = &g->moving;
    m->nodes = calloc(gltf_count(g->root, "nodes") + 1, 1);
    m->node_weights = calloc(gltf_count(g->root, "nodes") + 1, 1);
    m->mesh_weights = calloc(gltf_count(g->root, "meshes") + 1, 1);
    m->materials = calloc(gltf_count(g->root, "materials") + 1, 1);
    if (m->nodes == NULL || m->node_weights == NULL || m->mesh_weights == NULL ||
        m->materials == NULL)
        return fault_set(fault, ERR_MEMORY, "animations", "no memory for what they move");
    return play((struct playing){.g = g, .only_found = true}, choice, fault);
}

void gltf_moving_fini(struct gltf_moving *moving)
{
    free(moving->nodes);
    free(moving->node_weights);
    free(moving->mesh_weights);
    free(moving->materials);
    *moving = (struct gltf_moving){0};
}
