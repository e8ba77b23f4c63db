/* Receivers: points, light coordinates and screen steps against small moves; who is lit. */
#include "tests/unit/server/reconstruct/shadow/shadow_accuracy.h"
#include "tests/unit/unit.h"

static struct shadow_scene scene;

/* A plane through the scene that is not parallel to the light, far from the origin. */
static void place(uint32_t camera, float offset)
{
    scene_init(&scene, 64, 48, 1.0f, 3);
    scene.plan.camera.type = camera;
    if (camera == CAMERA_ORTHOGRAPHIC)
        scene.plan.camera.half_width = scene.plan.camera.half_height = 4.0f;
    for (int k = 0; k < 2; k++) {
        scene.plan.camera.eye[k] += offset;
        scene.plan.lights[0].position[k] += offset;
    }
}

/* Points lie on the floor; Delta_i moves as e_i says from a pixel to its neighbours. */
static void check_steps(uint32_t camera, float offset)
{
    place(camera, offset);
    const struct rect all = {0, 0, 64, 48};
    struct patch *patch = accuracy_patch(&scene, 3);
    struct receiver_light light;
    struct receivers receivers;
    receiver_light_init(&light, &scene.plan, 0);
    assert_int_equal(receivers_create(&light, patch, KERNELS_BEST(shadow_kernels),
                                      rect_grow(all, 5), &receivers),
                     0);
    const struct shadow_pixels *p = &receivers.pixels;
    assert_false(receiver_is_lit(p, receivers_pixel(&receivers, -1, 3)));
    for (int32_t y = 1; y < 47; y++) {
        for (int32_t x = 1; x < 63; x++) {
            const size_t i = receivers_pixel(&receivers, x, y);
            float steps[2][2], moved[2] = {0, 0};
            assert_true(receiver_is_lit(p, i));
            assert_true(fabsf(p->point[2][i] + scene.plan.camera.eye[2]) < 1e-4f);
            receiver_steps(&light, p, i, steps);
            for (int axis = 0; axis < 2; axis++) {
                const float delta = p->distance[i] * (p->u[axis][i + 1] - p->u[axis][i]);
                for (int k = 0; k < 2; k++) moved[k] += delta * steps[axis][k];
            }
            assert_true(fabsf(moved[0] - 1.0f) < 0.05f && fabsf(moved[1]) < 0.05f);
            assert_true(fabsf(receiver_pixel(p, i) -
                              plan_pixel_size(&scene.plan, patch->depth[y * 64 + x])) < 1e-5f);
        }
    }
    receivers_fini(&receivers);
    patch_destroy(&patch);
}

TEST(steps_are_moves)
{
    check_steps(CAMERA_PERSPECTIVE, 0.0f);
    check_steps(CAMERA_ORTHOGRAPHIC, 0.0f);
}

/* gamma is the slope of G's logarithm at the light's centre. */
TEST(gamma_is_a_slope)
{
    place(CAMERA_PERSPECTIVE, 0.0f);
    struct patch *patch = accuracy_patch(&scene, 3);
    struct receiver_light light;
    struct receivers receivers;
    const struct plan_light *l = &scene.plan.lights[0];
    receiver_light_init(&light, &scene.plan, 0);
    assert_int_equal(
        receivers_create(&light, patch, KERNELS_BEST(shadow_kernels), patch->rect, &receivers), 0);
    for (size_t i = 0; i < 64 * 48; i += 17) {
        float p[3], n[3], d[3];
        scene_primary(&scene, (int32_t)(i % 64), (int32_t)(i / 64), p, n);
        const float g = scene_weight(l, p, n, 0, 0, d);
        const float u = (scene_weight(l, p, n, 0.01f, 0, d) / g - 1) / 0.01f;
        const float v = (scene_weight(l, p, n, 0, 0.01f, d) / g - 1) / 0.01f;
        assert_true(fabsf(receivers.pixels.gamma[0][i] - u) < 0.01f);
        assert_true(fabsf(receivers.pixels.gamma[1][i] - v) < 0.01f);
    }
    receivers_fini(&receivers);
    patch_destroy(&patch);
}

/* Behind the light, on its plane, turned away, or no surface: dark; partly above the horizon: lit.
 */
