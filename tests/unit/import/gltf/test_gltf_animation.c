/* Animations: where things stand at a time, by closed forms, and what is refused. */
#include <math.h>
#include <string.h>

#include "tests/unit/import/gltf/animated_case.h"

static int set_up(void **state)
{
    room_choice = (struct scene_choice){0};
    if (room_open(state) != 0) return -1;
    room_write("d.bin", series, sizeof series);
    return 0;
}

ALL_TESTS(set_up, room_close);

static struct scene at(const char *rest, double time_s)
{
    struct scene s;
    room_choice.time_s = time_s;
    const int rc = room_import_text("a.gltf", document(rest), &s);
    if (rc != 0) print_error("%s: %s\n", room_fault.pointer, room_fault.detail);
    assert_int_equal(rc, 0);
    assert_int_equal(s.info->flags, SCENE_MOVES);
    return s;
}

/* The triangle's first vertex, or another, stands there. Its vertices keep their order. */
static void stands(const char *rest, double time_s, unsigned vertex, float x, float y, float z)
{
    struct scene s = at(rest, time_s);
    const float *p = s.positions + 3 * vertex;
    if (!(fabsf(p[0] - x) < 1e-6f && fabsf(p[1] - y) < 1e-6f && fabsf(p[2] - z) < 1e-6f))
        print_error("at %g s: %g %g %g\n", time_s, (double)p[0], (double)p[1], (double)p[2]);
    assert_true(fabsf(p[0] - x) < 1e-6f && fabsf(p[1] - y) < 1e-6f && fabsf(p[2] - z) < 1e-6f);
    scene_unmap(&s);
}

TEST(keys_are_joined_by_lines)
{
    const char *text = MOVED("times", "steps", "LINEAR", "translation");
    stands(text, -5, 0, 0, 0, 0);
    stands(text, 1, 0, 0, 0, 0);
    stands(text, 1.5, 0, 1, 0, 0);
    stands(text, 2, 0, 2, 0, 0);
    stands(text, 3.5, 0, 2, 6, 0);
    stands(text, 4, 0, 2, 8, 0);
    stands(text, 1e9, 0, 2, 8, 0);
}

TEST(steps_hold_until_the_next_key)
{
    const char *text = MOVED("times", "steps", "STEP", "translation");
    stands(text, 1.999, 0, 0, 0, 0);
    stands(text, 2, 0, 2, 0, 0);
    stands(text, 3.999, 0, 2, 0, 0);
    stands(text, 4, 0, 2, 8, 0);
}

/* From 1 at 1 s, leaving with 2 a second, to 3 at 2 s, arriving with -1: in the middle
 * 1/2 1 + 1/8 2 + 1/2 3 - 1/8 (-1). The second span lasts two seconds: y from 0, leaving with 4, to
 * 5, arriving with 0: 1/2 0 + 2/8 4 + 1/2 5. */
TEST(splines_follow_their_tangents)
{
    const char *text = MOVED("times", "cubic", "CUBICSPLINE", "translation");
    stands(text, 0, 0, 1, 0, 0);
    stands(text, 1.5, 0, 2.375f, 0, 0);
    stands(text, 2, 0, 3, 0, 0);
    stands(text, 3, 0, 4, 3.5f, 2.5f);
    stands(text, 4, 0, 5, 5, 5);
}

/* A quarter in the first second; the second quarter, by the shorter way, in the next two. */
TEST(turns_have_constant_speed)
{
    const char *text = MOVED("times", "turns", "LINEAR", "rotation");
    const float pi = 3.14159265f;
    for (int i = 0; i <= 8; i++) {
        const double t = 1 + i / 8.0;
        stands(text, t, 1, cosf(pi / 16 * (float)i), sinf(pi / 16 * (float)i), 0);
        stands(text, 2 + i / 4.0, 2, -sinf(pi / 2 + pi / 16 * (float)i),
               cosf(pi / 2 + pi / 16 * (float)i), 0);
    }
    /* A spline of quaternions is one of length 1: from 2 w to 2 z, in the middle w + z. */
    stands(MOVED("times", "cubic_turns", "CUBICSPLINE", "rotation"), 1.5, 1, 0, 1, 0);
}

