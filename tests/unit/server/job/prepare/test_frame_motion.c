/* Which instance of a frame is which in the frames beside it. */
#include <math.h>
#include <string.h>

#include "server/job/prepare/frame_motion.h"
#include "tests/unit/unit.h"

#define INSTANCES_MAX 8

/* A scene of triangles: meshes 0 and 1 are the base's, 2 and 3 the frame's own. */
struct stage {
    struct scene scene;
    struct scene_mesh meshes[4];
    struct scene_instance instances[INSTANCES_MAX];
    float positions[18];
};

static const uint32_t triangles[3] = {0, 1, 2};
static struct scene base;

static void begin(struct stage *s)
{
    static const struct scene_instance still = {0};
    memset(s, 0, sizeof *s);
    base = (struct scene){.instances = &still};
    base.count[SCENE_INSTANCES] = 1;
    for (uint32_t i = 0; i < 4; i++)
        s->meshes[i] = (struct scene_mesh){.vertex_count = 3,
                                           .triangle_count = 1,
                                           .first_vertex = i < 2 ? 0 : 3 * (i - 2),
                                           .flags = i < 2 ? MESH_IN_BASE : 0,
                                           .name = i};
    for (int v = 0; v < 6; v++) s->positions[3 * v + v % 3] = 1;
    s->scene = (struct scene){.base = &base,
                              .meshes = s->meshes,
                              .instances = s->instances,
                              .positions = s->positions,
                              .triangles = triangles,
                              .names = "\0a\0b\0c"};
    s->scene.count[SCENE_MESHES] = 4;
    s->scene.count[SCENE_INSTANCES] = 1; /* the base's */
}

static void place(struct stage *s, uint32_t mesh, float x)
{
    s->instances[s->scene.count[SCENE_INSTANCES]++] =
        (struct scene_instance){.mesh = mesh, .to_world = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}};
}

static struct motion *compare(const struct stage *now, const struct stage *before,
                              const struct stage *after)
{
    static const struct plan_camera cameras[MOTION_SIDES];
    const struct scene *const sides[MOTION_SIDES] = {&before->scene, &after->scene};
    struct motion *m;
    assert_int_equal(frame_motion_create(&now->scene, sides, cameras, &m), 0);
    return m;
}

TEST(placements_are_matched_within_their_mesh)
{
    struct stage now, before, after;
    begin(&now), begin(&before), begin(&after);
    place(&now, 0, 1), place(&now, 0, 2), place(&now, 1, 5);
    place(&before, 0, 1), place(&before, 0, 4), place(&before, 1, 5);
    place(&after, 0, 7), place(&after, 1, 8); /* one of mesh 0 is hidden then */
    struct motion *m = compare(&now, &before, &after);
    assert_int_equal(m->part_count, 4);
    assert_false(m->parts[0].moves[MOTION_BACKWARD]); /* the base's */
    assert_false(m->parts[1].moves[MOTION_BACKWARD]);
    assert_true(m->parts[2].moves[MOTION_BACKWARD]);
    assert_true(m->parts[2].to[MOTION_BACKWARD][3] == 2);
    assert_true(m->parts[3].to[MOTION_FORWARD][3] == 3);
    assert_false(m->parts[1].moves[MOTION_FORWARD]); /* which of the two is not known */
    motion_drop(&m);
}

/* A turn by 90 degrees about z and a doubling, from a turn about x: points of the surface go along.
 */
TEST(transforms_lead_from_one_place_to_the_other)
{
    struct stage now, then;
    begin(&now), begin(&then);
    place(&now, 0, 0), place(&then, 0, 0);
    const float from[12] = {1, 0, 0, 3, 0, 0, -1, 4, 0, 1, 0, 5};
    const float to[12] = {0, -2, 0, 1, 2, 0, 0, 1, 0, 0, 2, 1};
    const float p[3] = {.3f, .5f, .7f};
    memcpy(now.instances[1].to_world, from, sizeof from);
    memcpy(then.instances[1].to_world, to, sizeof to);
    struct motion *m = compare(&now, &then, &then);
    for (int i = 0; i < 3; i++) {
        const double *row = m->parts[1].to[MOTION_FORWARD] + 4 * i;
        double there = row[3], wanted = to[4 * i + 3];
        for (int j = 0; j < 3; j++) {
            double world = from[4 * j + 3];
            for (int k = 0; k < 3; k++) world += (double)from[4 * j + k] * (double)p[k];
            there += row[j] * world;
            wanted += (double)to[4 * i + j] * (double)p[j];
        }
        assert_true(fabs(there - wanted) < 1e-6);
    }
    motion_drop(&m);
}

TEST(meshes_of_frames_are_matched_by_names)
{
    struct stage now, before, after;
    begin(&now), begin(&before), begin(&after);
    place(&now, 2, 0), place(&now, 3, 0);
    place(&before, 2, 0), place(&before, 3, 0);
    place(&after, 3, 0); /* the first is hidden then */
    for (int v = 3; v < 6; v++) before.positions[3 * v] += 4, after.positions[3 * v] += 6;
    struct motion *m = compare(&now, &before, &after);
    double at[3] = {1. / 3, 1. / 3, 1. / 3};
    assert_true(m->parts[2].moves[MOTION_FORWARD] && m->parts[2].mesh);
    assert_false(m->parts[1].moves[MOTION_FORWARD]);
    motion_mesh_follow(m->parts[2].mesh, MOTION_BACKWARD, at);
    assert_true(fabs(at[0] - 4 - 1. / 3) < 1e-6);
    at[0] = 1. / 3;
    motion_mesh_follow(m->parts[2].mesh, MOTION_FORWARD, at);
    assert_true(fabs(at[0] - 6 - 1. / 3) < 1e-6);
    motion_drop(&m);
}
