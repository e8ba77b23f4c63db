/* Frames go to Open Image Denoise and come back: what it is given, what stays, what is refused. */
#include <math.h>

#include "proto/job/job.h"
#include "server/reconstruct/oidn/oidn.h"
#include "tests/random.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/oidn/fake_oidn.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"

#define WIDTH  7
#define HEIGHT 5
#define AREA   (WIDTH * HEIGHT)

/* A picture with light of fields, and what paths have brought to it. */
struct case_of {
    struct image *image;
    const struct plane *shown[3];
    struct oidn_picture picture;
    float fields[3 * AREA];
    struct fault fault;
    int calls;
};

static int set_up(void **state)
{
    static const char *const names[3] = {"R", "G", "B"};
    struct random random = {7};
    struct case_of *c = calloc(1, sizeof *c);
    if (!c || image_create_named(names, 3, WIDTH, HEIGHT, &c->image)) return -1;
    if (oidn_picture_create(WIDTH, HEIGHT, &c->picture)) return -1;
    for (int k = 0; k < 3; k++) c->shown[k] = &c->image->channels[k].plane;
    for (int i = 0; i < 3 * AREA; i++) {
        c->fields[i] = i % 4 == 0 ? 0.0f : (float)random_unit(&random);
        c->picture.light[i] = (float)random_unit(&random);
        c->picture.albedo[i] = 0.25f + 0.5f * (float)random_unit(&random);
        c->picture.normal[i] = (float)random_unit(&random) - 0.5f;
        *plane_at(c->shown[i % 3], i / 3 % WIDTH, i / 3 / WIDTH) =
            c->fields[i] + c->picture.light[i];
    }
    *state = c;
    return 0;
}

static int tear_down(void **state)
{
    struct case_of *c = *state;
    image_destroy(&c->image);
    oidn_picture_fini(&c->picture);
    free(c);
    return 0;
}

EACH_TEST(set_up, tear_down);

static bool goes_on(void *ctx, double share)
{
    struct case_of *c = ctx;
    (void)share;
    c->calls++;
    return true;
}

static bool stops(void *ctx, double share)
{
    goes_on(ctx, share);
    return false;
}

static int filter_until(struct case_of *c, const char *behaviour, bool (*go_on)(void *, double))
{
    struct oidn_library library;
    assert_int_equal(fake_oidn_open("fake", behaviour, &library, &c->fault), 0);
    const struct oidn_call call = {&library, go_on, c};
    const int error = oidn_filter(&call, &c->picture, c->shown, &c->fault);
    oidn_library_close(&library);
    return error;
}

static int filter(struct case_of *c, const char *behaviour)
{
    return filter_until(c, behaviour, goes_on);
}

static float result(const struct case_of *c, int channel, int pixel)
{
    return c->picture.albedo[channel * AREA + pixel];
}

/* Where paths bring all, the picture is what the library makes of it, to the last bit. */
TEST(what_fields_bring_stays)
{
    struct case_of *c = *state;
    float light[3 * AREA];
    memcpy(light, c->picture.light, sizeof light);
    assert_int_equal(filter(c, "half"), 0);
    assert_int_equal(c->calls, 1);
    for (int i = 0; i < 3 * AREA; i++) {
        const float want = c->fields[i] + 0.5f * light[i], got = result(c, i % 3, i / 3);
        if (c->fields[i] == 0.0f) assert_true(got == 0.5f * light[i]);
        assert_true(fabsf(got - want) < 1e-6f);
        assert_true(*plane_at(c->shown[i % 3], i / 3 % WIDTH, i / 3 / WIDTH) ==
                    c->fields[i] + light[i]); /* only read */
    }
}

TEST(albedo_and_normals_guide)
{
    struct case_of *c = *state;
    float guides[6];
    memcpy(guides, c->picture.albedo, 3 * sizeof *guides);
    memcpy(guides + 3, c->picture.normal, 3 * sizeof *guides);
    for (int i = 0; i < 3 * AREA; i++) *plane_at(c->shown[i % 3], i / 3 % WIDTH, i / 3 / WIDTH) = 1;
    for (int i = 0; i < 3 * AREA; i++) c->picture.light[i] = 0;
    assert_int_equal(filter(c, "guides"), 0);
    for (int k = 0; k < 6; k++)
        assert_true(fabsf(result(c, k % 3, 1 + k / 3) - (1.0f + guides[k])) < 1e-6f);
    assert_true(result(c, 0, 3) == 1.0f);
}

