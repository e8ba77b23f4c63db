#pragma once
/* Checks of a scene blob's contents, once its sections are known to lie where they should. */
#include <stdbool.h>
#include <stddef.h>

#include "proto/scene/scene.h"

/* Checks every index and every number; *fault names record and field ("meshes[3].material"). */
int scene_check(const struct scene *s, struct fault *fault);

/* Returns a section's name, such as "positions". */
const char *scene_section_name(uint32_t section);

/* A record that is checked. */
struct scene_record {
    const struct scene *scene;
    uint32_t section;
    uint64_t index;
    struct fault *fault;
};

/* Writes a fault such as "materials[3].ior", with `value` and why it is refused. Returns `code`. */
int record_refuse(const struct scene_record *at, const char *field, int code, double value,
                  const char *why);

/* Checks that v is finite and within [min, max]. */
int record_number(const struct scene_record *at, const char *field, float v, float min, float max);
int record_numbers(const struct scene_record *at, const char *field, const float *v, size_t count,
                   float min, float max);

/* Check an index into a section; the second may be none. */
int record_index(const struct scene_record *at, const char *field, uint32_t index,
                 uint32_t section);
int record_optional(const struct scene_record *at, const char *field, uint32_t index,
                    uint32_t section);

/* Checks a stretch of a section. */
int record_range(const struct scene_record *at, const char *field, uint32_t first, uint64_t count,
                 uint32_t section);

/* Check a value of an enumeration up to `max`, bits within `known`, and a word that must be 0. */
int record_value(const struct scene_record *at, const char *field, uint32_t value, uint32_t max);
int record_flags(const struct scene_record *at, uint32_t flags, uint32_t known);
int record_reserved(const struct scene_record *at, uint32_t reserved);

int record_name(const struct scene_record *at, uint32_t name);

/* Checks how a surface looks (scene_check_surface.c). */
int scene_check_material(const struct scene_record *at, const struct scene_material *m);
int scene_check_texture(const struct scene_record *at, const struct scene_texture *t);
int scene_check_image(const struct scene_record *at, const struct scene_image *image);

int scene_check_camera(const struct scene_record *at, const struct scene_camera *camera);
bool scene_is_invertible(const float m[12]);

/* Checks what moves while the shutter is open (scene_check_motion.c); all else has been checked. */
int scene_check_motion(const struct scene *s, struct fault *fault);
