#include "server/import/scene/builder.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Section names and caps in records; sections without a row are bounded by LIMIT_BLOB_BYTES. */
static const struct {
    const char *name;
    uint64_t limit;
} section_limits[SCENE_SECTION_COUNT] = {
    [SCENE_INFO] = {"info", 1},
    [SCENE_POSITIONS] = {"vertices", LIMIT_VERTICES},
    [SCENE_NORMALS] = {"normals", LIMIT_VERTICES},
    [SCENE_TANGENTS] = {"tangents", LIMIT_VERTICES},
    [SCENE_UVS] = {"texture coordinates", 2ull * LIMIT_VERTICES},
    [SCENE_TRIANGLES] = {"triangles", LIMIT_TRIANGLES},
    [SCENE_MESHES] = {"meshes", LIMIT_MESHES},
    [SCENE_INSTANCES] = {"instances", LIMIT_INSTANCES},
    [SCENE_MATERIALS] = {"materials", LIMIT_MATERIALS},
    [SCENE_TEXTURES] = {"textures", 2ull * LIMIT_IMAGES},
    [SCENE_IMAGES] = {"images", LIMIT_IMAGES},
    [SCENE_PIXELS] = {"image bytes", LIMIT_BLOB_BYTES},
    [SCENE_LIGHTS] = {"lights", LIMIT_LIGHTS},
    [SCENE_CAMERAS] = {"cameras", LIMIT_CAMERAS},
    [SCENE_NAMES] = {"bytes of names", 1u << 30},
    [SCENE_WARNINGS] = {"bytes of warnings", LIMIT_WARNINGS *WARNING_TEXT_BYTES},
    [SCENE_COLORS] = {"vertex colours", LIMIT_VERTICES},
    [SCENE_BASE] = {"bases", 1},
    [SCENE_MOVERS] = {"movers", LIMIT_INSTANCES},
    [SCENE_STEPS] = {"steps of movers", LIMIT_INSTANCES *(uint64_t)SHUTTER_STEPS},
    [SCENE_POSES] = {"poses of cameras", LIMIT_CAMERAS *(uint64_t)SHUTTER_STEPS},
    [SCENE_SKY] = {"texels of a sky", SCENE_SKY_TEXELS},
};

int builder_init(struct builder *b, struct fault *fault)
{
    memset(b, 0, sizeof *b);
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++)
        b->sections[s].record_bytes = scene_record_bytes(s);
    void *empty_name;
    return builder_append(b, SCENE_NAMES, 1, &empty_name, fault);
}

void builder_fini(struct builder *b)
{
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) free(b->sections[s].data);
    memset(b, 0, sizeof *b);
}

/* Grows by halves, so that large arrays waste little. */
static int array_reserve(struct builder_array *a, uint64_t count, const char *name,
                         struct fault *fault)
{
    if (count <= a->capacity) return 0;
    uint64_t capacity = a->capacity + a->capacity / 2;
    if (capacity < count) capacity = count;
    uint8_t *data = realloc(a->data, capacity * a->record_bytes);
    if (data == NULL) {
        fault_set(fault, ERR_MEMORY, name, "no memory for %" PRIu64 " records", count);
        return ERR_MEMORY;
    }
    a->data = data;
    a->capacity = capacity;
    return 0;
}

int builder_append(struct builder *b, enum scene_section section, uint64_t count, void **out,
                   struct fault *fault)
{
    struct builder_array *a = &b->sections[section];
    const char *name = section_limits[section].name;
    uint64_t limit = section_limits[section].limit;
    if (count > limit - a->count) {
        fault_set(fault, ERR_LIMIT, name, "the scene has more than %" PRIu64 " %s", limit, name);
        return ERR_LIMIT;
    }
    int rc = array_reserve(a, a->count + count, name, fault);
    if (rc != 0) return rc;
    uint8_t *first = a->data + a->count * a->record_bytes;
    memset(first, 0, count * a->record_bytes);
    a->count += count;
    *out = first;
    return 0;
}

int builder_append_record(struct builder *b, enum scene_section section, const void *record,
                          struct fault *fault)
{
    void *at;
    const int rc = builder_append(b, section, 1, &at, fault);
    if (rc == 0) memcpy(at, record, b->sections[section].record_bytes);
    return rc;
}

uint64_t builder_count(const struct builder *b, enum scene_section section)
{
    return b->sections[section].count;
}

/* The arrays come from realloc, so that any record type is aligned. */
static void *section_data(const struct builder *b, enum scene_section section)
{
    return b->sections[section].data;
}

