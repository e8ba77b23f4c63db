/* What a plan looks at: pictures, cameras, environments and lights that are unsafe to trace do not
 * come back, and rays go where the camera looks. */
#include <math.h>
#include <string.h>

#include "tests/unit/proto/plan_wire.h"
#include "tests/unit/unit.h"

TEST(images_are_checked)
{
    EXPECT(plan.width_px = 0, ERR_RANGE, "width_px");
    EXPECT(plan.width_px = INT32_MIN, ERR_RANGE, "width_px");
    EXPECT(plan.width_px = LIMIT_IMAGE_SIDE_PX + 1, ERR_LIMIT, "width_px");
    EXPECT(plan.height_px = -1, ERR_RANGE, "height_px");
    EXPECT(plan.height_px = INT32_MAX, ERR_LIMIT, "height_px");
    EXPECT(plan.width_px = plan.height_px = 16384, ERR_LIMIT, "height_px");
    EXPECT((plan.width_px = 16384, plan.height_px = 8192), ERR_OK, "");
    EXPECT(plan.tile_px = LIMIT_TILE_SIDE_MIN_PX - 1, ERR_RANGE, "tile_px");
    EXPECT(plan.tile_px = LIMIT_TILE_SIDE_PX + 1, ERR_LIMIT, "tile_px");
}

TEST(cameras_are_checked)
{
    EXPECT(plan.camera.type = 2, ERR_RANGE, "camera.type");
    EXPECT(plan.camera.eye[1] = NAN, ERR_NOT_FINITE, "camera.eye");
    EXPECT(plan.camera.eye[1] = INFINITY, ERR_NOT_FINITE, "camera.eye");
    EXPECT(plan.camera.eye[2] = 2e15f, ERR_RANGE, "camera.eye");
    EXPECT(plan.camera.right[0] = 1.1f, ERR_RANGE, "camera.right");
    EXPECT(plan.camera.right[0] = 0, ERR_RANGE, "camera.right");
    EXPECT(plan.camera.up[1] = NAN, ERR_NOT_FINITE, "camera.up");
    EXPECT((plan.camera.up[0] = 0.6f, plan.camera.up[1] = 0.8f), ERR_RANGE, "camera.up");
    EXPECT(plan.camera.forward[2] = 1, ERR_RANGE, "camera.forward");
    EXPECT((plan.camera.forward[0] = 1, plan.camera.forward[2] = 0), ERR_RANGE, "camera.forward");
    EXPECT(plan.camera.half_width = 0, ERR_RANGE, "camera.half_width");
    EXPECT(plan.camera.half_width = 1e6f, ERR_RANGE, "camera.half_width");
    EXPECT(plan.camera.half_height = -1, ERR_RANGE, "camera.half_height");
    EXPECT(plan.camera.half_height = INFINITY, ERR_NOT_FINITE, "camera.half_height");
    EXPECT((plan.camera.type = CAMERA_ORTHOGRAPHIC, without_lens(&plan),
            plan.camera.half_width = 1e6f),
           ERR_OK, "");
}

TEST(environments_are_checked)
{
    EXPECT(plan.environment.kind = 3, ERR_RANGE, "environment.kind");
    EXPECT(plan.environment.kind = ENVIRONMENT_CONSTANT, ERR_OK, "");
    EXPECT(plan.environment.radiance[1] = -1, ERR_RANGE, "environment.radiance");
    EXPECT(plan.environment.radiance[1] = 1e13f, ERR_RANGE, "environment.radiance");
    EXPECT(plan.environment.radiance[2] = NAN, ERR_NOT_FINITE, "environment.radiance");
    EXPECT(plan.environment.rotation_rad = INFINITY, ERR_NOT_FINITE, "environment.rotation_rad");
    EXPECT(plan.environment.power = 0, ERR_RANGE, "environment.power");
    EXPECT(plan.environment.power = NAN, ERR_NOT_FINITE, "environment.power");
    EXPECT((plan.environment.kind = ENVIRONMENT_NONE, plan.environment.power = 0), ERR_OK, "");
}

