/* Morph targets and skins: where vertices stand, and what is refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

/* The buffer of all documents here. */
static const struct {
    float positions[9], normals[9];
    float up[9], right[9]; /* morph targets */
    float weights[12];
    float inverse[32]; /* two matrices by columns: the identity, and one unit down */
    uint8_t joints[12];
    float short_target[6];
} data = {
    .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
    .normals = {0, 0, 1, 0, 0, 1, 0, 0, 1},
    .up = {0, 1, 0, 0, 1, 0, 0, 1, 0},
    .right = {2, 0, 0, 2, 0, 0, 2, 0, 0},
    .weights = {1, 0, 0, 0, .5f, .5f, 0, 0, 0, 2, 0, 0},
    .inverse = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
    .joints = {0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
};

#define VIEW(at, bytes) "{\"buffer\": 0, \"byteOffset\": " #at ", \"byteLength\": " #bytes "}"
#define FLOATS(view, count, type)                                                                  \
    "{\"bufferView\": " #view ", \"componentType\": 5126, \"count\": " #count                      \
    ", \"type\": \"" type "\"}"
#define BUFFERS                                                                                                                         \
    "\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"d.bin\", \"byteLength\": 356}],"                                      \
    "\"bufferViews\": [" VIEW(0, 36) "," VIEW(36, 36) "," VIEW(72, 36) "," VIEW(108, 36) "," VIEW(144, 48) "," VIEW(192, 128) "," VIEW( \
        320,                                                                                                                            \
        12) "," VIEW(332,                                                                                                               \
                     24) "],"                                                                                                           \
                         "\"accessors\": [" FLOATS(0, 3, "VEC3") "," FLOATS(1, 3, "VEC3") "," FLOATS(                                   \
                             2, 3,                                                                                                      \
                             "VEC3") "," FLOATS(3, 3,                                                                                   \
                                                "VEC3") "," FLOATS(4, 3,                                                                \
                                                                   "VEC4") "," FLOATS(5, 2,                                             \
                                                                                      "MAT4") ","                                       \
                                                                                              "{"                                       \
                                                                                              "\""                                      \
                                                                                              "bu"                                      \
                                                                                              "ff"                                      \
                                                                                              "er"                                      \
                                                                                              "Vi"                                      \
                                                                                              "ew"                                      \
                                                                                              "\""                                      \
                                                                                              ": "                                      \
                                                                                              "6,"                                      \
                                                                                              " "                                       \
                                                                                              "\""                                      \
                                                                                              "co"                                      \
                                                                                              "mp"                                      \
                                                                                              "on"                                      \
                                                                                              "en"                                      \
                                                                                              "tT"                                      \
                                                                                              "yp"                                      \
                                                                                              "e"                                       \
                                                                                              "\""                                      \
                                                                                              ": "                                      \
                                                                                              "51"                                      \
                                                                                              "21"                                      \
                                                                                              ", "                                      \
                                                                                              "\""                                      \
                                                                                              "co"                                      \
                                                                                              "un"                                      \
                                                                                              "t"                                       \
                                                                                              "\""                                      \
                                                                                              ": "                                      \
                                                                                              "3,"                                      \
                                                                                              " "                                       \
                                                                                              "\""                                      \
                                                                                              "ty"                                      \
                                                                                              "pe"                                      \
                                                                                              "\""                                      \
                                                                                              ": "                                      \
                                                                                              "\""                                      \
                                                                                              "VE"                                      \
                                                                                              "C4"                                      \
                                                                                              "\""                                      \
                                                                                              "}"                                       \
                                                                                              "," FLOATS(                               \
                                                                                                  7,                                    \
                                                                                                  2,                                    \
                                                                                                  "VEC3") "]"
#define DOCUMENT(rest) "{" BUFFERS "," rest "}"
#define MORPHED(weights)                                                                           \
    "{" weights "\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"targets\": ["              \
    "{\"POSITION\": 2}, {\"POSITION\": 3}]}]}"
#define SKINNED                                                                                    \
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"NORMAL\": 1,"             \
    "\"JOINTS_0\": 6, \"WEIGHTS_0\": 4}}]}]"

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    _Static_assert(sizeof data == 356, "as the documents say");
    room_write("d.bin", &data, sizeof data);
    return 0;
}

ALL_TESTS(set_up, room_close);

/* Whether the three vertices of a mesh stand where they are expected, up to rounding. */
static bool stand_at(const struct scene *s, uint32_t mesh, const float expected[9])
{
    const float *p = s->positions + 3 * (size_t)s->meshes[mesh].first_vertex;
    for (int i = 0; i < 9; i++)
        if (!(fabsf(p[i] - expected[i]) < 1e-6f)) return false;
    return true;
}

TEST(default_weights_apply_without_animation)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MORPHED(
        "\"weights\": [1, 0.5],") "], \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(stand_at(&s, 0, (const float[9]){1, 1, 0, 2, 1, 0, 1, 2, 0}));
    scene_unmap(&s);
}

TEST(weights_of_a_node_stand_in_place_of_the_mesh_s)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MORPHED(
        "\"weights\": [1, 0],") "], \"scenes\": [{\"nodes\": [0, "
                                "1, 2]}], \"nodes\": [{\"mesh\": 0, \"weights\": [0, 1]}, "
                                "{\"mesh\": 0},"
                                "{\"mesh\": 0, \"weights\": [0, 0], \"translation\": [0, 0, 5]}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_INSTANCES], 3);
    const float rows[3][9] = {{0, 1, 0, 1, 1, 0, 0, 2, 0}, /* the mesh's own comes first */
                              {2, 0, 0, 3, 0, 0, 2, 1, 0},
                              {0, 0, 5, 1, 0, 5, 0, 1, 5}};
    for (uint32_t i = 0; i < 3; i++) assert_true(stand_at(&s, s.instances[i].mesh, rows[i]));
    scene_unmap(&s);
}

