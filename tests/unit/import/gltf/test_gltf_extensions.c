/* Extensions that say what stands where, and what it is made of. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

/* A triangle, then three places with turns and sizes, and a turn of no length. */
static const struct {
    float positions[9];
    float translations[9], rotations[12], scales[9];
    float none[4];
} data = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
          .translations = {0, 0, 0, 5, 0, 0, 0, 0, 7},
          .rotations = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f, 0, 0, 0, 1},
          .scales = {1, 1, 1, 2, 2, 2, 1, 1, -1}};

#define VIEW(at, bytes) "{\"buffer\": 0, \"byteOffset\": " #at ", \"byteLength\": " #bytes "}"
#define FLOATS(view, count, type)                                                                  \
    "{\"bufferView\": " #view ", \"componentType\": 5126, \"count\": " #count                      \
    ", \"type\": \"" type "\"}"
#define DOCUMENT(rest)                                                                                                                   \
    "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"d.bin\", \"byteLength\": "                                            \
    "172}],"                                                                                                                             \
    "\"bufferViews\": [" VIEW(0, 36) "," VIEW(36, 36) "," VIEW(72, 48) "," VIEW(120, 36) "," VIEW(156, 16) "], \"accessors\": [" FLOATS( \
        0, 3,                                                                                                                            \
        "VEC3") "," FLOATS(1, 3,                                                                                                         \
                           "VEC3") "," FLOATS(2, 3,                                                                                      \
                                              "VEC4") "," FLOATS(3, 3,                                                                   \
                                                                 "VEC3") "," FLOATS(4, 1,                                                \
                                                                                    "VEC4") ","                                          \
                                                                                            "{\"c"                                       \
                                                                                            "ompo"                                       \
                                                                                            "nent"                                       \
                                                                                            "Type"                                       \
                                                                                            "\": "                                       \
                                                                                            "5126"                                       \
                                                                                            ", "                                         \
                                                                                            "\"co"                                       \
                                                                                            "unt"                                        \
                                                                                            "\": "                                       \
                                                                                            "3, "                                        \
                                                                                            "\"ty"                                       \
                                                                                            "pe\""                                       \
                                                                                            ": "                                         \
                                                                                            "\"VE"                                       \
                                                                                            "C3\""                                       \
                                                                                            "}]"                                         \
                                                                                            "," rest                                     \
                                                                                            "}"
#define MESHES      "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}]"
#define NODES(list) "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [" list "]"

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    _Static_assert(sizeof data == 172, "as the documents say");
    room_write("d.bin", &data, sizeof data);
    room_choice = (struct scene_choice){0};
    return 0;
}

ALL_TESTS(set_up, room_close);

#define INSTANCED(attributes)                                                                      \
    DOCUMENT(MESHES                                                                                \
             "," NODES("{\"mesh\": 0, \"translation\": [0, 0, 1], \"extensions\": "                \
                       "{\"EXT_mesh_gpu_instancing\": {\"attributes\": {" attributes "}}}}"))

TEST(nodes_stand_as_often_as_they_are_instanced)
{
    struct scene s;
    const char *text = INSTANCED("\"TRANSLATION\": 1, \"ROTATION\": 2, \"SCALE\": 3");
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_INSTANCES], 3);
    assert_int_equal(s.info->placed_triangles, 3);
    /* Plain ones come first: the first instance, and the second, turned and doubled. */
    const float *first = s.instances[0].to_world, *second = s.instances[1].to_world;
    assert_true(first[3] == 0 && first[11] == 1);
    assert_true(second[3] == 5 && second[11] == 1 && fabsf(second[4] - 2) < 1e-6f);
    assert_true(s.info->bounds_max[2] == 8); /* the mirrored one stands seven in front */
    scene_unmap(&s);
    assert_int_equal(room_import_text("a.gltf", INSTANCED("\"TRANSLATION\": 5"), &s), 0);
    assert_int_equal(s.count[SCENE_INSTANCES], 3); /* an accessor without bytes is zeros */
    scene_unmap(&s);
}