TEST(lights_are_checked)
{
    EXPECT(plan.lights[0].type = 4, ERR_RANGE, "lights[0].type");
    EXPECT(plan.lights[0].profile = 2, ERR_RANGE, "lights[0].profile");
    EXPECT(plan.lights[0].position[0] = NAN, ERR_NOT_FINITE, "lights[0].position");
    EXPECT(plan.lights[0].position[0] = -1e16f, ERR_RANGE, "lights[0].position");
    EXPECT(plan.lights[0].direction[0] = NAN, ERR_NOT_FINITE, "lights[0].direction");
    EXPECT(plan.lights[0].half_u[0] = INFINITY, ERR_NOT_FINITE, "lights[0].half_u");
    EXPECT(plan.lights[0].color[2] = -1, ERR_RANGE, "lights[0].color");
    EXPECT(plan.lights[0].color[2] = 1e13f, ERR_RANGE, "lights[0].color");
    EXPECT(plan.lights[0].color[2] = 0, ERR_OK, "");
    EXPECT(plan.lights[0].range = -1, ERR_RANGE, "lights[0].range");
    EXPECT(plan.lights[0].range = NAN, ERR_NOT_FINITE, "lights[0].range");
    EXPECT(plan.lights[0].power = 0, ERR_RANGE, "lights[0].power");
    EXPECT(plan.lights[0].power = INFINITY, ERR_NOT_FINITE, "lights[0].power");
    EXPECT(plan.lights[0].strata_per_axis = 2, ERR_LIMIT, "lights[0].strata_per_axis");
    EXPECT(plan.lights[1].direction[1] = -0.5f, ERR_RANGE, "lights[1].direction");
    EXPECT(plan.lights[1].cos_inner = 0.7f, ERR_RANGE, "lights[1].cos_inner");
    EXPECT(plan.lights[1].cos_inner = 1.5f, ERR_RANGE, "lights[1].cos_inner");
    EXPECT(plan.lights[1].cos_outer = -0.1f, ERR_RANGE, "lights[1].cos_outer");
    EXPECT(plan.lights[1].cos_outer = NAN, ERR_NOT_FINITE, "lights[1].cos_outer");
    EXPECT(plan.lights[2].direction[0] = 0, ERR_RANGE, "lights[2].direction");
    EXPECT(plan.lights[3].half_u[0] = 0, ERR_RANGE, "lights[3].half_u");
    EXPECT(plan.lights[3].half_v[2] = NAN, ERR_NOT_FINITE, "lights[3].half_v");
    EXPECT((plan.lights[3].half_v[0] = 1, plan.lights[3].half_v[2] = 1e-7f), ERR_RANGE,
           "lights[3].half_v");
    EXPECT(plan.lights[3].half_u[0] = -0.5f, ERR_RANGE, "lights[3].direction");
    EXPECT(plan.lights[3].strata_per_axis = 0, ERR_RANGE, "lights[3].strata_per_axis");
    EXPECT(plan.lights[3].strata_per_axis = 17, ERR_LIMIT, "lights[3].strata_per_axis");
    EXPECT((plan.lights[3].strata_per_axis = 256, plan.light_planes = 1), ERR_OK, "");
    EXPECT((plan.lights[3].strata_per_axis = 257, plan.light_planes = 1), ERR_LIMIT,
           "lights[3].strata_per_axis");
}

static void is_near(float got, double expected)
{
    if (!(fabs((double)got - expected) < 1e-6)) fail_msg("%g is not %g", (double)got, expected);
}

TEST(rays_follow_the_camera)
{
    static struct plan plan;
    float origin[3], direction[3];
    plan_case(&plan);
    plan_camera_ray(&plan, 360, 240, origin, direction);
    assert_memory_equal(origin, plan.camera.eye, sizeof origin);
    assert_memory_equal(direction, plan.camera.forward, sizeof direction);
    plan_camera_ray(&plan, 0, 0, origin, direction); /* top left */
    const double length = sqrt(0.75 * 0.75 + 0.5 * 0.5 + 1);
    is_near(direction[0], -0.75 / length);
    is_near(direction[1], 0.5 / length);
    is_near(direction[2], -1 / length);
    is_near(plan_pixel_size(&plan, 10), 10 * 1.5 / 720);
    plan.camera.type = CAMERA_ORTHOGRAPHIC;
    plan_camera_ray(&plan, 720, 480, origin, direction); /* bottom right */
    is_near(origin[0], 0.75);
    is_near(origin[1], 0.5);
    is_near(origin[2], 5);
    assert_memory_equal(direction, plan.camera.forward, sizeof direction);
    is_near(plan_pixel_size(&plan, 10), 1.5 / 720);
}