float *builder_positions(const struct builder *b)
{
    return section_data(b, SCENE_POSITIONS);
}

uint32_t *builder_triangles(const struct builder *b)
{
    return section_data(b, SCENE_TRIANGLES);
}

struct scene_mesh *builder_meshes(const struct builder *b)
{
    return section_data(b, SCENE_MESHES);
}

struct scene_instance *builder_instances(const struct builder *b)
{
    return section_data(b, SCENE_INSTANCES);
}

struct scene_material *builder_materials(const struct builder *b)
{
    return section_data(b, SCENE_MATERIALS);
}

struct scene_image *builder_images(const struct builder *b)
{
    return section_data(b, SCENE_IMAGES);
}

struct scene_light *builder_lights(const struct builder *b)
{
    return section_data(b, SCENE_LIGHTS);
}

/* The length of `text` cut so that it fits and ends between characters. */
static size_t name_length(const char *text)
{
    size_t length = strnlen(text, LIMIT_NAME_BYTES);
    if (length < LIMIT_NAME_BYTES) return length;
    length = LIMIT_NAME_BYTES - 1;
    while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80) length--;
    return length;
}

int builder_name(struct builder *b, const char *text, uint32_t *out, struct fault *fault)
{
    *out = 0;
    if (text == NULL || text[0] == 0) return 0;
    size_t length = name_length(text);
    uint64_t offset = builder_count(b, SCENE_NAMES);
    void *at;
    int rc = builder_append(b, SCENE_NAMES, length + 1, &at, fault);
    if (rc != 0) return rc;
    memcpy(at, text, length);
    text_make_printable(at);
    *out = (uint32_t)offset;
    return 0;
}

static void box_of_mesh(const struct builder *b, const struct scene_mesh *mesh, float box[6])
{
    const float *p = builder_positions(builder_home(b, mesh)) + 3 * (size_t)mesh->first_vertex;
    for (int c = 0; c < 3; c++) box[c] = box[3 + c] = p[c];
    for (uint32_t v = 1; v < mesh->vertex_count; v++) {
        for (int c = 0; c < 3; c++) {
            float x = p[3 * (size_t)v + (size_t)c];
            if (x < box[c]) box[c] = x;
            if (x > box[3 + c]) box[3 + c] = x;
        }
    }
}

/* Widens lowest..highest by the eight transformed corners of a box. */
static void include_box(const struct scene_instance *instance, const float box[6], float lowest[3],
                        float highest[3])
{
    for (unsigned corner = 0; corner < 8; corner++) {
        double p[3];
        for (unsigned c = 0; c < 3; c++) p[c] = box[c + ((corner >> c & 1) ? 3 : 0)];
        for (int r = 0; r < 3; r++) {
            const float *row = instance->to_world + 4 * r;
            float x = (float)(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]);
            /* Written so that a NaN widens the box and is found by the caller. */
            if (!(x >= lowest[r])) lowest[r] = x;
            if (!(x <= highest[r])) highest[r] = x;
        }
    }
}

int builder_bounds(const struct builder *b, float lowest[3], float highest[3], struct fault *fault)
{
    for (int c = 0; c < 3; c++) lowest[c] = INFINITY, highest[c] = -INFINITY;
    uint64_t count = builder_count(b, SCENE_INSTANCES);
    const struct scene_instance *instances = builder_instances(b);
    uint32_t boxed = SCENE_NONE;
    float box[6] = {0};
    for (uint64_t i = 0; i < count; i++) {
        if (instances[i].mesh != boxed) { /* the instances of a mesh stand together */
            boxed = instances[i].mesh;
            box_of_mesh(b, &builder_meshes(b)[boxed], box);
        }
        include_box(&instances[i], box, lowest, highest);
        for (int c = 0; c < 3; c++) {
            if (lowest[c] >= -LIMIT_COORDINATE && highest[c] <= LIMIT_COORDINATE) continue;
            char place[64];
            snprintf(place, sizeof place, "instances[%" PRIu64 "]", i);
            return fault_set(fault, ERR_LIMIT, place, "it reaches beyond %g scene units",
                             (double)LIMIT_COORDINATE);
        }
    }
    return 0;
}

static int append_warnings(struct builder *b, struct fault *fault)
{
    struct warnings *w = &b->warnings;
    if (w->dropped > 0 && w->count < LIMIT_WARNINGS) {
        struct warning *last = &w->list[w->count++];
        snprintf(last->sentence, sizeof last->sentence, "%" PRIu64 " further warnings", w->dropped);
        last->place[0] = 0;
    }
    for (uint32_t i = 0; i < w->count; i++) {
        char text[WARNING_TEXT_BYTES];
        warnings_text(w, i, text);
        void *at;
        int rc = builder_append(b, SCENE_WARNINGS, strlen(text) + 1, &at, fault);
        if (rc != 0) return rc;
        memcpy(at, text, strlen(text) + 1);
    }
    return 0;
}

