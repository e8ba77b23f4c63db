/* The shutter of a plan: what is sent of it, what may have one, and where the camera is meanwhile.
 */
#include <math.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

/* Whole paths while the camera goes right by 4 and turns left by a right angle. */
static void open_shutter(struct plan *plan)
{
    plan->planes &= PLANES_PATH_ALL;
    plan->light_planes = plan->sub_samples = plan->indirect_strata_per_axis = 0;
    plan->lens_strata_per_axis = plan->lens_relight = plan->lens_mirrors = 0;
    for (uint32_t k = 0; k < plan->light_count; k++) plan->lights[k].strata_per_axis = 1;
    plan->pose_count = SHUTTER_STEPS;
    for (uint32_t k = 0; k < SHUTTER_STEPS; k++) {
        const float angle = (float)k * 0.3926990817f, s = sinf(angle), c = cosf(angle);
        struct plan_camera *pose = &plan->poses[k];
        *pose = plan->camera;
        pose->eye[0] = (float)k;
        pose->right[0] = c, pose->right[2] = -s;
        pose->forward[0] = -s, pose->forward[2] = -c;
    }
}

TEST(poses_round_trip)
{
    static struct plan sent, got;
    struct bytes_writer w;
    struct fault fault = {0};
    plan_case(&sent);
    open_shutter(&sent);
    encode(&sent, &w);
    if (decode(w.data, w.size_bytes, &got, &fault)) fail_msg("%s: %s", fault.pointer, fault.detail);
    assert_int_equal(got.pose_count, SHUTTER_STEPS);
    assert_memory_equal(got.poses, sent.poses, sizeof sent.poses);
    assert_int_equal(decode(w.data, w.size_bytes - 4, &got, &fault), ERR_TRUNCATED);
    bytes_writer_fini(&w);
}

TEST(counts_of_poses_are_checked)
{
    static struct plan plan, got;
    struct bytes_writer w;
    struct fault fault = {0};
    plan_case(&plan);
    plan.light_count = 0;
    encode(&plan, &w);
    memset(w.data + w.size_bytes - 8, 0xff, 4); /* before the count of lights, which is last */
    assert_int_equal(decode(w.data, w.size_bytes, &got, &fault), ERR_RANGE);
    assert_string_equal(fault.pointer, "pose_count");
    bytes_writer_fini(&w);
}

TEST(shutters_are_checked)
{
    EXPECT((open_shutter(&plan), plan.pose_count = 3), ERR_RANGE, "pose_count");
    EXPECT((open_shutter(&plan), plan.poses[2].right[0] = 2), ERR_RANGE, "poses[2].right");
    EXPECT((open_shutter(&plan), plan.poses[4].eye[1] = NAN), ERR_NOT_FINITE, "poses[4].eye");
    EXPECT((open_shutter(&plan), plan.poses[1].half_width = 0), ERR_RANGE, "poses[1].half_width");
    EXPECT((open_shutter(&plan), plan.paths.spp = 0), ERR_RANGE, "planes");
}

TEST(fields_of_centres_have_no_shutter)
{
    EXPECT((plan.pose_count = SHUTTER_STEPS, plan.poses[0] = plan.poses[1] = plan.poses[2] =
                                                 plan.poses[3] = plan.poses[4] = plan.camera),
           ERR_LIMIT, "pose_count");
}

TEST(cameras_go_from_pose_to_pose)
{
    static struct plan plan;
    struct plan_camera c;
    plan_case(&plan);
    plan_camera_at(&plan, 0.3f, &c);
    assert_memory_equal(&c, &plan.camera, sizeof c);
    open_shutter(&plan);
    for (uint32_t k = 0; k < SHUTTER_STEPS; k++) {
        plan_camera_at(&plan, (float)k / (SHUTTER_STEPS - 1), &c);
        for (int i = 0; i < 3; i++) {
            assert_float_equal(c.eye[i], plan.poses[k].eye[i], 1e-6f);
            assert_float_equal(c.forward[i], plan.poses[k].forward[i], 1e-6f);
        }
    }
    plan_camera_at(&plan, 0.625f, &c);
    assert_float_equal(c.eye[0], 2.5f, 1e-6f);
    assert_float_equal(c.forward[0], -sinf(2.5f * 0.3926990817f), 1e-5f);
    assert_float_equal(c.right[0], cosf(2.5f * 0.3926990817f), 1e-5f);
    assert_float_equal(c.aperture_radius, plan.camera.aperture_radius, 0);
}
