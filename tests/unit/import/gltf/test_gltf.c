/* glTF documents, small enough to read: what becomes of them, and what they are refused for. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/plan.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

/* The buffer that all documents here share: a square's positions, then 16-bit indices. */
struct square {
    float positions[12];
    uint16_t indices[6];
    uint16_t sparse_index;
    float sparse_value[3];
};
static const struct square square = {
    {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3}, 2, {2, 2, 0}};

#define BUFFERS                                                                                    \
    "\"asset\": {\"version\": \"2.0\"},"                                                           \
    "\"buffers\": [{\"uri\": \"square.bin\", \"byteLength\": 76}],"                                \
    "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 48},"                                       \
    "  {\"buffer\": 0, \"byteOffset\": 48, \"byteLength\": 14},"                                   \
    "  {\"buffer\": 0, \"byteOffset\": 64, \"byteLength\": 12}]"
#define ACCESSORS                                                                                  \
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4, \"type\": "        \
    "\"VEC3\"}, {\"bufferView\": 1, \"componentType\": 5123, \"count\": 6, \"type\": \"SCALAR\"}]"
#define ACCESSORS_AND(more)                                                                        \
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4, \"type\": "        \
    "\"VEC3\"}, {\"bufferView\": 1, \"componentType\": 5123, \"count\": 6, \"type\": "             \
    "\"SCALAR\"}," more "]"
#define MESH "{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}]}"
#define LAMP                                                                                       \
    "{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1, \"material\": 0}]}"
#define SCENE(nodes)                                                                               \
    "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"children\": [1, 2, 3]}, " nodes "]"
#define DOCUMENT(rest) "{" BUFFERS "," ACCESSORS "," rest "}"
#define ONE_NODE       "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}]"

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    _Static_assert(sizeof square == 76, "as the documents say");
    room_write("square.bin", &square, sizeof square);
    return 0;
}

ALL_TESTS(set_up, room_close);

TEST(reads_a_square)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MESH "]," ONE_NODE);
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_TRIANGLES], 2);
    assert_int_equal(s.count[SCENE_MATERIALS], 1);
    assert_int_equal(s.count[SCENE_CAMERAS], 1);
    assert_int_equal(s.cameras[0].is_default, 1);
    assert_true(s.cameras[0].eye[2] > 1 && s.cameras[0].forward[2] < -0.9f);
    assert_int_equal(s.meshes[0].flags, 0);
    assert_int_equal(s.meshes[0].first_uv[0], SCENE_NONE);
    assert_memory_equal(s.positions, square.positions, sizeof square.positions);
    assert_true(s.info->bounds_max[0] == 1 && s.info->bounds_min[1] == 0);
    scene_unmap(&s);
}

TEST(bakes_one_and_instances_many)
{
    struct scene s;
    const char *one = DOCUMENT("\"meshes\": [" MESH
                               "]," SCENE("{\"mesh\": 0, \"translation\": [5, 0, 0]}, {}, {}"));
    const char *many = DOCUMENT("\"meshes\": [" MESH "]," SCENE(
        "{\"mesh\": 0, \"name\": \"left\"}, {\"mesh\": 0, \"translation\": [5, 0, 0]}, {}"));
    assert_int_equal(room_import_text("a.gltf", one, &s), 0);
    assert_int_equal(s.instances[0].flags, INSTANCE_IDENTITY);
    assert_true(s.positions[0] == 5);
    scene_unmap(&s);
    assert_int_equal(room_import_text("a.gltf", many, &s), 0);
    assert_int_equal(s.count[SCENE_MESHES], 1);
    assert_int_equal(s.count[SCENE_INSTANCES], 2);
    assert_int_equal(s.count[SCENE_TRIANGLES], 2);
    assert_int_equal(s.info->placed_triangles, 4);
    assert_true(s.instances[1].to_world[3] == 5 && s.positions[0] == 0);
    assert_string_equal(scene_name(&s, s.instances[0].name), "left");
    assert_true(s.info->bounds_max[0] == 6);
    scene_unmap(&s);
}