TEST(instances_that_lie_are_refused)
{
    room_refuses("a.gltf", INSTANCED("\"TRANSLATION\": 1, \"ROTATION\": 4"), ERR_MISMATCH,
                 "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.ROTATION");
    room_refuses("a.gltf", INSTANCED("\"ROTATION\": 4"), ERR_NOT_FINITE,
                 "nodes[0].extensions.EXT_mesh_gpu_instancing[0]");
    room_refuses("a.gltf", INSTANCED("\"SCALE\": 9"), ERR_RANGE,
                 "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.SCALE");
}

#define HIDDEN "\"extensions\": {\"KHR_node_visibility\": {\"visible\": false}}"
#define SHOWN  "\"extensions\": {\"KHR_node_visibility\": {\"visible\": true}}"

TEST(hidden_nodes_hide_what_is_beneath_them)
{
    struct scene s;
    const char *text = DOCUMENT(
        MESHES
        ", \"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 1}}]," NODES(
            "{\"children\": [1, 2]}, {" SHOWN ", \"mesh\": 0},"
            "{" HIDDEN ", \"mesh\": 0, \"children\": [3, 4]}, {" SHOWN ", \"mesh\": 0},"
            "{\"camera\": 0}"));
    assert_int_equal(room_import_text("a.gltf", text, &s), 0);
    assert_int_equal(s.count[SCENE_INSTANCES], 1);
    assert_int_equal(s.cameras[0].is_default, 0);
    scene_unmap(&s);
}

#define VARIANTS                                                                                   \
    "\"extensions\": {\"KHR_materials_variants\": {\"variants\": [{\"name\": \"oak\"},"            \
    "{\"name\": \"rosewood\"}]}}, \"materials\": [{\"name\": \"own\"}, {\"name\": \"red\"}],"      \
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 0,"          \
    "\"extensions\": {\"KHR_materials_variants\": {\"mappings\": [{\"material\": 1,"               \
    "\"variants\": [1]}]}}}]}]"

static const char *material_in(const char *variant, struct scene *s)
{
    room_choice.variant = variant;
    assert_int_equal(room_import_text("a.gltf", DOCUMENT(VARIANTS "," NODES("{\"mesh\": 0}")), s),
                     0);
    return scene_name(s, s->materials[s->meshes[0].material].name);
}

TEST(variants_are_chosen_by_name)
{
    struct scene s;
    assert_string_equal(material_in(NULL, &s), "own");
    scene_unmap(&s);
    assert_string_equal(material_in("oak", &s), "own"); /* it maps nothing there */
    scene_unmap(&s);
    assert_string_equal(material_in("rosewood", &s), "red");
    scene_unmap(&s);
    room_choice.variant = "pine";
    room_refuses("a.gltf", DOCUMENT(VARIANTS "," NODES("{\"mesh\": 0}")), ERR_NOT_FOUND,
                 "extensions.KHR_materials_variants.variants");
    assert_non_null(strstr(room_fault.detail, "it has \"oak\", \"rosewood\""));
    room_refuses("a.gltf", DOCUMENT(MESHES "," NODES("{\"mesh\": 0}")), ERR_NOT_FOUND,
                 "extensions.KHR_materials_variants.variants");
    room_choice = (struct scene_choice){0};
}

TEST(basis_textures_are_refused_with_what_to_do)
{
    room_refuses("a.gltf",
                 DOCUMENT("\"extensionsRequired\": [\"KHR_texture_basisu\"]," MESHES
                          "," NODES("{\"mesh\": 0}")),
                 ERR_UNSUPPORTED, "extensionsRequired[0]");
    assert_non_null(strstr(room_fault.detail, "KHR_texture_basisu"));
    assert_non_null(strstr(room_fault.detail, "write them as PNG"));
}

TEST(textures_with_basis_images_alone_are_warned_of_with_what_to_do)
{
    struct scene s;
    int rc = room_import_text(
        "a.gltf",
        DOCUMENT("\"extensionsUsed\": [\"KHR_texture_basisu\"],"
                 "\"images\": [{\"uri\": \"a.ktx2\"}], \"textures\": [{\"extensions\":"
                 "{\"KHR_texture_basisu\": {\"source\": 0}}}], \"materials\": [{"
                 "\"emissiveTexture\": {\"index\": 0}}]," MESHES "," NODES("{\"mesh\": 0}")),
        &s);
    assert_int_equal(rc, 0);
    scene_unmap(&s);
    assert_true(room_warned("is ignored: its images are KTX2; write them as PNG"));
}
