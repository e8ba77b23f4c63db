/* Buffer views of EXT_meshopt_compression. */
#include <math.h>
#include <meshoptimizer.h>
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

enum { SIDE = 8, VERTICES = SIDE * SIDE, CORNERS = 6 * (SIDE - 1) * (SIDE - 1) };

static float positions[VERTICES][3];
static uint32_t corners[CORNERS];

/* What a document's buffer holds: positions and indices, encoded. */
static uint8_t bytes[16384];
static size_t position_bytes, index_bytes;

static void make_grid(void)
{
    uint32_t n = 0;
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            float *p = positions[y * SIDE + x];
            p[0] = (float)x, p[1] = (float)y, p[2] = (float)(x * y) / 16;
            if (x + 1 == SIDE || y + 1 == SIDE) continue;
            const uint32_t at = y * SIDE + x;
            const uint32_t quad[6] = {at, at + 1, at + SIDE, at + 1, at + SIDE + 1, at + SIDE};
            memcpy(corners + n, quad, sizeof quad);
            n += 6;
        }
}

static int set_up(void **state)
{
    make_grid();
    position_bytes = meshopt_encodeVertexBuffer(bytes, sizeof bytes, positions, VERTICES, 12);
    index_bytes = meshopt_encodeIndexBuffer(bytes + position_bytes, sizeof bytes - position_bytes,
                                            corners, CORNERS);
    return position_bytes > 0 && index_bytes > 0 ? room_open(state) : -1;
}

ALL_TESTS(set_up, room_close);

/* A document of the grid; `vertices` and `filter` go into the first view, `mode` into the second.
 */
static const char *document(unsigned vertices, const char *filter, const char *mode,
                            size_t position_size)
{
    static char text[4096];
    room_write("d.bin", bytes, position_bytes + index_bytes);
    snprintf(
        text, sizeof text,
        "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": "
        "[\"EXT_meshopt_compression\"], \"buffers\": [{\"uri\": \"d.bin\", \"byteLength\": %zu},"
        "{\"byteLength\": 99999, \"extensions\": {\"EXT_meshopt_compression\": {\"fallback\": "
        "true}}}], \"bufferViews\": [{\"buffer\": 1, \"byteLength\": 768, \"extensions\": "
        "{\"EXT_meshopt_compression\": {\"buffer\": 0, \"byteLength\": %zu, \"byteStride\": 12,"
        "\"count\": %u, \"mode\": \"ATTRIBUTES\"%s}}}, {\"buffer\": 1, \"byteLength\": 1176,"
        "\"extensions\": {\"EXT_meshopt_compression\": {\"buffer\": 0, \"byteOffset\": %zu,"
        "\"byteLength\": %zu, \"byteStride\": 4, \"count\": %d, \"mode\": \"%s\"}}}],"
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 64, \"type\": "
        "\"VEC3\"}, {\"bufferView\": 1, \"componentType\": 5125, \"count\": %d, \"type\": "
        "\"SCALAR\"}], \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0},"
        "\"indices\": 1}]}], \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}]}",
        position_bytes + index_bytes, position_size, vertices, filter, position_bytes, index_bytes,
        CORNERS, mode, CORNERS);
    return text;
}

TEST(attributes_and_triangles_are_what_was_encoded)
{
    struct scene s;
    assert_int_equal(
        room_import_text("a.gltf", document(VERTICES, "", "TRIANGLES", position_bytes), &s), 0);
    assert_int_equal(s.count[SCENE_TRIANGLES], CORNERS / 3);
    assert_memory_equal(s.positions, positions, sizeof positions);
    for (int t = 0; t < CORNERS / 3; t++) { /* the codec may turn a triangle, not turn it over */
        const uint32_t *got = s.triangles + 3 * t, *wanted = corners + 3 * t;
        int turn = 0;
        while (turn < 3 && got[turn] != wanted[0]) turn++;
        assert_true(turn < 3 && got[(turn + 1) % 3] == wanted[1] &&
                    got[(turn + 2) % 3] == wanted[2]);
    }
    scene_unmap(&s);
}

TEST(exponents_are_unpacked)
{
    struct scene s;
    static float filtered[VERTICES][3];
    meshopt_encodeFilterExp(filtered, VERTICES, 12, 23, &positions[0][0]);
    position_bytes = meshopt_encodeVertexBuffer(bytes, sizeof bytes, filtered, VERTICES, 12);
    index_bytes = meshopt_encodeIndexBuffer(bytes + position_bytes, sizeof bytes - position_bytes,
                                            corners, CORNERS);
    const char *text =
        document(VERTICES, ", \"filter\": \"EXPONENTIAL\"", "TRIANGLES", position_bytes);
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    for (int i = 0; i < 3 * VERTICES; i++)
        assert_true(fabsf(s.positions[i] - positions[i / 3][i % 3]) < 1e-5f);
    scene_unmap(&s);
}

TEST(streams_that_lie_are_refused)
{
#define FIRST  "bufferViews[0].extensions.EXT_meshopt_compression"
#define SECOND "bufferViews[1].extensions.EXT_meshopt_compression"
    const size_t n = position_bytes;
    room_refuses("a.gltf", document(VERTICES + 1, "", "TRIANGLES", n), ERR_CORRUPT, FIRST);
    room_refuses("a.gltf", document(4000000000u, "", "TRIANGLES", n), ERR_RANGE, FIRST ".count");
    room_refuses("a.gltf", document(170000000u, "", "TRIANGLES", n), ERR_CORRUPT, FIRST);
    room_refuses("a.gltf", document(VERTICES, "", "TRIANGLES", n - 3), ERR_CORRUPT, FIRST);
    room_refuses("a.gltf", document(VERTICES, "", "TRIANGLES", n + 100000), ERR_TRUNCATED, FIRST);
    room_refuses("a.gltf", document(VERTICES, "", "INDICES", n), ERR_CORRUPT, SECOND);
    room_refuses("a.gltf", document(VERTICES, "", "QUADS", n), ERR_RANGE, SECOND ".mode");
    room_refuses("a.gltf", document(VERTICES, ", \"filter\": \"OCTAHEDRAL\"", "TRIANGLES", n),
                 ERR_RANGE, FIRST);
    room_refuses("a.gltf", document(32, "", "TRIANGLES", n), ERR_CORRUPT, FIRST);
}

TEST(damaged_bytes_do_no_harm)
{
    for (size_t i = 0; i < position_bytes + index_bytes; i++) {
        struct scene s;
        const uint8_t before = bytes[i];
        bytes[i] ^= 0x55;
        if (room_import_text("a.gltf", document(VERTICES, "", "TRIANGLES", position_bytes), &s) ==
            0)
            scene_unmap(&s);
        bytes[i] = before;
    }
}