TEST(morphs_follow_their_weights)
{
    const char *text = MOVED("times", "weights", "LINEAR", "weights");
    stands(text, 0, 0, 0, 0, 0);
    stands(text, 1.5, 0, 0, 0, 1.5f);
    stands(text, 3, 0, 0, 0, 2.25f);
    const char *pointed = MESH NODE ANIMATIONS(
        ANIMATION("a", SAMPLER("times", "weights", "LINEAR"), POINTER(0, "/meshes/0/weights")));
    stands(pointed, 1.5, 0, 0, 0, 1.5f);
}

TEST(a_time_may_come_twice)
{
    const char *text = MOVED("twice", "steps", "LINEAR", "translation");
    stands(text, 1, 0, 2, 0, 0);
    stands(text, 2.5, 0, 2, 4, 0);
}

#define TWO                                                                                        \
    MESH NODE ANIMATIONS(ANIMATION(                                                                \
        "walk", SAMPLER("times", "steps", "LINEAR"),                                               \
        CHANNEL(0,                                                                                 \
                "translation")) "," ANIMATION("run", SAMPLER("times", "cubic", "CUBICSPLINE"),     \
                                              CHANNEL(                                             \
                                                  0,                                               \
                                                  "translation")) "," ANIMATION("turn",            \
                                                                                SAMPLER("times",   \
                                                                                        "turns",   \
                                                                                        "LINEAR"), \
                                                                                CHANNEL(           \
                                                                                    0,             \
                                                                                    "rotation")))

TEST(animations_play_by_name_or_all)
{
    stands(TWO, 1.5, 0, 1, 0, 0); /* the first of those that move the same */
    assert_true(room_warned("an earlier channel moves the same"));
    stands(TWO, 2, 1, 2, 1, 0); /* and the turn */
    room_choice.animation = "run";
    stands(TWO, 1.5, 0, 2.375f, 0, 0);
    assert_false(room_warned("an earlier channel"));
    room_choice.animation = "fly";
    room_refuses("a.gltf", document(TWO), ERR_NOT_FOUND, "animations");
    assert_non_null(strstr(room_fault.detail, "it has \"walk\", \"run\", \"turn\""));
    room_refuses("a.obj", "v 0 0 0\n", ERR_NOT_FOUND, "a.obj");
    room_choice.animation = NULL;
}

/* Joints are nodes: the skin's triangle follows node 1 and not its own. */
TEST(skins_follow_their_joints)
{
    const char *text =
        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": "
        "@positions}}]}], \"skins\": [{\"joints\": [1]}], \"scenes\": [{\"nodes\": "
        "[0, 1]}], \"nodes\": [{\"mesh\": 0, \"skin\": 0}, {}], "
        "\"animations\": [{\"samplers\": [" SAMPLER(
            "times", "steps",
            "LINEAR") "],"
                      "\"channels\": [{\"sampler\": 0, \"target\": {\"node\": 1, \"path\": "
                      "\"translation\"}}]}]";
    stands(text, 3.5, 0, 2, 6, 0);
}

#define SHOW                                                                                       \
    "\"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 1}}], "                 \
    "\"extensions\": {\"KHR_lights_punctual\": {\"lights\": [{\"type\": \"point\"}]}}, "           \
    "\"scenes\": [{\"nodes\": [0, 1]}], \"nodes\": [{\"camera\": 0, \"extensions\": "              \
    "{\"KHR_lights_punctual\": {\"light\": 0}}}, {\"mesh\": 0}], "

TEST(cameras_lights_and_materials_change)
{
    const char *text = MESH SHOW ANIMATIONS(ANIMATION(
        "a",
        SAMPLER("times", "steps", "LINEAR") "," SAMPLER("times", "angles", "LINEAR") "," SAMPLER(
            "times", "colors", "LINEAR") "," SAMPLER("times", "turns", "LINEAR"),
        CHANNEL(0, "translation") "," CHANNEL(3, "rotation") "," POINTER(
            1,
            "/cameras/0/"
            "perspective/"
            "yfov") "," POINTER(1,
                                "/extensions/KHR_lights_punctual/lights/"
                                "0/intensity") "," POINTER(2,
                                                           "/materials/0/pbrMetallicRoughness/"
                                                           "baseColorFactor") "," POINTER(1,
                                                                                          "/materia"
                                                                                          "ls/0/"
                                                                                          "pbrMetal"
                                                                                          "licRou"
                                                                                          "ghness/"
                                                                                          "roughnes"
                                                                                          "sFacto"
                                                                                          "r")));
    struct scene s = at(text, 1.5);
    const float half = sqrtf(.5f);
    assert_true(fabsf(s.cameras[0].yfov_rad - .75f) < 1e-6f && s.cameras[0].eye[0] == 1);
    assert_true(fabsf(s.cameras[0].up[0] + half) < 1e-6f);
    assert_true(s.lights[0].position[0] == 1 && fabsf(s.lights[0].color[0] - .75f) < 1e-6f);
    assert_true(s.materials[0].base_color[0] == .5f && s.materials[0].base_color[1] == .5f);
    assert_true(fabsf(s.materials[0].roughness - .75f) < 1e-6f);
    scene_unmap(&s);
}