TEST(shares_geometry_between_materials)
{
    struct scene s;
    const char *text = DOCUMENT("\"materials\": [{}, {}], \"meshes\": [" MESH "," LAMP "]," SCENE(
        "{\"mesh\": 0}, {\"mesh\": 1, \"translation\": [5, 0, 0]}, {}"));
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_MESHES], 2);
    assert_int_equal(s.count[SCENE_TRIANGLES], 2);
    assert_int_equal(s.meshes[0].first_vertex, s.meshes[1].first_vertex);
    assert_int_equal(s.meshes[0].material, 2); /* the default comes after the file's own */
    assert_int_equal(s.meshes[1].material, 0);
    scene_unmap(&s);
}

/* z of a triangle's normal in the world. */
static double front_z(const struct scene *s, uint32_t instance)
{
    const struct scene_instance *in = &s->instances[instance];
    const struct scene_mesh *mesh = &s->meshes[in->mesh];
    const uint32_t *t = s->triangles + 3 * mesh->first_triangle;
    double p[3][2];
    for (int k = 0; k < 3; k++) {
        const float *v = s->positions + 3 * (mesh->first_vertex + t[k]);
        for (int r = 0; r < 2; r++) {
            const float *m = in->to_world + 4 * r;
            p[k][r] = (double)(m[0] * v[0] + m[1] * v[1] + m[2] * v[2] + m[3]);
        }
    }
    return (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
}

TEST(mirrored_placements_keep_their_front)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MESH "]," SCENE(
        "{\"mesh\": 0}, {\"mesh\": 0, \"scale\": [-1, 1, 1]},"
        "{\"mesh\": 0, \"scale\": [-2, 1, 1], \"translation\": [3, 0, 0]}"));
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_INSTANCES], 3);
    for (uint32_t i = 0; i < 3; i++) assert_true(front_z(&s, i) > 0);
    assert_true(s.info->bounds_min[0] == -1 && s.info->bounds_max[0] == 3);
    scene_unmap(&s);
}

TEST(flattened_placements_are_baked)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MESH "]," SCENE(
        "{\"mesh\": 0, \"scale\": [1, 1, 0]}, {\"mesh\": 0, \"scale\": [2, 2, 0]}, {}"));
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_MESHES], 2);
    assert_int_equal(s.instances[1].flags, INSTANCE_IDENTITY);
    scene_unmap(&s);
}

TEST(makes_lamps_lights)
{
    struct scene s;
    const char *text =
        DOCUMENT("\"materials\": [{\"emissiveFactor\": [1, 0.5, 0], \"extensions\": "
                 "{\"KHR_materials_emissive_strength\": {\"emissiveStrength\": 40}}}],"
                 "\"meshes\": [" LAMP "]," ONE_NODE);
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_LIGHTS], 1);
    assert_int_equal(s.meshes[0].flags, MESH_IS_LIGHT);
    assert_true(s.lights[0].color[0] == 40 && s.lights[0].color[1] == 20);
    assert_true(s.lights[0].direction[2] == 1);
    assert_true(s.materials[0].emission[0] == 40);
    scene_unmap(&s);
}

TEST(emission_may_be_at_its_limit)
{
    struct scene s;
    const char *text =
        DOCUMENT("\"materials\": [{\"emissiveFactor\": [1, 0, 0], \"extensions\": "
                 "{\"KHR_materials_emissive_strength\": {\"emissiveStrength\": 1e12}}}],"
                 "\"meshes\": [" LAMP "]," ONE_NODE);
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(s.materials[0].emission[0] == 1e12f);
    scene_unmap(&s);
}

