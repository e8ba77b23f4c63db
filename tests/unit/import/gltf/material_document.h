#pragma once
/* A document of one triangle, with a material that tests write. */
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

/* A triangle's positions, normals, UVs and tangents, in this order in the buffer. */
struct triangle {
    float positions[9], normals[9], uvs[6], tangents[12];
};
static const struct triangle triangle = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
                                         {0, 0, 1, 0, 0, 1, 0, 0, 1},
                                         {0, 0, 1, 0, 0, 1},
                                         {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}};

/* A PNG of one pixel; its colour is of no matter. */
#define PIXEL                                                                                      \
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNo"           \
    "aGgAAAMEAYFL09IQAAAAAElFTkSuQmCC"

static const char head[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"t.bin\", \"byteLength\": 144}],"
    "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}, {\"buffer\": 0, \"byteOffset\": 36, "
    "\"byteLength\": 36}, {\"buffer\": 0, \"byteOffset\": 72, \"byteLength\": 24}, {\"buffer\": 0, "
    "\"byteOffset\": 96, \"byteLength\": 48}], \"accessors\": ["
    "{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"},"
    "{\"bufferView\": 1, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"},"
    "{\"bufferView\": 2, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC2\"},"
    "{\"bufferView\": 3, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC4\"}],"
    "\"images\": [{\"uri\": \"" PIXEL "\"}, {\"uri\": \"" PIXEL "\"}],"
    "\"textures\": [{\"source\": 0}, {\"source\": 1}],"
    "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}],";

#define WITH_UVS      "\"POSITION\": 0, \"NORMAL\": 1, \"TEXCOORD_0\": 2"
#define WITH_TANGENTS "\"POSITION\": 0, \"NORMAL\": 1, \"TANGENT\": 3"

static inline const char *document(const char *attributes, const char *material)
{
    static char text[8192];
    snprintf(text, sizeof text,
             "%s\"meshes\": [{\"primitives\": [{\"attributes\": {%s}, \"material\": 0}]}],"
             "\"materials\": [{%s}]}",
             head, attributes, material);
    return text;
}

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    _Static_assert(sizeof triangle == 144, "as the documents say");
    room_write("t.bin", &triangle, sizeof triangle);
    return 0;
}

ALL_TESTS(set_up, room_close);

static inline const struct scene_material *read_with(const char *attributes, const char *material,
                                                     struct scene *s)
{
    int rc = room_import_text("a.gltf", document(attributes, material), s);
    if (rc != 0) print_error("%s: %s\n", room_fault.pointer, room_fault.detail);
    assert_int_equal(rc, 0);
    return &s->materials[0];
}

static inline const struct scene_material *read_one(const char *material, struct scene *s)
{
    return read_with(WITH_UVS, material, s);
}