TEST(nodes_are_hidden_at_times)
{
    const char *text =
        MESH "\"scenes\": [{\"nodes\": [0, 1]}], \"nodes\": [{\"mesh\": 0}, {\"mesh\": 0, "
             "\"extensions\": {\"KHR_node_visibility\": {\"visible\": true}}}], " ANIMATIONS(
                 ANIMATION("a", SAMPLER("times", "flags", "STEP"),
                           POINTER(0, "/nodes/1/extensions/KHR_node_visibility/visible")));
    struct scene s = at(text, 1.5);
    assert_int_equal(s.info->placed_triangles, 2);
    scene_unmap(&s);
    s = at(text, 2.5);
    assert_int_equal(s.info->placed_triangles, 1);
    scene_unmap(&s);
}

#define POINTED(pointer)                                                                           \
    MESH NODE ANIMATIONS(ANIMATION("a", SAMPLER("times", "weights", "LINEAR"), POINTER(0, pointer)))

static void ignores(const char *rest)
{
    struct scene s;
    room_choice.time_s = 1.5;
    assert_int_equal(room_import_text("a.gltf", document(rest), &s), 0);
    assert_true(room_warned("is not animated"));
    assert_int_equal(s.info->flags, 0);
    scene_unmap(&s);
}

TEST(what_pictures_do_not_show_stays)
{
    ignores(POINTED("/nodes/0/extras/speed"));
    ignores(POINTED("/accessors/0/count"));
    ignores(POINTED("/nodes/0/children/0"));
    ignores(POINTED("/materials/0/normalTexture/scale")); /* there is no texture */
    ignores(POINTED("/nodes/0/weights/0"));               /* there are none of the node's own */
    ignores(MESH "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0, \"matrix\": "
                 "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}], " ANIMATIONS(ANIMATION(
                     "a", SAMPLER("times", "steps", "LINEAR"), CHANNEL(0, "translation"))));
}

static void refuses(const char *rest, int code, const char *place)
{
    room_choice.time_s = 1.5;
    room_refuses("a.gltf", document(rest), code, place);
}

TEST(wrong_keys_are_refused)
{
    refuses(MOVED("back", "steps", "LINEAR", "translation"), ERR_RANGE,
            "animations[0].samplers[0].input[2]");
    refuses(MOVED("nan", "steps", "LINEAR", "translation"), ERR_NOT_FINITE,
            "animations[0].samplers[0].input[1]");
    refuses(MOVED("times", "lost", "LINEAR", "translation"), ERR_NOT_FINITE,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "nowhere", "LINEAR", "rotation"), ERR_RANGE,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "steps", "CUBICSPLINE", "translation"), ERR_MISMATCH,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "cubic", "LINEAR", "translation"), ERR_MISMATCH,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "turns", "LINEAR", "translation"), ERR_TYPE,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "steps", "LINEAR", "rotation"), ERR_TYPE,
            "animations[0].samplers[0].output");
    refuses(MOVED("times", "steps", "LINEAR", "weights"), ERR_TYPE,
            "animations[0].samplers[0].output");
    refuses(MOVED("steps", "steps", "LINEAR", "translation"), ERR_TYPE, "accessors[3]");
    refuses(MOVED("times", "steps", "QUADRATIC", "translation"), ERR_RANGE,
            "animations[0].samplers[0].interpolation");
}

#define BROKEN(samplers, channels)                                                                 \
    MESH NODE "\"animations\": [{\"samplers\": [" samplers "], \"channels\": [" channels "]}]"
