/* Primitives of KHR_draco_mesh_compression. */
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

/* A square that libdraco 1.5.5 has encoded one vertex after the other: attribute 7 is its positions
 * as floats, attribute 2 its colours as bytes. */
static uint8_t stream[] = {
    0x44, 0x52, 0x41, 0x43, 0x4f, 0x02, 0x02, 0x01, 0x00, 0x00, 0x00, 0x02, 0x04, 0x01, 0x00,
    0x01, 0x02, 0x00, 0x02, 0x03, 0x01, 0x02, 0x00, 0x09, 0x03, 0x00, 0x07, 0x02, 0x02, 0x04,
    0x01, 0x02, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x80, 0x3f, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x3f, 0x00, 0x01, 0x01, 0x00, 0x09, 0x03, 0x01, 0x10,
    0x01, 0x20, 0x13, 0x01, 0x10, 0x03, 0x00, 0x90, 0x90, 0x69, 0x80, 0x11, 0x10, 0x20, 0xd0,
    0x0f, 0x00, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00};

ALL_TESTS(room_open, room_close);

/* A document with the ids of positions and colours; `size_bytes` of the stream. */
static const char *document(const char *ids, size_t size_bytes)
{
    static char text[2048];
    room_write("d.bin", stream, sizeof stream);
    snprintf(text, sizeof text,
             "{\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": "
             "[\"KHR_draco_mesh_compression\"], \"buffers\": [{\"uri\": \"d.bin\","
             "\"byteLength\": %zu}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": %zu}],"
             "\"accessors\": [{\"componentType\": 5126, \"count\": 4, \"type\": \"VEC3\"},"
             "{\"componentType\": 5121, \"normalized\": true, \"count\": 4, \"type\": \"VEC4\"},"
             "{\"componentType\": 5125, \"count\": 6, \"type\": \"SCALAR\"}], \"meshes\":"
             "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"COLOR_0\": 1},"
             "\"indices\": 2, \"extensions\": {\"KHR_draco_mesh_compression\": {\"bufferView\": 0,"
             "\"attributes\": {%s}}}}]}], \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\":"
             "0}]}",
             sizeof stream, size_bytes, ids);
    return text;
}

#define BOTH "\"POSITION\": 7, \"COLOR_0\": 2"

TEST(vertices_and_triangles_are_what_was_encoded)
{
    static const float positions[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5f};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    struct scene s;
    assert_int_equal(room_import_text("a.gltf", document(BOTH, sizeof stream), &s), 0);
    assert_memory_equal(s.positions, positions, sizeof positions);
    assert_memory_equal(s.triangles, triangles, sizeof triangles);
    const float *c = s.colors + 4 * (size_t)s.meshes[0].first_color;
    assert_true(c[0] == 1 && c[1] == 0 && c[5] == 1 && c[10] == 1);
    assert_true(c[12] == 1 && c[15] > 0.501f && c[15] < 0.503f); /* 128 of 255 */
    scene_unmap(&s);
}

TEST(attributes_outside_the_stream_come_from_their_accessors)
{
    struct scene s;
    assert_int_equal(room_import_text("a.gltf", document("\"POSITION\": 7", sizeof stream), &s), 0);
    assert_true(s.colors[0] == 0 && s.colors[3] == 0); /* an accessor without bytes */
    scene_unmap(&s);
}

TEST(streams_that_lie_are_refused)
{
#define PLACE "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression"
    const size_t n = sizeof stream;
    room_refuses("a.gltf", document(BOTH, n - 5), ERR_CORRUPT, PLACE);
    room_refuses("a.gltf", document(BOTH, n + 1), ERR_TRUNCATED, "bufferViews[0]");
    room_refuses("a.gltf", document("\"POSITION\": 6", n), ERR_RANGE, PLACE ".attributes.POSITION");
    room_refuses("a.gltf", document("\"POSITION\": 2", n), ERR_TYPE, PLACE ".attributes.POSITION");
    room_refuses("a.gltf", document("\"POSITION\": \"x\"", n), ERR_TYPE,
                 PLACE ".attributes.POSITION");
}

/* A few bytes that claim millions of vertices or triangles, behind metadata or not. */
TEST(streams_that_claim_too_much_are_refused)
{
    static const char *const heads[] = {"DRACO\2\2\1\1\0\0\0\x80\x80\x80\x80\1\x80\x80\x80\x80\1",
                                        "DRACO\2\2\1\0\0\0\x80\x80\x80\x80\1\4",
                                        "DRACO\2\2\1\0\0\0\2\x80\x80\x80\x80\1",
                                        "DRACO\2\2\1\0\0\x80\1\7\1\1k\1v\0\0\0\x80\x80\x80\x80\1\4",
                                        "DRACO\1\1\1\1\0\0\4\2\2\4\2\2"};
    static const size_t sizes[] = {22, 17, 17, 26, 17};
    uint8_t kept[sizeof stream];
    memcpy(kept, stream, sizeof stream);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        memcpy(stream, heads[i], sizes[i]);
        room_refuses("a.gltf", document(BOTH, sizeof stream), ERR_CORRUPT, PLACE);
        assert_non_null(strstr(room_fault.detail, "bitstream 2.2"));
        memcpy(stream, kept, sizeof stream);
    }
}

TEST(damaged_bytes_do_no_harm)
{
    for (size_t i = 0; i < sizeof stream; i++)
        for (unsigned bit = 1; bit < 256; bit <<= 1) {
            struct scene s;
            stream[i] ^= (uint8_t)bit;
            if (room_import_text("a.gltf", document(BOTH, sizeof stream), &s) == 0) scene_unmap(&s);
            stream[i] ^= (uint8_t)bit;
        }
}
