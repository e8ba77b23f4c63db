/* Skies in lanes: the bits of one direction at a time, on every instruction set, and a direction
 * lies in the texel that it was placed in. */
#include "tests/random.h"
#include "tests/unit/unit.h"
#include "tests/unit/worker/tile_fixture.h"
#include "tests/unit/worker/trace/isa_fixture.h"

#include "tests/unit/worker/scene/environment_fixture.h"
#include "worker/trace/path/path_kernels.h"
#include "worker/trace/path/path_nee.h"

enum { WIDTH = 12, HEIGHT = 7 };

static struct environment_fixture f, night;
static struct sky sky;
static struct sky_guide *guide;

static int open_sky(void **state)
{
    static float texels[3 * WIDTH * HEIGHT];
    struct random r = {1};
    (void)state;
    for (size_t i = 0; i < 3 * WIDTH * HEIGHT; i++) texels[i] = random_unit(&r);
    environment_fixture_open(&f, WIDTH, HEIGHT, texels);
    static const float dark[3 * WIDTH * HEIGHT];
    environment_fixture_open(&night, WIDTH, HEIGHT, dark);
    const struct plan_environment plan = {
        .kind = ENVIRONMENT_MAP, .rotation_rad = 0.7f, .radiance = {1, 1, 1}};
    guide = sky_guide_create(f.map, &plan, NULL);
    assert_non_null(guide);
    sky_init(&sky, &plan, f.map, guide);
    return 0;
}

static int close_sky(void **state)
{
    (void)state;
    sky_guide_destroy(&guide);
    environment_fixture_close(&f);
    environment_fixture_close(&night);
    return 0;
}

ALL_TESTS(open_sky, close_sky);

static float random_signed(struct random *r)
{
    return (float)(int32_t)(uint32_t)random_bits(r) * 0x1p-31f;
}

