/* Places in a photograph, against the camera's own rays; and its texels. */
#include <math.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/scene/environment_fixture.h"
#include "tests/unit/worker/scene_fixture.h"
#include "worker/scene/photograph.h"

static struct plan plan_of(uint32_t type, enum photograph_fit fit)
{
    struct plan p = fixture_plan(40, 20, (float[]){1, 2, 3}, 0.5f);
    fixture_look(&p, (float[]){0.6f, -0.8f, 0}, (float[]){0.8f, 0.6f, 0});
    p.camera.type = type;
    p.camera.centre_x = 0.2f;
    p.camera.centre_y = -0.1f;
    p.photograph.fit = fit;
    return p;
}

TEST(places_are_those_of_the_camera_s_rays)
{
    for (uint32_t type = CAMERA_PERSPECTIVE; type <= CAMERA_ORTHOGRAPHIC; type++) {
        const struct plan p = plan_of(type, PHOTOGRAPH_STRETCHED);
        struct environment_fixture f;
        struct photograph photograph;
        environment_fixture_open(&f, 4, 2, (float[24]){0});
        photograph_init(&photograph, &p, &f.blob);
        for (int i = 0; i < 40; i++) {
            const float x = (float)i + 0.25f, y = (float)(i % 20) + 0.75f;
            float from[3], way[3], point[3], to[3], distance, px, py;
            plan_camera_ray(&p, x, y, from, way);
            for (int k = 0; k < 3; k++) point[k] = from[k] + 7 * way[k];
            assert_true(photograph_find(&photograph, point, to, &distance, &px, &py));
            assert_true(fabsf(px - x) < 1e-3f && fabsf(py - y) < 1e-3f);
            assert_true(fabsf(distance - 7) < 1e-4f);
            for (int k = 0; k < 3; k++) assert_true(fabsf(to[k] + way[k]) < 1e-5f);
            for (int k = 0; k < 3; k++) point[k] = from[k] - 7 * way[k];
            assert_false(photograph_find(&photograph, point, to, &distance, &px, &py));
        }
        environment_fixture_close(&f);
    }
}

TEST(beside_the_picture_is_nothing)
{
    const struct plan p = plan_of(CAMERA_PERSPECTIVE, PHOTOGRAPH_STRETCHED);
    const float outside[][2] = {{-0.5f, 10}, {40.5f, 10}, {20, -0.5f}, {20, 20.5f}};
    struct environment_fixture f;
    struct photograph photograph;
    environment_fixture_open(&f, 4, 2, (float[24]){0});
    photograph_init(&photograph, &p, &f.blob);
    for (int i = 0; i < 4; i++) {
        float from[3], way[3], point[3], to[3], distance, px, py;
        plan_camera_ray(&p, outside[i][0], outside[i][1], from, way);
        for (int k = 0; k < 3; k++) point[k] = from[k] + way[k];
        assert_false(photograph_find(&photograph, point, to, &distance, &px, &py));
    }
    environment_fixture_close(&f);
}

static float red_at(const struct photograph *p, float px, float py)
{
    float rgb[3];
    photograph_read(p, px, py, rgb);
    return rgb[0];
}

/* Four texels across, of 40 pixels; two down. Covering cuts half of the rows of a square one. */
TEST(texels_lie_where_the_picture_has_them)
{
    float texels[3 * 4 * 4] = {0};
    for (int i = 0; i < 16; i++) texels[3 * i] = (float)i / 16;
    struct plan p = plan_of(CAMERA_PERSPECTIVE, PHOTOGRAPH_STRETCHED);
    struct environment_fixture f;
    struct photograph photograph;
    environment_fixture_open(&f, 4, 4, texels);
    photograph_init(&photograph, &p, &f.blob);
    assert_true(red_at(&photograph, 5, 2.5f) == 0);
    assert_true(red_at(&photograph, 0, 0) == 0); /* the border goes on */
    assert_true(red_at(&photograph, 35, 17.5f) == 15.0f / 16);
    assert_true(red_at(&photograph, 40, 20) == 15.0f / 16);
    assert_true(red_at(&photograph, 10, 2.5f) == 0.5f / 16);
    p.photograph.fit = PHOTOGRAPH_COVERS;
    photograph_init(&photograph, &p, &f.blob);
    assert_true(red_at(&photograph, 5, 5) == 4.0f / 16);
    assert_true(red_at(&photograph, 35, 15) == 11.0f / 16);
    p.photograph.is_linear = 1;
    assert_true(fabsf(red_at(&photograph, 35, 15) - 0.8475f) < 1e-4f); /* sRGB of 0.6875 */
    environment_fixture_close(&f);
}