static uint64_t count_placed(const struct builder *b)
{
    uint64_t placed = 0;
    for (uint64_t i = 0; i < builder_count(b, SCENE_INSTANCES); i++)
        placed += builder_meshes(b)[builder_instances(b)[i].mesh].triangle_count;
    return placed;
}

static int finish(struct builder *b, uint64_t placed, uint32_t flags, struct fault *fault)
{
    float lowest[3] = {0}, highest[3] = {0};
    int rc = placed > 0 ? builder_bounds(b, lowest, highest, fault) : 0;
    if (rc != 0) return rc;
    void *at;
    rc = builder_append(b, SCENE_INFO, 1, &at, fault);
    if (rc != 0) return rc;
    struct scene_info *info = at;
    memcpy(info->bounds_min, lowest, sizeof lowest);
    memcpy(info->bounds_max, highest, sizeof highest);
    memcpy(info->origin, b->origin, sizeof b->origin);
    info->placed_triangles = placed;
    info->default_camera = b->default_camera;
    info->plate = b->plate;
    info->flags = flags;
    return append_warnings(b, fault);
}

int builder_finish(struct builder *b, struct fault *fault)
{
    const uint64_t placed = count_placed(b);
    if (placed == 0) return fault_set(fault, ERR_MISSING, "scene", "the scene has no triangles");
    return finish(b, placed, b->moves ? SCENE_MOVES : 0, fault);
}

int builder_finish_base(struct builder *b, struct fault *fault)
{
    return finish(b, count_placed(b), SCENE_MOVES | SCENE_IS_BASE, fault);
}

static int copy_section(struct builder *b, const struct builder *from, enum scene_section section,
                        struct fault *fault)
{
    const uint64_t count = builder_count(from, section);
    void *at;
    b->sections[section].count = 0; /* the empty name comes along */
    int rc = count > 0 ? builder_append(b, section, count, &at, fault) : 0;
    if (rc == 0 && count > 0)
        memcpy(at, from->sections[section].data, count * scene_record_bytes(section));
    return rc;
}

int builder_begin_frame(struct builder *b, const struct builder *base, const struct digest *digest,
                        struct fault *fault)
{
    static const enum scene_section kept[] = {SCENE_MESHES, SCENE_INSTANCES, SCENE_TEXTURES,
                                              SCENE_IMAGES, SCENE_NAMES};
    void *at;
    int rc = builder_init(b, fault);
    for (size_t i = 0; rc == 0 && i < sizeof kept / sizeof *kept; i++)
        rc = copy_section(b, base, kept[i], fault);
    if (rc == 0) rc = builder_append(b, SCENE_BASE, 1, &at, fault);
    if (rc != 0) return rc;
    memcpy(at, digest, sizeof *digest);
    b->base = base;
    b->moves = true;
    b->warnings = base->warnings;
    memcpy(b->origin, base->origin, sizeof b->origin);
    for (uint64_t i = 0; i < builder_count(b, SCENE_MESHES); i++)
        builder_meshes(b)[i].flags |= MESH_IN_BASE;
    for (uint64_t i = 0; i < builder_count(b, SCENE_IMAGES); i++)
        builder_images(b)[i].flags |= IMAGE_IN_BASE;
    return 0;
}

const struct builder *builder_home(const struct builder *b, const struct scene_mesh *mesh)
{
    return mesh->flags & MESH_IN_BASE ? b->base : b;
}

static struct scene_info *info_of(const struct builder *b)
{
    return (struct scene_info *)(void *)b->sections[SCENE_INFO].data;
}

void builder_set_bounds(struct builder *b, const float lowest[3], const float highest[3])
{
    memcpy(info_of(b)->bounds_min, lowest, 3 * sizeof *lowest);
    memcpy(info_of(b)->bounds_max, highest, 3 * sizeof *highest);
}

int builder_view_bounds(const struct builder *b, float lowest[3], float highest[3],
                        struct fault *fault)
{
    if (b->base == NULL) return builder_bounds(b, lowest, highest, fault);
    memcpy(lowest, info_of(b->base)->bounds_min, 3 * sizeof *lowest);
    memcpy(highest, info_of(b->base)->bounds_max, 3 * sizeof *highest);
    return 0;
}
