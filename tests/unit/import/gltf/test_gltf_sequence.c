/* Scenes at several times, as a base and frames: each frame is the scene that a still of its time
 * is, and the base is the same whatever the times. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/runtime/blob_file.h"
#include "tests/unit/import/gltf/animated_case.h"

#define TIMES 5

static const double times[TIMES] = {0, 1.25, 2.5, 3.5, 9};

static int set_up(void **state)
{
    if (room_open(state) != 0) return -1;
    room_write("d.bin", series, sizeof series);
    return 0;
}

ALL_TESTS(set_up, room_close);

#define SHINY "{\"emissiveFactor\": [1, 0, 0]}"

/* Still, instanced, moving, beneath a moving one, mirrored at times, skinned, morphing, hidden at
 * times, of a colour that changes, and moving with weights that do not. */
#define CROWD                                                                                                                                                                                                                         \
    "\"meshes\": [{\"name\": \"m0\", \"primitives\": [{\"attributes\": {\"POSITION\": "                                                                                                                                               \
    "@positions},"                                                                                                                                                                                                                    \
    "\"material\": 0}]},"                                                                                                                                                                                                             \
    "{\"primitives\": [{\"attributes\": {\"POSITION\": @positions}, \"material\": 1, "                                                                                                                                                \
    "\"targets\": "                                                                                                                                                                                                                   \
    "[{\"POSITION\": @target}]}]}, {\"primitives\": [{\"attributes\": {\"POSITION\": "                                                                                                                                                \
    "@positions}, "                                                                                                                                                                                                                   \
    "\"material\": 2}, {\"attributes\": {\"POSITION\": @target, \"COLOR_0\": @colors}}]}, "                                                                                                                                           \
    "{\"weights\": [0.5], \"primitives\": [{\"attributes\": {\"POSITION\": @positions}, "                                                                                                                                             \
    "\"targets\": [{\"POSITION\": @target}]}]}], \"materials\": [{}, {}, " SHINY "], "                                                                                                                                                \
    "\"skins\": [{\"joints\": [3]}], \"scenes\": [{\"nodes\": [0, 1, 2, 3, 5, 6, 7, 8, 9]}], "                                                                                                                                        \
    "\"nodes\": [{\"mesh\": 0}, {\"mesh\": 2, \"translation\": [0, 0, 5]}, {\"mesh\": 2, "                                                                                                                                            \
    "\"translation\": [0, 0, 6]}, {\"mesh\": 0, \"children\": [4]}, {\"mesh\": 2, \"scale\": "                                                                                                                                        \
    "[2, 2, 2]}, {\"mesh\": 1}, {\"mesh\": 0, \"skin\": 0}, {\"mesh\": 0, \"extensions\": "                                                                                                                                           \
    "{\"KHR_node_visibility\": {\"visible\": false}}}, {\"mesh\": 0}, {\"mesh\": 3}], "                                                                                                                                               \
    "\"animations\": [{\"samplers\": [" SAMPLER("times", "steps", "LINEAR") "," SAMPLER("times", "turns", "LINEAR") "," SAMPLER("times", "weights", "LINEAR") "," SAMPLER(                                                            \
        "times", "flags",                                                                                                                                                                                                             \
        "STEP") "," SAMPLER("times", "mirrors",                                                                                                                                                                                       \
                            "LINEAR") "], \"channels\": [" TO(0, 3,                                                                                                                                                                   \
                                                              "translation") "," TO(1, 3,                                                                                                                                             \
                                                                                    "rotation") "," TO(2,                                                                                                                             \
                                                                                                       5,                                                                                                                             \
                                                                                                       "weights") "," TO(4,                                                                                                           \
                                                                                                                         8,                                                                                                           \
                                                                                                                         "scale") "," TO(0,                                                                                           \
                                                                                                                                         9,                                                                                           \
                                                                                                                                         "translation") "," POINTER(3,                                                                \
                                                                                                                                                                    "/nodes/7/extensions/KHR_node_visibility/visible") "," POINTER(2, \
                                                                                                                                                                                                                                   "/materials/2/pbrMetallicRoughness/roughnessFactor") "]}]"
