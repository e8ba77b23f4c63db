#pragma once
/* The scene under construction: one growing array for each section of the blob.
 *
 * Records are appended in the order of the source, so that the same file gives the same bytes.
 * Counts are checked against limits.h before an array grows. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/scene/scene.h"
#include "server/import/scene/warnings.h"

struct builder_array {
    uint8_t *data; /* owned; NULL while empty */
    uint64_t count, capacity;
    uint32_t record_bytes;
};

struct builder {
    struct builder_array sections[SCENE_SECTION_COUNT];
    struct warnings warnings;
    double origin[3];        /* of the scene in the file's coordinates */
    bool moves;              /* an animation plays */
    uint32_t default_camera; /* index */
    uint32_t plate;          /* name of the file that is this frame's backplate; 0: none */
    bool is_composite;       /* what is no catcher or holdout is not in the photograph (roles.h) */
    const struct builder *base; /* borrowed; of a frame (builder_begin_frame); NULL: none */
};

int builder_init(struct builder *b, struct fault *fault);
void builder_fini(struct builder *b);

/* Begins a frame that stands on a finished base of `digest`: it has the base's meshes, instances,
 * textures, images, names and warnings. The base is borrowed until builder_fini. */
int builder_begin_frame(struct builder *b, const struct builder *base, const struct digest *digest,
                        struct fault *fault);

/* Returns the builder that has a mesh's arrays. */
const struct builder *builder_home(const struct builder *b, const struct scene_mesh *mesh);

/* Appends `count` zeroed records. *out points at the first and holds until the next append to that
 * section. ERR_LIMIT or ERR_MEMORY. */
int builder_append(struct builder *b, enum scene_section section, uint64_t count, void **out,
                   struct fault *fault);

/* Appends a copy of one record. The same errors. */
int builder_append_record(struct builder *b, enum scene_section section, const void *record,
                          struct fault *fault);

uint64_t builder_count(const struct builder *b, enum scene_section section);

/* Return typed views. Each holds until the next append to its section. */
float *builder_positions(const struct builder *b);
uint32_t *builder_triangles(const struct builder *b);
struct scene_mesh *builder_meshes(const struct builder *b);
struct scene_instance *builder_instances(const struct builder *b);
struct scene_material *builder_materials(const struct builder *b);
struct scene_image *builder_images(const struct builder *b);
struct scene_light *builder_lights(const struct builder *b);

/* Stores a name, cut at LIMIT_NAME_BYTES and made printable; NULL and "" are 0. */
int builder_name(struct builder *b, const char *text, uint32_t *out, struct fault *fault);

/* Fills SCENE_INFO and SCENE_WARNINGS: bounds, triangle count, default camera. It is the last step.
 * ERR_MISSING when there is no triangle. ERR_LIMIT when an instance leaves LIMIT_COORDINATE. */
int builder_finish(struct builder *b, struct fault *fault);

/* Does the same for a base, which may have no triangles. */
int builder_finish_base(struct builder *b, struct fault *fault);

/* Sets the bounds of a finished base: those that cameras of our making look at. */
void builder_set_bounds(struct builder *b, const float lowest[3], const float highest[3]);

/* Returns the bounds that such a camera looks at: the base's, so that it stands still over frames.
 */
int builder_view_bounds(const struct builder *b, float lowest[3], float highest[3],
                        struct fault *fault);

/* Computes bounds of all placed geometry. They are exact for baked meshes; instances count as
 * transformed boxes. */
int builder_bounds(const struct builder *b, float lowest[3], float highest[3], struct fault *fault);