TEST(targets_without_weights_rest)
{
    struct scene s;
    const char *text = DOCUMENT("\"meshes\": [" MORPHED(
        "") "], \"scenes\": [{\"nodes\": [0, 1]}],"
            "\"nodes\": [{\"mesh\": 0}, {\"mesh\": 0, \"translation\": [0, 0, 5]}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(stand_at(&s, 0, data.positions));
    assert_int_equal(s.count[SCENE_MESHES], 1); /* one geometry, two instances */
    scene_unmap(&s);
}

TEST(skins_stand_as_their_joints_do)
{
    struct scene s;
    /* The node of the mesh is far away, which is ignored. The second joint is turned by a right
     * angle about z, and by its inverse bind matrix turns about (0, 1). The third vertex lies on
     * that joint alone, the second in the middle of both; its weights need not sum up to 1. */
    const char *text = DOCUMENT(
        SKINNED ", \"skins\": [{\"joints\": [2, 3], \"inverseBindMatrices\": 5}],"
                "\"scenes\": [{\"nodes\": [0, 1]}], \"nodes\": [{\"mesh\": 0, \"skin\": 0,"
                "\"translation\": [0, 0, 70]}, {\"translation\": [0, 10, 0], \"children\": [2]},"
                "{\"children\": [3]}, {\"translation\": [0, 1, 0], \"rotation\": [0, 0, "
                "0.7071067811865476, 0.7071067811865476]}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(stand_at(&s, 0, (const float[9]){0, 10, 0, 1, 11, 0, 0, 11, 0}));
    assert_true(fabsf(s.normals[8] - 1) < 1e-6f);
    assert_false(room_warned("skin"));
    scene_unmap(&s);
}

TEST(mirrored_skins_keep_their_front)
{
    struct scene s;
    const char *text =
        DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [1, 1]}], \"scenes\": [{\"nodes\": [0, 1]}],"
                         "\"nodes\": [{\"mesh\": 0, \"skin\": 0}, {\"scale\": [-1, 1, 1]}]");
    const uint32_t turned[3] = {0, 2, 1};
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(stand_at(&s, 0, (const float[9]){0, 0, 0, -1, 0, 0, 0, 1, 0}));
    assert_memory_equal(s.triangles, turned, sizeof turned);
    assert_true(s.normals[2] == 1);
    scene_unmap(&s);
}

TEST(nodes_with_a_skin_keep_camera_and_light)
{
    struct scene s;
    const char *text = DOCUMENT(
        SKINNED ", \"skins\": [{\"joints\": [1, 1]}], \"cameras\": [{\"type\": \"perspective\","
                "\"perspective\": {\"yfov\": 1}}], \"scenes\": [{\"nodes\": [0, 1]}],"
                "\"nodes\": [{\"mesh\": 0, \"skin\": 0, \"camera\": 0, \"translation\": [0, 0, 7]},"
                "{\"translation\": [1, 0, 0]}]");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_true(s.cameras[0].eye[2] == 7 && s.positions[0] == 1 && s.positions[2] == 0);
    scene_unmap(&s);
}

TEST(names_what_it_refuses)
{
#define NODES "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0, \"skin\": 0}, {}]"
    static const struct {
        const char *text;
        int code;
        const char *pointer;
    } rows[] = {
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": []}], " NODES), ERR_MISSING, "skins[0]"},
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [7, 0]}], " NODES), ERR_RANGE,
         "skins[0].joints[0]"},
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [0, 1]}], " NODES), ERR_MISSING,
         "skins[0].joints[1]"},
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [0]}], " NODES), ERR_RANGE,
         "meshes[0].primitives[0].attributes.JOINTS_0[1]"},
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [0, 0, 0]}], " NODES), ERR_LIMIT, "skins[0]"},
        {DOCUMENT(SKINNED ", \"skins\": [{\"joints\": [0, 0], \"inverseBindMatrices\": 0}]," NODES),
         ERR_TYPE, "accessors[0]"},
        {DOCUMENT(SKINNED ", \"skins\": [], " NODES), ERR_RANGE, "nodes[0].skin"},
        {DOCUMENT("\"meshes\": [{\"weights\": [1], \"primitives\": [{\"attributes\": {\"POSITION\":"
                  "0}, \"targets\": [{\"POSITION\": 7}]}]}], \"scenes\": [{\"nodes\": [0]}],"
                  "\"nodes\": [{\"mesh\": 0}]"),
         ERR_MISMATCH, "meshes[0].primitives[0].targets[0].POSITION"},
        {DOCUMENT("\"meshes\": [" MORPHED(
             "\"weights\": [1, \"x\"],") "], \"scenes\": [{\"nodes\": [0]}], \"nodes\": "
                                         "[{\"mesh\": 0}]"),
         ERR_TYPE, "meshes[0].weights[1]"},
        {DOCUMENT("\"meshes\": [" MORPHED("") "], \"scenes\": [{\"nodes\": [0]}], \"nodes\": "
                                              "[{\"mesh\": 0, \"weights\": [1e9]}]"),
         ERR_RANGE, "nodes[0].weights[0]"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        room_refuses("a.gltf", rows[i].text, rows[i].code, rows[i].pointer);
}
