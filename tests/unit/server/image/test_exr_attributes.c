/* Standard attributes of EXR files, as other programs read them. */
#include <OpenEXR/openexr.h>
#include <math.h>
#include <string.h>

#include "server/image/exr_mattes.h"
#include "tests/unit/server/image/exr_room.h"

EACH_TEST(make_dir, remove_dir);

static exr_context_t write_file(const struct exr_metadata *m)
{
    struct image *image;
    struct fault fault = {0};
    exr_context_t file;
    assert_int_equal(image_create(1, 10, 10, &image), 0);
    if (exr_write(path_of("a.exr"), image, m, &fault)) fail_msg("%s", fault.detail);
    image_destroy(&image);
    assert_int_equal(exr_start_read(&file, path_of("a.exr"), NULL), 0);
    return file;
}

/* Seen from (1, 2, 3) towards -x, with up along +z: right is y. */
static const struct plan_camera camera = {.type = CAMERA_PERSPECTIVE,
                                          .eye = {1, 2, 3},
                                          .right = {0, 1, 0},
                                          .up = {0, 0, 1},
                                          .forward = {-1, 0, 0},
                                          .half_width = 0.5f,
                                          .half_height = 0.25f};

/* A point, a row, times a matrix, with its last member divided out. */
static void turn(const exr_attr_m44f_t *m, const float point[3], double out[3])
{
    double v[4];
    for (int j = 0; j < 4; j++) {
        v[j] = (double)m->m[12 + j];
        for (int i = 0; i < 3; i++) v[j] += (double)point[i] * (double)m->m[4 * i + j];
    }
    for (int j = 0; j < 3; j++) out[j] = v[j] / v[3];
}

static bool is_at(const double v[3], double x, double y, double z)
{
    return fabs(v[0] - x) < 1e-5 && fabs(v[1] - y) < 1e-5 && fabs(v[2] - z) < 1e-5;
}

TEST(colours_and_software_are_named)
{
    const struct exr_metadata m = {.build = "0.1.0+abc"};
    exr_context_t file = write_file(&m);
    exr_attr_chromaticities_t c;
    const char *text;
    int32_t length;
    assert_int_equal(exr_attr_get_chromaticities(file, 0, "chromaticities", &c), 0);
    assert_true(c.red_x == 0.64f && c.red_y == 0.33f && c.green_x == 0.3f && c.green_y == 0.6f);
    assert_true(c.blue_x == 0.15f && c.blue_y == 0.06f);
    assert_true(c.white_x == 0.3127f && c.white_y == 0.329f);
    assert_int_equal(exr_attr_get_string(file, 0, "software", &length, &text), 0);
    assert_string_equal(text, "Shearwater 0.1.0+abc");
    exr_finish(&file);
}

static void expect_text(exr_context_t file, const char *name, const char *expected)
{
    const char *text;
    int32_t length;
    assert_int_equal(exr_attr_get_string(file, 0, name, &length, &text), 0);
    assert_string_equal(text, expected);
}

/* The key of CryptoObject is that of Psyop's sample pictures. */
TEST(layers_of_ids_have_manifests)
{
    char *manifests[MATTE_KINDS] = {strdup("{\"bunny\":\"13851a76\"}"), NULL};
    struct exr_metadata m = {.job = NULL};
    const char *text;
    int32_t length;
    assert_int_equal(exr_mattes_create(manifests, &m.mattes), 0);
    exr_context_t file = write_file(&m);
    expect_text(file, "cryptomatte/3ae39a5/name", "CryptoObject");
    expect_text(file, "cryptomatte/3ae39a5/hash", "MurmurHash3_32");
    expect_text(file, "cryptomatte/3ae39a5/conversion", "uint32_to_float32");
    expect_text(file, "cryptomatte/3ae39a5/manifest", "{\"bunny\":\"13851a76\"}");
    assert_int_not_equal(
        exr_attr_get_string(file, 0, "cryptomatte/3ae39a5/manif_file", &length, &text), 0);
    exr_finish(&file);
    exr_mattes_drop(&m.mattes);
}

TEST(a_camera_is_where_it_stood)
{
    const struct exr_metadata m = {.camera = camera, .has_camera = true};
    exr_context_t file = write_file(&m);
    exr_attr_m44f_t to_camera, to_ndc;
    float width;
    double out[3];
    assert_int_equal(exr_attr_get_m44f(file, 0, "worldToCamera", &to_camera), 0);
    assert_int_equal(exr_attr_get_m44f(file, 0, "worldToNDC", &to_ndc), 0);
    assert_int_equal(exr_get_screen_window_width(file, 0, &width), 0);
    exr_finish(&file);
    assert_true(width == 1);
    turn(&to_camera, camera.eye, out);
    assert_true(is_at(out, 0, 0, 0));
    turn(&to_camera, (float[]){-3, 2, 3}, out); /* four before the eye */
    assert_true(is_at(out, 0, 0, -4));
    turn(&to_camera, (float[]){1, 7, 9}, out);
    assert_true(is_at(out, 5, 6, 0));
    turn(&to_ndc, (float[]){-3, 4, 4}, out); /* the upper right corner, four before the eye */
    assert_true(is_at(out, 1, 1, 0.995));
    turn(&to_ndc, (float[]){-1, 1, 3}, out); /* in the middle of the left edge, two before it */
    assert_true(is_at(out, -1, 0, 0.99));
}

TEST(an_orthographic_camera_has_planes)
{
    struct exr_metadata m = {.camera = camera, .has_camera = true};
    m.camera.type = CAMERA_ORTHOGRAPHIC;
    m.camera.half_width = 8;
    m.camera.half_height = 4;
    exr_context_t file = write_file(&m);
    exr_attr_m44f_t to_ndc;
    float width;
    double near[3], far[3];
    assert_int_equal(exr_attr_get_m44f(file, 0, "worldToNDC", &to_ndc), 0);
    assert_int_equal(exr_get_screen_window_width(file, 0, &width), 0);
    exr_finish(&file);
    assert_true(width == 1); /* there is no perspective to tell of */
    turn(&to_ndc, (float[]){-3, 10, 7}, near);
    turn(&to_ndc, (float[]){-900, 10, 7}, far);
    assert_true(is_at(near, 1, 1, near[2]) && is_at(far, 1, 1, far[2]) && near[2] < far[2]);
}

TEST(a_sequence_says_its_rate)
{
    static const struct {
        double fps;
        int32_t num;
        uint32_t denom;
    } all[] = {{24, 24, 1}, {23.976, 24000, 1001}, {29.97, 30000, 1001}, {12.5, 12500, 1000}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const struct exr_metadata m = {.fps = all[i].fps};
        exr_attr_rational_t rate;
        exr_context_t file = write_file(&m);
        assert_int_equal(exr_attr_get_rational(file, 0, "framesPerSecond", &rate), 0);
        assert_int_equal(rate.num, all[i].num);
        assert_int_equal(rate.denom, all[i].denom);
        exr_finish(&file);
    }
}

TEST(what_is_not_known_is_left_out)
{
    const struct exr_metadata m = {.spp = 1};
    exr_context_t file = write_file(&m);
    exr_attr_m44f_t matrix;
    exr_attr_rational_t rate;
    assert_int_not_equal(exr_attr_get_m44f(file, 0, "worldToCamera", &matrix), 0);
    assert_int_not_equal(exr_attr_get_m44f(file, 0, "worldToNDC", &matrix), 0);
    assert_int_not_equal(exr_attr_get_rational(file, 0, "framesPerSecond", &rate), 0);
    exr_finish(&file);
}