/* Poles, axes and what is no direction among them. */
static void random_directions(struct random *r, struct lanes3 *d)
{
    static const float odd[][3] = {{0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {1, -0.0f, -0.0f}, {0, 0, 0}};
    for (int i = 0; i < LANES; i++) {
        d->x[i] = random_signed(r), d->y[i] = random_signed(r), d->z[i] = random_signed(r);
        if (random_bits(r) % 4) continue;
        const float *v = odd[random_bits(r) % 5];
        d->x[i] = v[0], d->y[i] = v[1], d->z[i] = v[2];
    }
}

TEST(test_find)
{
    struct random r = {2};
    for (int round = 0; round < 500; round++) {
        struct lanes3 d;
        random_directions(&r, &d);
        for (int k = 0; k < isa_count(); k++) {
            struct sky_view view;
            KERNELS_FOR(path_kernels, all_isas[k])->find_sky(&sky, d.x, d.y, d.z, &view);
            for (int i = 0; i < LANES; i++) {
                const float turned[3] = {sky.cosine * d.x[i] + sky.sine * d.z[i], d.y[i],
                                         sky.cosine * d.z[i] - sky.sine * d.x[i]};
                const struct environment_spot spot = environment_find(turned, WIDTH, HEIGHT);
                assert_true(view.direction.x[i] == turned[0] && view.direction.y[i] == turned[1]);
                assert_true(view.direction.z[i] == turned[2]);
                assert_true(view.u[i] == spot.u && view.v[i] == spot.v);
                assert_true(spot.u >= 0 && spot.u <= WIDTH && spot.v >= 0 && spot.v <= HEIGHT);
            }
        }
    }
}

TEST(test_place)
{
    struct random r = {3};
    for (int round = 0; round < 500; round++) {
        _Alignas(64) float u[LANES], v[LANES];
        uint32_t texel[LANES];
        const uint32_t table = (uint32_t)(random_bits(&r) % SKY_TABLE_NORMALS);
        struct sky_texels texels;
        for (int i = 0; i < LANES; i++) {
            u[i] = 0.02f + 0.96f * random_unit(&r), v[i] = 0.02f + 0.96f * random_unit(&r);
            const struct sky_choice choice =
                sky_expect(&sky, table, random_unit(&r), (float[]){u[i], v[i]});
            texel[i] = sky_choose(&sky, &choice, (float[]){u[i], v[i]});
            sky_look(&sky, &choice, texel[i], i, &texels);
        }
        for (int k = 0; k < isa_count(); k++) {
            const struct path_kernels *kernels = KERNELS_FOR(path_kernels, all_isas[k]);
            struct lanes3 d;
            struct sky_view view;
            kernels->place_sky(&sky, &texels, u, v, &d);
            kernels->find_sky(&sky, d.x, d.y, d.z, &view);
            for (int i = 0; i < LANES; i++) {
                float one[3];
                const float at[2] = {u[i], v[i]};
                environment_place(environment_texel_of(f.map, texel[i]), WIDTH, at, one);
                assert_true(d.x[i] == sky.cosine * one[0] - sky.sine * one[2]);
                assert_true(d.y[i] == one[1]);
                assert_true(d.z[i] == sky.sine * one[0] + sky.cosine * one[2]);
                assert_int_equal((uint32_t)view.v[i] * WIDTH + (uint32_t)view.u[i], texel[i]);
                assert_true(texels.density[i] == sky_pdf(&sky, &view, i, table));
            }
        }
    }
}

/* A path's samples of the sky: lanes that chose it have the ray, cosine over density and radiance
 * of their direction, but where that lies below the surface or the map is black. */
TEST(test_path_samples)
{
    static struct path_vertex v;
    struct random r = {4};
    struct queries q;
    int traced = 0;
    queries_init(&q);
    for (int round = 0; round < 200 * isa_count(); round++) {
        const bool black = round % 8 == 0;
        struct sky dark = sky;
        struct light_selection choice = {.others = true};
        struct nee_sample light;
        const struct path_context c = {.queries = &q,
                                       .kernels =
                                           KERNELS_FOR(path_kernels, all_isas[round % isa_count()]),
                                       .sky = black ? &dark : &sky};
        if (black) dark.map = night.map;
        memset(&light, 0, sizeof light);
        for (int i = 0; i < LANES; i++) {
            choice.chosen[i] = i % 5 == 0 ? LIGHT_CHOICE_EMITTERS : LIGHT_CHOICE_ENVIRONMENT;
            choice.pick[i] = random_unit(&r), choice.u[i] = random_unit(&r);
            choice.v[i] = random_unit(&r);
            light.packet.skip[i] = 99;
            v.surface.normal.y[i] = v.surface.facet.y[i] = 1.0f;
            v.sky_table[i] = (uint32_t)(random_bits(&r) % SKY_TABLE_NORMALS);
        }
        path_nee_sample_sky(&c, &v, &choice, &light);
        const struct RTCRay16 *ray = &light.packet.rays.ray;
        for (int i = 0; i < LANES; i++) {
            struct sky_view view;
            float radiance[3];
            if (i % 5 == 0) {
                assert_int_equal(light.packet.skip[i], 99);
                continue;
            }
            if (black) assert_int_equal(light.packet.skip[i], LIGHT_FACING_AWAY);
            if (light.packet.skip[i] != LIGHT_TRACED) continue;
            traced++;
            c.kernels->find_sky(&sky, ray->dir_x, ray->dir_y, ray->dir_z, &view);
            const float density = sky_pdf(&sky, &view, i, v.sky_table[i]);
            (void)sky_radiance(&sky, &view, i, radiance);
            assert_true(fabsf(light.packet.density[i] - density) <= 1e-5f * density);
            assert_true(ray->dir_y[i] > 0.0f && ray->tfar[i] == INFINITY);
            assert_true(light.packet.irradiance[i] == ray->dir_y[i] / light.packet.density[i]);
            assert_true(light.color.x[i] == radiance[0] && light.color.z[i] == radiance[2]);
        }
    }
    assert_true(traced > 500);
}