#define TO(sampler, node, path)                                                                    \
    "{\"sampler\": " #sampler ", \"target\": {\"node\": " #node ", \"path\": \"" path "\"}}"

/* A triangle in the world, with what it is made of. */
struct placed {
    float corner[9];
    float roughness, red;
};

static int compare(const void *a, const void *b)
{
    const struct placed *x = a, *y = b;
    for (int i = 0; i < 9; i++) {
        const float p = roundf(x->corner[i] * 1e4f), q = roundf(y->corner[i] * 1e4f);
        if (p != q) return p < q ? -1 : 1;
    }
    return (x->roughness > y->roughness) - (x->roughness < y->roughness);
}

static uint32_t list_placed(const struct scene *s, struct placed *out)
{
    uint32_t count = 0;
    for (uint64_t i = 0; i < s->count[SCENE_INSTANCES]; i++) {
        const struct scene_instance *instance = &s->instances[i];
        const struct scene_mesh *mesh = &s->meshes[instance->mesh];
        const struct scene *home = scene_mesh_home(s, mesh);
        for (uint32_t t = 0; t < mesh->triangle_count; t++, count++) {
            out[count] = (struct placed){.roughness = s->materials[mesh->material].roughness,
                                         .red = s->materials[mesh->material].emission[0]};
            for (int k = 0; k < 3; k++) {
                const uint32_t v = home->triangles[3 * (mesh->first_triangle + t) + (uint32_t)k];
                const float *p = home->positions + 3 * (size_t)(mesh->first_vertex + v);
                for (int r = 0; r < 3; r++) {
                    const float *m = instance->to_world + 4 * r;
                    out[count].corner[3 * k + r] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
                }
            }
        }
    }
    qsort(out, count, sizeof *out, compare);
    return count;
}

static void import_times(const double *list, uint32_t count, struct scene *base, char path[256])
{
    room_choice = (struct scene_choice){.times = list, .time_count = count};
    room_write("a.gltf", document(CROWD), strlen(document(CROWD)));
    if (room_import_blob("a.gltf", path) != 0)
        fail_msg("%s: %s", room_fault.pointer, room_fault.detail);
    assert_int_equal(room_stats.frames, count);
    assert_int_equal(scene_map(path, base, &room_fault), 0);
    assert_true(base->info->flags & SCENE_IS_BASE);
}

static struct scene frame_of(const char *path, uint32_t index, const struct scene *base)
{
    char name[300];
    struct scene frame;
    snprintf(name, sizeof name, "%s.%u", path, index);
    assert_int_equal(scene_map_on(name, base, &frame, &room_fault), 0);
    return frame;
}

static void expect_same(const struct scene *frame, const struct scene *whole)
{
    struct placed a[64], b[64];
    const uint32_t count = list_placed(frame, a);
    assert_int_equal(count, list_placed(whole, b));
    assert_true(count > 10);
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 9; k++) assert_true(fabsf(a[i].corner[k] - b[i].corner[k]) < 1e-4f);
        assert_true(a[i].roughness == b[i].roughness && a[i].red == b[i].red);
    }
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 9; k++) {
            assert_true(a[i].corner[k] >= frame->info->bounds_min[k % 3] - 1e-4f);
            assert_true(a[i].corner[k] <= frame->info->bounds_max[k % 3] + 1e-4f);
        }
    assert_int_equal(frame->count[SCENE_LIGHTS], whole->count[SCENE_LIGHTS]);
}

TEST(frames_are_what_stills_are)
{
    struct scene base, whole;
    char path[256];
    import_times(times, TIMES, &base, path);
    struct scene frames[TIMES];
    for (uint32_t i = 0; i < TIMES; i++) frames[i] = frame_of(path, i, &base);
    for (uint32_t i = 0; i < TIMES; i++) {
        room_choice = (struct scene_choice){.time_s = times[i]};
        assert_int_equal(room_import_text("a.gltf", document(CROWD), &whole), 0);
        expect_same(&frames[i], &whole);
        scene_unmap(&whole);
        scene_unmap(&frames[i]);
    }
    scene_unmap(&base);
}

