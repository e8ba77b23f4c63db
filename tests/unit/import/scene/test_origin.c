/* Scenes far from the origin: they are moved to their middle, and their floats keep their bits. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/import/scene/origin.h"
#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

ALL_TESTS(room_open, room_close);

TEST(only_what_is_far_away_is_moved)
{
    static const struct {
        double centre[3], half;
        bool moved;
    } rows[] = {{{0, 0, 0}, 1, false},     {{50, 0, 0}, 1, false},       {{200, 0, 0}, 1, true},
                {{0, -1e5, 3e5}, 1, true}, {{0, -1e5, 3e5}, 1e5, false}, {{1e16, 0, 0}, 1, false},
                {{1e5, 0, 0}, 0, false},   {{NAN, 0, 0}, 1, false}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double lowest[3], highest[3], origin[3];
        for (int c = 0; c < 3; c++) {
            lowest[c] = rows[i].centre[c] - rows[i].half;
            highest[c] = rows[i].centre[c] + rows[i].half;
        }
        assert_int_equal(origin_choose(lowest, highest, origin), rows[i].moved);
        for (int c = 0; c < 3; c++)
            assert_true(rows[i].moved ? fabs(origin[c] - rows[i].centre[c]) <= 2 * rows[i].half
                                      : origin[c] == 0);
    }
}

/* A triangle in two places, a camera, a point light and a skin; all around (x, y, z). */
#define SCENE                                                                                      \
    "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"d.bin\", \"byteLength\": "      \
    "100}],"                                                                                       \
    "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}, {\"buffer\": 0, \"byteOffset\": 36,"   \
    "\"byteLength\": 16}, {\"buffer\": 0, \"byteOffset\": 52, \"byteLength\": 48}],"               \
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": "        \
    "\"VEC3\","                                                                                    \
    "\"min\": [%g, 0, 0], \"max\": [%g, 1, 0]}, {\"bufferView\": 1, \"componentType\": 5121,"      \
    "\"count\": 3, \"type\": \"VEC4\"}, {\"bufferView\": 2, \"componentType\": 5126, \"count\": "  \
    "3,"                                                                                           \
    "\"type\": \"VEC4\"}],"                                                                        \
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}, {\"primitives\":"       \
    "[{\"attributes\": {\"POSITION\": 0, \"JOINTS_0\": 1, \"WEIGHTS_0\": 2}}]}],"                  \
    "\"skins\": [{\"joints\": [4]}], \"cameras\": [{\"type\": \"perspective\", \"perspective\":"   \
    "{\"yfov\": 1}}], \"extensions\": {\"KHR_lights_punctual\": {\"lights\": [{\"type\": "         \
    "\"point\"}]"                                                                                  \
    "}}, \"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"translation\": [%.17g, %.17g, %.17g],"     \
    "\"children\": [1, 2, 3, 4, 5]}, {\"mesh\": 0}, {\"mesh\": 0, \"translation\": [2, 0, 0]},"    \
    "{\"camera\": 0, \"translation\": [0, 0.015625, 4], \"extensions\": {\"KHR_lights_punctual\":" \
    "{\"light\": 0}}}, {\"translation\": [0, 1, 0]}, {\"mesh\": 1, \"skin\": 0}]}"

static void import_at(double x, double y, double z, float local, struct scene *s)
{
    static char text[4096];
    struct {
        float positions[9];
        uint8_t joints[16];
        float weights[12];
    } data = {.positions = {local, 0, 0, local + 1, 0, 0, local, 1, 0},
              .weights = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    _Static_assert(sizeof data == 100, "as the document says");
    room_write("d.bin", &data, sizeof data);
    snprintf(text, sizeof text, SCENE, (double)local, (double)local + 1, x, y, z);
    assert_int_equal(room_import_text("a.gltf", text, s), 0);
}

/* Compares all positions of two scenes, up to where they are counted from. */
static void expect_alike(const struct scene *a, const struct scene *b, const double shift[3])
{
    double moved[3];
    for (int c = 0; c < 3; c++) moved[c] = b->info->origin[c] - a->info->origin[c] - shift[c];
    assert_int_equal(a->count[SCENE_INSTANCES], b->count[SCENE_INSTANCES]);
    for (uint64_t i = 0; i < a->count[SCENE_INSTANCES]; i++) {
        const struct scene_mesh *ma = &a->meshes[a->instances[i].mesh];
        const struct scene_mesh *mb = &b->meshes[b->instances[i].mesh];
        const float *p = a->positions + 3 * (size_t)ma->first_vertex;
        const float *q = b->positions + 3 * (size_t)mb->first_vertex;
        for (int k = 0; k < 9; k++) {
            const int c = k % 3, v = 3 * (k / 3);
            double pa = 0, pb = 0;
            for (int j = 0; j < 3; j++) {
                pa += (double)a->instances[i].to_world[4 * c + j] * (double)p[v + j];
                pb += (double)b->instances[i].to_world[4 * c + j] * (double)q[v + j];
            }
            pa += (double)a->instances[i].to_world[4 * c + 3];
            pb += (double)b->instances[i].to_world[4 * c + 3];
            assert_true(fabs(pb + moved[c] - pa) < 1e-6);
        }
    }
    for (int c = 0; shift[c] != 0 && c < 3; c++) { /* their nodes moved by so much */
        assert_true(fabs((double)b->cameras[0].eye[c] + moved[c] - (double)a->cameras[0].eye[c]) <
                    1e-6);
        assert_true(fabs((double)b->lights[0].position[c] + moved[c] -
                         (double)a->lights[0].position[c]) < 1e-6);
    }
}

TEST(far_nodes_are_as_exact_as_near_ones)
{
    static const double shift[3] = {1e5, 2e5, -3e5};
    struct scene near, far;
    import_at(0, 0, 0, 0, &near);
    import_at(shift[0], shift[1], shift[2], 0, &far);
    assert_true(near.info->origin[0] == 0 && near.info->origin[1] == 0);
    assert_true(fabs(far.info->origin[2] - shift[2]) < 8);
    assert_true(far.info->bounds_max[0] < 8 && far.info->bounds_min[2] > -8);
    expect_alike(&near, &far, shift);
    assert_false(room_warned("exact to"));
    scene_unmap(&near);
    scene_unmap(&far);
}

TEST(vertices_far_from_their_node_are_brought_to_it)
{
    static const double none[3] = {0, 0, 0};
    struct scene near, far;
    import_at(0, 0, 0, 0, &near);
    import_at(-262144, 0, 0, 262144, &far);   /* a step is 1/32 there: these numbers are exact */
    assert_true(fabsf(far.positions[0]) < 8); /* also in the mesh that is placed twice */
    expect_alike(&near, &far, none);
    assert_true(room_warned("exact to 0.03 units only"));
    scene_unmap(&near);
    scene_unmap(&far);
}

TEST(obj_files_are_moved_too)
{
    struct scene s;
    const char *text = "v 262144 0 8\nv 262145 0 8\nv 262144 1 8\nf 1 2 3\n";
    assert_int_equal(room_import_text("a.obj", text, &s), 0);
    assert_true(s.info->origin[0] + (double)s.positions[0] == 262144);
    assert_true(s.info->origin[2] + (double)s.positions[2] == 8 && fabsf(s.positions[0]) < 2);
    assert_int_equal(room_warnings.count, 0); /* its text has all digits */
    scene_unmap(&s);
}