TEST(nothing_is_below_zero)
{
    struct case_of *c = *state;
    assert_int_equal(filter(c, "negative"), 0);
    for (int i = 0; i < 3 * AREA; i++) assert_true(result(c, i % 3, i / 3) >= 0.0f);
}

static void expect(struct case_of *c, const char *behaviour, int error, const char *words)
{
    assert_int_equal(filter(c, behaviour), error);
    assert_int_equal(c->fault.code, error);
    assert_string_equal(c->fault.pointer, "/filter/residual");
    if (!strstr(c->fault.detail, words)) fail_msg("\"%s\" lacks \"%s\"", c->fault.detail, words);
}

TEST(what_goes_wrong_is_told)
{
    struct case_of *c = *state;
    expect(c, "nan", ERR_NOT_FINITE,
           "Open Image Denoise 2.3.99 gave 1 numbers of 105 that are not finite");
    expect(c, "execute", ERR_UNSUPPORTED, "Open Image Denoise 2.3.99: it was asked to fail");
    expect(c, "filter", ERR_UNSUPPORTED, "Open Image Denoise 2.3.99 makes no filter");
    expect(c, "memory", ERR_MEMORY, "Open Image Denoise 2.3.99: there is no memory");
}

TEST(it_ends_when_nobody_wants_it)
{
    struct case_of *c = *state;
    assert_int_equal(filter_until(c, "half", stops), ERR_UNSUPPORTED);
    assert_int_equal(c->calls, 1);
}

static float normal_of(int32_t x, int32_t y, uint32_t c)
{
    return (float)(x - y) * 0.03f * (float)(c + 1);
}

static void land(const struct plan *plan, struct film *film)
{
    struct tile_grid grid;
    assert_int_equal(tile_grid_init(&grid, plan->width_px, plan->height_px, plan->tile_px), 0);
    for (uint32_t t = 0; t < tile_grid_count(&grid); t++) {
        const struct rect r = tile_grid_rect(&grid, t);
        struct samples *s = synthetic_pass(plan, t, 0);
        size_t i = 0;
        for (int32_t y = r.y0; y < r.y1; y++)
            for (int32_t x = r.x0; x < r.x1; x++, i++)
                for (uint32_t c = 0; c < 3; c++)
                    samples_f32(s, PLANE_PATH_NORMAL, c)[i] = 4.0f * normal_of(x, y, c);
        assert_int_equal(film_land(film, t, 0, s), 0);
    }
}

/* Block by block: the light is to the last bit what the picture has. */
TEST(a_frame_is_kept_block_by_block)
{
    struct plan plan;
    struct image *image;
    struct oidn_picture picture;
    uint32_t block;
    synthetic_paths_plan(&plan, 40, 20, 16, 4);
    plan.planes |= PLANE_BIT(PATH_NORMAL);
    plan.residual_filter = RESIDUAL_FILTER_OIDN;
    struct film *film = picture_film(&plan, 16, 0);
    assert_int_equal(image_create(LAYER_BEAUTY | LAYER_ALBEDO, 40, 20, &image), 0);
    assert_int_equal(oidn_picture_create(40, 20, &picture), 0);
    land(&plan, film);
    while (film_next_ready(film, &block)) {
        struct patch *patch;
        struct block_statistics statistics;
        const struct rect rect = film_block_rect(film, block);
        assert_int_equal(film_gather(film, block, &patch), 0);
        assert_int_equal(block_reconstruct(&plan, patch, rect, image, &statistics), 0);
        assert_int_equal(statistics.residual.pixels, 0);
        oidn_picture_put(patch, rect, &picture);
        patch_destroy(&patch);
        film_block_done(film, block);
    }
    for (int32_t i = 0; i < 40 * 20 * 3; i++) {
        const int32_t x = i / 3 % 40, y = i / 120, c = i % 3;
        const char light[] = {"RGB"[c], '\0'},
                   albedo[] = {'a', 'l', 'b', 'e', 'd', 'o', '.', light[0], '\0'};
        assert_true(picture.light[i] == picture_at(image, light, x, y));
        assert_true(picture.albedo[i] == picture_at(image, albedo, x, y));
        assert_true(fabsf(picture.normal[i] - normal_of(x, y, (uint32_t)c)) < 1e-6f);
    }
    oidn_picture_fini(&picture);
    image_destroy(&image);
    film_destroy(&film);
}