TEST(reads_punctual_lights)
{
    struct scene s;
    const char *text = DOCUMENT(
        "\"meshes\": [" MESH "], \"extensions\": {\"KHR_lights_punctual\": {\"lights\": ["
        "{\"type\": \"point\", \"intensity\": 3, \"range\": 9},"
        "{\"type\": \"spot\", \"spot\": {\"innerConeAngle\": 0.5, \"outerConeAngle\": 0.5}},"
        "{\"type\": \"directional\", \"color\": [0, 0, 0]}]}},"
        "\"scenes\": [{\"nodes\": [0, 1, 2, 3]}], \"nodes\": [{\"mesh\": 0},"
        "{\"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}, \"translation\": [1, 2, 3]},"
        "{\"extensions\": {\"KHR_lights_punctual\": {\"light\": 1}}},"
        "{\"extensions\": {\"KHR_lights_punctual\": {\"light\": 2}}}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_LIGHTS], 2); /* the black one lights nothing */
    assert_int_equal(s.lights[0].type, LIGHT_POINT);
    assert_true(s.lights[0].position[1] == 2 && s.lights[0].range == 9);
    assert_int_equal(s.lights[1].type, LIGHT_SPOT);
    assert_true(s.lights[1].cos_inner > s.lights[1].cos_outer);
    assert_true(s.lights[1].direction[2] == -1);
    scene_unmap(&s);
}

TEST(reads_cameras)
{
    struct scene s;
    const char *text = DOCUMENT(
        "\"meshes\": [" MESH "], \"cameras\": [{\"type\": \"perspective\", \"name\": \"wide\","
        "\"perspective\": {\"yfov\": 1.2, \"aspectRatio\": 2, \"znear\": 0.1}},"
        "{\"type\": \"orthographic\", \"orthographic\": {\"xmag\": 3, \"ymag\": 2,"
        "\"znear\": 0, \"zfar\": 9}}], \"scenes\": [{\"nodes\": [0, 1, 2]}],"
        "\"nodes\": [{\"mesh\": 0}, {\"camera\": 0, \"scale\": [3, 3, 3],"
        "\"rotation\": [0, 0.7071067811865476, 0, 0.7071067811865476]},"
        "{\"camera\": 1, \"name\": \"plan\", \"scale\": [-1, 1, 1]}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_CAMERAS], 2);
    assert_true(fabsf(s.cameras[0].yfov_rad - 1.2f) < 1e-6f && s.cameras[0].aspect == 2);
    assert_true(fabsf(s.cameras[0].forward[0] + 1) < 1e-6f); /* turned to look along -x */
    assert_string_equal(scene_name(&s, s.cameras[0].name), "wide");
    assert_int_equal(s.cameras[1].type, CAMERA_ORTHOGRAPHIC);
    assert_true(s.cameras[1].half_width == 3 && s.cameras[1].half_height == 2);
    assert_string_equal(scene_name(&s, s.cameras[1].name), "plan");
    assert_true(s.cameras[1].right[0] == 1); /* mirroring does not reach cameras */
    scene_unmap(&s);
}

TEST(reads_sparse_accessors)
{
    struct scene s;
    const char *text =
        "{" BUFFERS ", \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 4,"
        "\"type\": \"VEC3\", \"sparse\": {\"count\": 1, \"indices\": {\"bufferView\": 1,"
        "\"byteOffset\": 12, \"componentType\": 5123}, \"values\": {\"bufferView\": 2}}},"
        "{\"bufferView\": 1, \"componentType\": 5123, \"count\": 6, \"type\": "
        "\"SCALAR\"}], \"meshes\": [" MESH "]," ONE_NODE "}";
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(s.positions[6] == 2 && s.positions[7] == 2);
    scene_unmap(&s);
}

TEST(reads_strips_and_fans)
{
    struct scene s;
    const char *fan = DOCUMENT("\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0},"
                               "\"mode\": 6}]}]," ONE_NODE);
    const char *strip =
        DOCUMENT("\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0},"
                 "\"mode\": 5}]}]," ONE_NODE);
    const uint32_t fanned[] = {1, 2, 0, 2, 3, 0}, stripped[] = {0, 1, 2, 1, 3, 2};
    assert_int_equal(room_import_text("a.gltf", fan, &s), 0);
    assert_memory_equal(s.triangles, fanned, sizeof fanned);
    scene_unmap(&s);
    assert_int_equal(room_import_text("a.gltf", strip, &s), 0);
    assert_memory_equal(s.triangles, stripped, sizeof stripped);
    scene_unmap(&s);
}

TEST(warns_of_what_it_ignores)
{
    struct scene s;
    const char *text =
        DOCUMENT("\"extensionsUsed\": [\"MSFT_lod\", \"KHR_materials_ior\"],"
                 "\"materials\": [{}],"
                 "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"mode\": 1},"
                 "{\"attributes\": {\"POSITION\": 0}, \"indices\": 1, \"targets\": []}]}],"
                 "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(room_warned("MSFT_lod"));
    assert_false(room_warned("KHR_materials_ior"));
    assert_true(room_warned("points and lines"));
    assert_true(strstr(s.warnings, "MSFT_lod") != NULL);
    scene_unmap(&s);
}

TEST(reads_vertex_colours)
{
    /* Three components as floats, and the positions' first bytes as four normalised ones. */
    struct scene s;
    const char *text = "{" BUFFERS ", " ACCESSORS_AND(
        "{\"bufferView\": 0, \"componentType\": 5121, \"normalized\": true, \"count\": 4,"
        "\"byteOffset\": 12, \"type\": \"VEC4\"}") ", \"meshes\": [{\"primitives\": ["
                                                   "{\"attributes\": {\"POSITION\": 0, "
                                                   "\"COLOR_0\": 0}, \"indices\": 1},"
                                                   "{\"attributes\": {\"POSITION\": 0, "
                                                   "\"COLOR_0\": 2}, \"indices\": 1},"
                                                   "{\"attributes\": {\"POSITION\": 0}, "
                                                   "\"indices\": 1}]}]," ONE_NODE "}";
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_MATERIALS], 2); /* the default one, and its coloured copy */
    for (uint32_t i = 0; i < 3; i++) {
        const struct scene_mesh *m = &s.meshes[i];
        const bool colored = s.materials[m->material].flags & MATERIAL_COLORED;
        assert_int_equal(colored, i < 2);
        assert_int_equal((m->flags & MESH_HAS_COLORS) != 0, i < 2);
    }
    const float *c = s.colors + 4 * (size_t)s.meshes[0].first_color;
    for (int v = 0; v < 4; v++) {
        assert_true(c[4 * v] == square.positions[3 * v] && c[4 * v + 3] == 1);
        assert_true(c[4 * v + 1] == square.positions[3 * v + 1]);
    }
    c = s.colors + 4 * (size_t)s.meshes[1].first_color; /* of 1.0f: 00 00 80 3f */
    assert_true(c[0] == 0 && c[2] == 128 / 255.0f && c[3] == 63 / 255.0f);
    scene_unmap(&s);
}

TEST(names_what_it_refuses)
{
    static const struct {
        const char *text;
        int code;
        const char *pointer;
    } rows[] = {
        {"", ERR_TRUNCATED, ""},
        {"hello", ERR_MAGIC, ""},
        {"{\"asset\": {\"version\": \"1.0\"}}", ERR_VERSION, "asset.version"},
        {"{\"asset\": {\"version\": \"2.0\"}}", ERR_MISSING, "scene"},
        {DOCUMENT("\"extensionsRequired\": [\"KHR_texture_basisu\"]"), ERR_UNSUPPORTED,
         "extensionsRequired[0]"},
        {DOCUMENT("\"meshes\": {}"), ERR_TYPE, "meshes"},
        {DOCUMENT("\"meshes\": [" MESH "], \"scene\": 1, " ONE_NODE), ERR_RANGE, "scene"},
        {DOCUMENT("\"meshes\": [" MESH "], \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": "
                  "1}]"),
         ERR_RANGE, "nodes[0].mesh"},
        {DOCUMENT("\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"children\": [0]}]"), ERR_CORRUPT,
         "nodes[0]"},
        {DOCUMENT("\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": "
                  "7}]}]," ONE_NODE),
         ERR_RANGE, "meshes[0].primitives[0].indices"},
        {DOCUMENT("\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": "
                  "0}]}]," ONE_NODE),
         ERR_TYPE, "accessors[0]"},
        {"{" BUFFERS ", " ACCESSORS_AND(
             "{\"componentType\": 5126, \"count\": 4, \"type\": \"MAT4\"}") /* of zeros */
         ", \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"COLOR_0\": "
         "2}}]}]," ONE_NODE "}",
         ERR_TYPE, "accessors[2]"},
        {DOCUMENT("\"meshes\": [{\"primitives\": [{}]}]," ONE_NODE), ERR_MISSING,
         "meshes[0].primitives[0].attributes"},
        {DOCUMENT("\"materials\": [{\"pbrMetallicRoughness\": {\"roughnessFactor\": 1.7}}]"),
         ERR_RANGE, "materials[0].pbrMetallicRoughness.roughnessFactor"},
        {DOCUMENT("\"materials\": [{\"alphaMode\": \"MIX\"}]"), ERR_RANGE,
         "materials[0].alphaMode"},
        {DOCUMENT("\"materials\": [{\"normalTexture\": {\"index\": 0}}]"), ERR_RANGE,
         "materials[0].normalTexture.index"},
        {"{" BUFFERS ", \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 5,"
         "\"type\": \"VEC3\"}], \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": "
         "0}}]}]," ONE_NODE "}",
         ERR_TRUNCATED, "accessors[0]"},
        {"{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"gone.bin\", "
         "\"byteLength\": 48}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 48}]," ACCESSORS
         ", \"meshes\": [" MESH "]," ONE_NODE "}",
         ERR_NOT_FOUND, "buffers[0].uri"},
        {"{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"../square.bin\", "
         "\"byteLength\": 48}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 48}]," ACCESSORS
         ", \"meshes\": [" MESH "]," ONE_NODE "}",
         ERR_RANGE, "buffers[0].uri"},
        {DOCUMENT("\"meshes\": [" MESH "], \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": "
                  "0, \"translation\": [1e16, 0, 0]}]"),
         ERR_LIMIT, "meshes[0].primitives[0].positions in the world[0]"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        room_refuses("a.gltf", rows[i].text, rows[i].code, rows[i].pointer);
}

TEST(refuses_deep_nesting)
{
    struct scene s;
    static char text[65536];
    size_t n = (size_t)snprintf(text, sizeof text,
                                "{\"asset\": {\"version\": \"2.0\"}, \"scenes\": [{\"nodes\": "
                                "[0]}], \"nodes\": [");
    for (int i = 0; i < 400; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "{\"children\": [%d]},", i + 1);
    snprintf(text + n, sizeof text - n, "{}]}");
    assert_int_equal(room_import_text("a.gltf", text, &s), ERR_LIMIT);
}

TEST(same_file_same_bytes)
{
    struct scene s;
    const char *text = DOCUMENT("\"materials\": [{}], \"meshes\": [" MESH "," LAMP "]," SCENE(
        "{\"mesh\": 0}, {\"mesh\": 1, \"translation\": [5, 0, 0]}, {\"mesh\": 1}"));
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    size_t size_bytes = s.blob_bytes;
    void *first = malloc(size_bytes);
    assert_non_null(first);
    memcpy(first, s.blob, size_bytes);
    scene_unmap(&s);
    assert_int_equal(room_import_text("b", text, &s), 0); /* and a name without extension */
    assert_int_equal(s.blob_bytes, size_bytes);
    assert_memory_equal(s.blob, first, size_bytes);
    scene_unmap(&s);
    free(first);
}
