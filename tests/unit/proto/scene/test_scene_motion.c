/* What moves while the shutter is open: its records in the blob of a frame. */
#include <stdalign.h>

#include "tests/unit/proto/scene/scene_case.h"
#include "tests/unit/unit.h"

static alignas(64) uint8_t blob[SCENE_CASE_BYTES], base_blob[SCENE_CASE_BYTES];
static struct scene_case c;
static struct scene scene, base;

/* The case as a base; a frame on it places its second mesh once more, and has a mesh of its own. */
static void make_frame(void)
{
    struct fault fault;
    scene_case_init(&c);
    c.info.flags = SCENE_MOVES | SCENE_IS_BASE;
    const size_t size_bytes = scene_case_lay_out(&c, base_blob);
    assert_int_equal(scene_open(base_blob, size_bytes, &base, &fault), 0);
    c.info.flags = SCENE_MOVES;
    c.base_count = 1;
    c.meshes[0].flags |= MESH_IN_BASE;
    c.meshes[1].flags |= MESH_IN_BASE;
    c.images[0].flags |= IMAGE_IN_BASE;
    c.mesh_count = 3;
    c.instance_count = 5;
    c.meshes[2] = c.meshes[0];
    c.meshes[2].flags = MESH_HAS_NORMALS;
    c.instances[3] = c.instances[1];
    c.instances[4] = c.instances[0];
    c.instances[4].mesh = 2;
    c.info.placed_triangles += 3;
}

/* Both move, and the cameras. */
static void move(void)
{
    c.movers[0].instance = 3;
    c.movers[1] = (struct scene_mover){.instance = 4, .bends = 1};
    c.mover_count = 2;
    c.step_count = 2 * SHUTTER_STEPS;
    c.pose_count = 2 * SHUTTER_STEPS;
    for (uint32_t k = 0; k < c.step_count; k++) {
        memcpy(c.steps[k].to_world, c.instances[0].to_world, sizeof c.steps[k].to_world);
        if (k < SHUTTER_STEPS) c.steps[k].to_world[3] = (float)k;
        if (k >= SHUTTER_STEPS && k % 2) c.steps[k].first_vertex = 3;
        c.poses[k] = c.cameras[k / SHUTTER_STEPS];
    }
}

static int open_frame(struct fault *fault)
{
    const size_t size_bytes = scene_case_lay_out(&c, blob);
    return scene_open_on(blob, size_bytes, &base, &scene, fault);
}

TEST(frames_have_steps)
{
    struct fault fault = {0};
    make_frame();
    move();
    if (open_frame(&fault)) fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(scene.movers[1].instance, 4);
    assert_true(scene.steps[4].to_world[3] == 4.0f);
    assert_int_equal(scene.poses[9].type, CAMERA_ORTHOGRAPHIC);
}

#define FRAME(change, code, place)                                                                 \
    do {                                                                                           \
        struct fault fault = {0};                                                                  \
        make_frame();                                                                              \
        move();                                                                                    \
        change;                                                                                    \
        assert_int_equal(open_frame(&fault), code);                                                \
        assert_string_equal(fault.pointer, place);                                                 \
    } while (0)

TEST(steps_are_checked)
{
    FRAME(c.step_count--, ERR_MISMATCH, "steps");
    FRAME(c.pose_count--, ERR_MISMATCH, "poses");
    FRAME(c.movers[0].instance = 2, ERR_MISMATCH, "movers[0].instance");
    FRAME(c.movers[0].instance = 5, ERR_RANGE, "movers[0].instance");
    FRAME(c.movers[1].instance = 3, ERR_RANGE, "movers[1].instance");
    FRAME(c.movers[1].bends = 2, ERR_RANGE, "movers[1].bends");
    FRAME(c.movers[0].bends = 1, ERR_MISMATCH, "movers[0].bends");
    FRAME(c.movers[1].bends = 0, ERR_MISMATCH, "movers[1].bends");
    FRAME(c.steps[1].first_vertex = 1, ERR_RANGE, "steps[1].first_vertex");
    FRAME(c.steps[6].first_vertex = 4, ERR_RANGE, "steps[6].first_vertex");
    FRAME(c.steps[6].first_normal = 1, ERR_RANGE, "steps[6].first_normal");
    FRAME(c.steps[2].to_world[7] = NAN, ERR_NOT_FINITE, "steps[2].to_world");
    FRAME(c.steps[2].to_world[0] = 0, ERR_RANGE, "steps[2].to_world");
    FRAME(c.poses[3].right[0] = 2, ERR_RANGE, "poses[3].right");
    FRAME(c.poses[3].type = CAMERA_ORTHOGRAPHIC, ERR_RANGE, "poses[3].half_width");
}