/* What never bends is in the base alone: frames have vertices of the skin, of the morph targets, of
 * what changes its colour, and of what is mirrored then. */
TEST(frames_have_only_what_bends)
{
    struct scene base;
    char path[256];
    import_times(times, TIMES, &base, path);
    for (uint32_t i = 0; i < TIMES; i++) {
        struct scene frame = frame_of(path, i, &base);
        /* three of colours that change, one that morphs, one skin; one that is mirrored at 2.5 s */
        const uint64_t own = frame.count[SCENE_TRIANGLES];
        assert_int_equal(own, 3 + 1 + 1 + (times[i] == 2.5));
        assert_true(frame.count[SCENE_MESHES] == base.count[SCENE_MESHES] + own);
        scene_unmap(&frame);
    }
    scene_unmap(&base);
}

static void digest_file(const char *path, struct digest *out)
{
    const void *data;
    size_t size_bytes;
    assert_int_equal(blob_file_map(path, &data, &size_bytes, &room_fault), 0);
    digest_of(data, size_bytes, out);
    blob_file_unmap(data, size_bytes);
}

TEST(base_and_frames_are_the_same_whatever_the_times)
{
    struct scene base;
    char path[256], name[300];
    struct digest together[2], alone[2], named;
    import_times(times, TIMES, &base, path);
    scene_unmap(&base);
    digest_file(path, &together[0]);
    snprintf(name, sizeof name, "%s.3", path);
    digest_file(name, &together[1]);
    import_times(&times[3], 1, &base, path);
    scene_unmap(&base);
    digest_file(path, &alone[0]);
    snprintf(name, sizeof name, "%s.0", path);
    digest_file(name, &alone[1]);
    assert_true(digest_equal(&together[0], &alone[0]) && digest_equal(&together[1], &alone[1]));
    assert_int_equal(scene_find_base(name, &named), 0);
    assert_true(digest_equal(&named, &alone[0]));
}

/* A camera of our making stands still, wherever what it sees goes. */
TEST(a_default_camera_stands_still)
{
    struct scene base;
    char path[256];
    import_times(times, TIMES, &base, path);
    struct scene first = frame_of(path, 0, &base), last = frame_of(path, TIMES - 1, &base);
    assert_int_equal(first.cameras[0].is_default, 1);
    assert_memory_equal(first.cameras, last.cameras, sizeof *first.cameras);
    assert_memory_equal(base.info->bounds_min, first.info->bounds_min, 2 * sizeof(float[3]));
    assert_false(memcmp(last.info->bounds_max, first.info->bounds_max, sizeof(float[3])) == 0);
    scene_unmap(&first);
    scene_unmap(&last);
    scene_unmap(&base);
}

TEST(what_does_not_move_is_one_blob)
{
    struct scene s;
    room_choice = (struct scene_choice){.times = times, .time_count = TIMES};
    assert_int_equal(room_import_text("b.gltf",
                                      document(MESH "\"scenes\": [{\"nodes\": [0]}], "
                                                    "\"nodes\": [{\"mesh\": 0}]"),
                                      &s),
                     0);
    assert_int_equal(room_stats.frames, 0);
    assert_null(s.base);
    scene_unmap(&s);
}

/* Keys that break behind the first time refuse their own frame alone. */
TEST(later_frames_that_fail_are_left_out)
{
    static const double late[2] = {0, 1.5};
    char path[256];
    const char *text = MOVED("times", "lost", "LINEAR", "translation");
    room_choice = (struct scene_choice){.times = late, .time_count = 2};
    room_write("c.gltf", document(text), strlen(document(text)));
    assert_int_equal(room_import_blob("c.gltf", path), 0);
    assert_int_equal(room_stats.frames, 1);
    room_choice = (struct scene_choice){.times = late + 1, .time_count = 1};
    assert_int_equal(room_import_blob("c.gltf", path), ERR_NOT_FINITE);
    assert_string_equal(room_fault.pointer, "animations[0].samplers[0].output");
}