#define GOOD SAMPLER("times", "steps", "LINEAR")

TEST(wrong_channels_are_refused)
{
    refuses(BROKEN(GOOD, "{\"sampler\": 1, \"target\": {\"node\": 0, \"path\": \"scale\"}}"),
            ERR_RANGE, "animations[0].channels[0].sampler");
    refuses(BROKEN(GOOD, "{\"sampler\": 0, \"target\": {\"node\": 7, \"path\": \"scale\"}}"),
            ERR_RANGE, "animations[0].channels[0].target.node");
    refuses(BROKEN(GOOD, "{\"sampler\": 0}"), ERR_MISSING, "animations[0].channels[0].target");
    refuses(BROKEN(GOOD, "{\"target\": {\"node\": 0, \"path\": \"scale\"}}"), ERR_MISSING,
            "animations[0].channels[0]");
    refuses(BROKEN(GOOD, "3"), ERR_TYPE, "animations[0].channels[0]");
    refuses(BROKEN("3", CHANNEL(0, "scale")), ERR_TYPE, "animations[0].samplers[0]");
    refuses(BROKEN("{\"input\": @times}", CHANNEL(0, "scale")), ERR_MISSING,
            "animations[0].samplers[0].output");
    refuses(BROKEN("{\"input\": @times, \"output\": 99}", CHANNEL(0, "scale")), ERR_RANGE,
            "animations[0].samplers[0].output");
    refuses(POINTED("nodes/0/scale"), ERR_SYNTAX, "animations[0].channels[0].target");
    refuses(POINTED("/nodes/0/~2"), ERR_SYNTAX, "animations[0].channels[0].target");
    refuses(POINTED("/nodes/8/scale"), ERR_RANGE, "animations[0].channels[0].target");
    refuses(POINTED("/materials/0/alphaCutoff/x/y/z/a/b/c/d/e/f/g/h/i/j"), ERR_SYNTAX,
            "animations[0].channels[0].target");
    refuses(POINTED("/nodes/0/scale"), ERR_TYPE, "animations[0].samplers[0].output");
    /* What is written is checked as what the file had. */
    refuses(MESH NODE ANIMATIONS(
                ANIMATION("a", SAMPLER("times", "times", "LINEAR"),
                          POINTER(0, "/materials/0/pbrMetallicRoughness/roughnessFactor"))),
            ERR_RANGE, "materials[0].pbrMetallicRoughness.roughnessFactor");
}

/* A million keys of one weight, in a file of their own. */
TEST(a_million_keys_are_few)
{
    enum { KEYS = 1000000 };
    static float keys[2 * KEYS];
    struct scene s;
    for (int i = 0; i < KEYS; i++) keys[i] = (float)i, keys[KEYS + i] = (float)(i % 2);
    room_write("k.bin", keys, sizeof keys);
    room_choice.time_s = 777776.25;
    const char *text =
        "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"d.bin\", \"byteLength\": "
        "52}, {\"uri\": \"k.bin\", \"byteLength\": 8000000}], \"bufferViews\": [{\"buffer\": 0, "
        "\"byteOffset\": 16, \"byteLength\": 36}, {\"buffer\": 1, \"byteLength\": 8000000}], "
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": "
        "\"VEC3\"}, {\"bufferView\": 1, \"componentType\": 5126, \"count\": 1000000, \"type\": "
        "\"SCALAR\"}, {\"bufferView\": 1, \"byteOffset\": 4000000, \"componentType\": 5126, "
        "\"count\": 1000000, \"type\": \"SCALAR\"}], \"meshes\": [{\"primitives\": "
        "[{\"attributes\": "
        "{\"POSITION\": 0}, \"targets\": [{\"POSITION\": 0}]}]}], \"scenes\": [{\"nodes\": [0]}], "
        "\"nodes\": [{\"mesh\": 0}], \"animations\": [{\"samplers\": [{\"input\": 1, \"output\": "
        "2}], "
        "\"channels\": [{\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"weights\"}}]}]}";
    _Static_assert(offsetof(struct series, values) == 16, "as the document says");
    assert_int_equal(room_import_text("k.gltf", text, &s), 0);
    assert_true(s.positions[3] == 1.25f);
    scene_unmap(&s);
}