TEST(who_is_lit)
{
    static const struct {
        float normal[3], height, depth;
        bool lit;
    } cases[] = {{{0, 0, 1}, 0, 1, true},      {{0, 0, -1}, 0, 1, false},
                 {{0, 0, 1}, 0, 0, false},     {{0, 0, 1}, 20, 1, false},
                 {{0, 0, 1}, 8, 1, false},     {{1, 0, -0.05f}, 0, 1, true},
                 {{1, 0, -0.5f}, 0, 1, false}, {{1, 0, 0}, 0, 1, true}};
    scene_init(&scene, 1, 1, 1.0f, 3);
    scene.plan.lights[0] =
        scene_light((float[]){0, 0, 8}, (float[]){0, 0, -1}, (float[]){1, 0, 0}, 1, 1);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct receiver_light light;
        struct receivers receivers;
        struct patch *patch;
        scene_camera(&scene.plan, (float[]){0, -1, cases[k].height},
                     (float[]){0, 0, cases[k].height}, 0.1f);
        assert_int_equal(patch_create(&scene.plan, (struct rect){0, 0, 1, 1}, &patch), 0);
        patch->depth[0] = cases[k].depth;
        for (int c = 0; c < 3; c++) patch->normal[c][0] = cases[k].normal[c];
        receiver_light_init(&light, &scene.plan, 0);
        assert_int_equal(
            receivers_create(&light, patch, KERNELS_BEST(shadow_kernels), patch->rect, &receivers),
            0);
        assert_int_equal(receiver_is_lit(&receivers.pixels, 0), cases[k].lit);
        receivers_fini(&receivers);
        patch_destroy(&patch);
    }
}

/* Until somebody shears them no pixel has a wedge, a walk or a slot; and beyond the patch they show
 * nothing. Whatever was in the memory before. */
static void assert_bare(const struct shadow_pixels *p, size_t i)
{
    assert_true(p->spread[i] == SHADOW_NO_SPREAD && p->eta[i] == 0.0f && p->width_px[i] == 0.0f);
    assert_int_equal(p->slot[i], -1);
    for (int axis = 0; axis < 2; axis++) {
        assert_int_equal(p->weights[axis][i], COVERAGE_WIDEST);
        assert_int_equal(p->walk[axis].reach[i], 0);
        for (int k = 0; k < 2; k++) assert_true(p->walk[axis].step[k][i] == 0.0f);
    }
}

TEST(starts_without_wedges)
{
    place(CAMERA_PERSPECTIVE, 0.0f);
    struct patch *patch = accuracy_patch(&scene, 3);
    struct receiver_light light;
    struct receivers receivers;
    receiver_light_init(&light, &scene.plan, 0);
    const struct rect wide = rect_grow(patch->rect, 5);
    const size_t bytes = 64 * sizeof(float) * (size_t)rect_area(wide);
    struct scratch *scratch;
    assert_int_equal(scratch_create(&scratch), 0);
    void *used = scratch_take(scratch, bytes);
    assert_non_null(used);
    memset(used, 0xff, bytes);
    scratch_give(scratch, used);
    patch->scratch = scratch;
    assert_int_equal(
        receivers_create(&light, patch, KERNELS_BEST(shadow_kernels), wide, &receivers), 0);
    const struct shadow_pixels *p = &receivers.pixels;
    for (int32_t y = wide.y0; y < wide.y1; y++) {
        for (int32_t x = wide.x0; x < wide.x1; x++) {
            const bool within = x >= 0 && x < 64 && y >= 0 && y < 48;
            const size_t i = receivers_pixel(&receivers, x, y);
            assert_int_equal(receiver_is_lit(p, i), within);
            assert_true(within ? p->distance[i] > 0.0f : p->distance[i] == 0.0f);
            assert_bare(p, i);
        }
    }
    for (size_t i = 0; i < SHADOW_PLANE_PAD; i++) /* past the end */
        assert_false(receiver_is_lit(p, (size_t)rect_area(wide) + i));
    receivers_fini(&receivers);
    patch->scratch = NULL; /* where the patch itself is from */
    scratch_destroy(&scratch);
    patch_destroy(&patch);
}
