/* Light samples of the sky in a room and in the open: that they are right, and where they go. What
 * a scene keeps of its skies. */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/worker/scene/environment_draws.h"
#include "tests/unit/worker/scene/room_fixture.h"
#include "worker/scene/sky_guide.h"

enum { WIDTH = 16, HEIGHT = 8 };

static struct room_fixture r;
static struct openness *o;
static float texels[3 * WIDTH * HEIGHT];

static void open_scene(bool has_room)
{
    room_fixture_begin(&r);
    if (has_room) room_fixture_add_room(&r);
    room_fixture_build(&r);
    o = openness_create(r.scene);
    assert_non_null(o);
    openness_learn(o);
}

static void close_scene(void)
{
    openness_destroy(&o);
    room_fixture_close(&r);
}

/* Columns go on by `shift`. */
static void open_map(uint32_t shift)
{
    float shifted[3 * WIDTH * HEIGHT];
    numbers.state = 31;
    for (uint32_t i = 0; i < 3 * WIDTH * HEIGHT; i++) texels[i] = 0.3f + random_unit(&numbers);
    for (uint32_t i = 0; i < 3 * WIDTH * HEIGHT; i++) {
        const uint32_t x = (i / 3 % WIDTH + shift) % WIDTH, y = i / 3 / WIDTH;
        shifted[3 * (y * WIDTH + x) + i % 3] = texels[i];
    }
    environment_fixture_open(&f, WIDTH, HEIGHT, shifted);
}

static struct plan_environment plan_of(float rotation_rad)
{
    return (struct plan_environment){
        .kind = ENVIRONMENT_MAP, .rotation_rad = rotation_rad, .radiance = {1, 1, 1}, .power = 1};
}

static struct sky_guide *guide_of(float rotation_rad)
{
    const struct plan_environment plan = plan_of(rotation_rad);
    struct sky_guide *g = sky_guide_create(f.map, &plan, o);
    assert_non_null(g);
    return g;
}

static void to_map(const struct sky_guide *g, const float d[3], float out[3])
{
    out[0] = g->cosine * d[0] + g->sine * d[2];
    out[1] = d[1];
    out[2] = g->cosine * d[2] - g->sine * d[0];
}

/* The density with which a surface's samples go into a direction of the world. */
static double density(const struct sky_guide *g, const float place[3], const float normal[3],
                      const float direction[3])
{
    float d[3], width, height;
    to_map(g, direction, d);
    environment_size(f.map, &width, &height);
    const struct environment_density at =
        environment_density(f.map, d, environment_find(d, width, height));
    const struct sky_table *t =
        &g->tables[sky_guide_table(g, place[0], place[1], place[2], normal)];
    return (double)(sky_table_probability(t, at.bin) * at.within);
}

/* A direction of the world, with its density. */
static double sample(const struct sky_guide *g, const float place[3], const float normal[3],
                     float direction[3])
{
    float choice = random_unit(&numbers), d[3], width, height;
    const float u[2] = {random_unit(&numbers), random_unit(&numbers)};
    const struct sky_table *t =
        &g->tables[sky_guide_table(g, place[0], place[1], place[2], normal)];
    const uint32_t bin = sky_table_choose(t, &choice);
    environment_size(f.map, &width, &height);
    const struct environment_texel texel =
        environment_texel_of(f.map, environment_choose(f.map, bin, choice, u));
    environment_place(texel, width, u, d);
    direction[0] = g->cosine * d[0] - g->sine * d[2];
    direction[1] = d[1];
    direction[2] = g->sine * d[0] + g->cosine * d[2];
    return (double)(sky_table_probability(t, bin) * texel.density);
}

/* What a direction brings to a surface. */
static double brings(const struct sky_guide *g, const float place[3], const float normal[3],
                     const float direction[3])
{
    float d[3], rgb[3];
    const double cosine =
        (double)(normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2]);
    if (cosine <= 0.0 || !room_fixture_sees(&r, place, direction)) return 0.0;
    to_map(g, direction, d);
    environment_lookup(f.map, d, rgb);
    return cosine * (double)rgb[1];
}

/* By one random direction in each of 256 x 256 parts of the sphere. */
static double brute_force(const struct sky_guide *g, const float place[3], const float normal[3])
{
    const int side = 256;
    double sum = 0.0;
    for (int i = 0; i < side * side; i++) {
        const double down = (i / side + (double)random_unit(&numbers)) / side;
        const double turn = 2.0 * M_PI * (i % side + (double)random_unit(&numbers)) / side;
        const double y = 1.0 - 2.0 * down, wide = sqrt(1.0 - y * y);
        const float d[3] = {(float)(wide * cos(turn)), (float)y, (float)(wide * sin(turn))};
        sum += brings(g, place, normal, d);
    }
    return sum * 4.0 * M_PI / (side * side);
}

/* Returns the share of samples that bring anything. */
static double check_irradiance(const struct sky_guide *g, const float place[3],
                               const float normal[3])
{
    const int samples = 20000;
    double sum = 0.0, squares = 0.0;
    int used = 0;
    for (int i = 0; i < samples; i++) {
        float d[3];
        const double pdf = sample(g, place, normal, d);
        assert_true(pdf > 0.0);
        const double value = brings(g, place, normal, d) / pdf;
        sum += value;
        squares += value * value;
        used += value > 0.0;
    }
    const double mean = sum / samples, exact = brute_force(g, place, normal);
    const double error = sqrt(fmax(squares / samples - mean * mean, 0.0) / samples);
    if (fabs(mean - exact) > 4.5 * error + 3e-3 * exact)
        print_message("# %.5f, expected %.5f, error %.5f\n", mean, exact, error);
    assert_true(fabs(mean - exact) <= 4.5 * error + 3e-3 * exact);
    return (double)used / samples;
}

TEST(samples_estimate_what_surfaces_receive)
{
    static const float places[][3] = {{0, 1.5f, 0}, {-1.7f, 0.3f, 1.6f}, {1.8f, 2.7f, -1.8f}};
    open_map(0);
    for (int scene = 0; scene < 2; scene++) {
        open_scene(scene == 1);
        struct sky_guide *g = guide_of(0.8f);
        numbers.state = 32;
        for (int i = 0; i < 30; i++) {
            float n[3];
            random_direction(n);
            if (i < 6)
                for (int k = 0; k < 3; k++) n[k] = k == i / 2 ? (i % 2 ? 1.0f : -1.0f) : 0.0f;
            (void)check_irradiance(g, places[i % 3], n);
        }
        sky_guide_destroy(&g);
        close_scene();
    }
    environment_fixture_close(&f);
}

/* A fifth of a wall's samples would find the window by chance at most. */
TEST(samples_in_a_room_go_to_its_window)
{
    static const float place[3] = {-1.5f, 1.6f, 0.1f}, normal[3] = {1, 0, 0};
    open_map(0);
    open_scene(true);
    struct sky_guide *g = guide_of(2.1f);
    numbers.state = 33;
    const double guided = check_irradiance(g, place, normal);
    sky_guide_destroy(&g);
    openness_destroy(&o);
    g = guide_of(2.1f);
    const double blind = check_irradiance(g, place, normal);
    print_message("# %.3f of samples get out, %.3f of blind ones\n", guided, blind);
    assert_true(guided > 3.0 * blind);
    sky_guide_destroy(&g);
    room_fixture_close(&r);
    environment_fixture_close(&f);
}

/* A map turned by a quarter, and one whose columns are further on by a quarter. */
TEST(turned_maps_are_sampled_as_others)
{
    static const float place[3] = {-1, 1, -1};
    double turned[400];
    float d[400][3], n[400][3];
    open_scene(true);
    for (uint32_t k = 0; k < 2; k++) {
        open_map(k * WIDTH / 4);
        struct sky_guide *g = guide_of(k ? 0.0f : (float)(0.5 * M_PI));
        numbers.state = 34;
        uint32_t others = 0;
        for (int i = 0; i < 400; i++) {
            random_direction(d[i]);
            random_direction(n[i]);
            const double at = density(g, place, n[i], d[i]);
            assert_true(at > 0.0);
            if (k == 0) turned[i] = at;
            others += fabs(at - turned[i]) > 0.01 * at + 1e-3;
        }
        assert_true(others <= 4);
        sky_guide_destroy(&g);
        environment_fixture_close(&f);
    }
    close_scene();
}

/* ---- what a scene keeps ---- */

static const struct sky_guide *take(struct sky_guides *all, uint8_t map, float rotation_rad)
{
    struct plan_environment plan = plan_of(rotation_rad);
    memset(&plan.map, map, sizeof plan.map);
    const struct sky_guide *g = sky_guides_take(all, f.map, &plan);
    assert_non_null(g);
    assert_true(fabsf(g->cosine - cosf(rotation_rad)) < 1e-5f);
    assert_true(sky_table_probability(g->tables, environment_bin_at(0, 0)) > 0.0f);
    return g;
}

TEST(guides_are_made_once_and_few_are_kept)
{
    const struct sky_guide *g[6];
    open_map(0);
    open_scene(true);
    struct sky_guides *all = sky_guides_create(r.scene);
    for (int i = 0; i < 3; i++) g[i] = take(all, 1, (float)i);
    for (int i = 0; i < 3; i++) {
        assert_ptr_equal(take(all, 1, (float)i), g[i]);
        sky_guides_give(all, g[i]);
    }
    assert_ptr_not_equal(take(all, 2, 0.0f), g[0]); /* while others hold the three */
    g[3] = take(all, 2, 0.0f);
    g[4] = take(all, 1, 4.0f);
    for (int i = 0; i < 3; i++) assert_ptr_equal(take(all, 1, (float)i), g[i]);
    for (int i = 0; i < 3; i++) sky_guides_give(all, g[i]);
    assert_int_equal(sky_guides_count(all), 5);
    for (int i = 0; i < 5; i++) sky_guides_give(all, g[i]);
    sky_guides_give(all, g[3]);
    g[5] = take(all, 1, 5.0f);
    assert_int_equal(sky_guides_count(all), 3);
    for (int i = 1; i < 3; i++) assert_ptr_equal(take(all, 1, (float)i), g[i]); /* taken last */
    sky_guides_destroy(&all);
    assert_null(all);
    close_scene();
    environment_fixture_close(&f);
}

static void *take_many(void *guides)
{
    for (int i = 0; i < 60; i++) {
        const struct sky_guide *a = take(guides, 1, (float)(i % 5));
        const struct sky_guide *b = take(guides, 1, (float)(i % 4));
        assert_true((a == b) == (i % 5 == i % 4));
        sky_guides_give(guides, a);
        assert_true(fabsf(b->cosine - cosf((float)(i % 4))) < 1e-5f);
        sky_guides_give(guides, b);
    }
    return NULL;
}

TEST(threads_share_guides)
{
    pthread_t id[4];
    open_map(0);
    open_scene(true);
    struct sky_guides *all = sky_guides_create(r.scene);
    for (int i = 0; i < 4; i++) assert_int_equal(pthread_create(&id[i], NULL, take_many, all), 0);
    for (int i = 0; i < 4; i++) pthread_join(id[i], NULL);
    (void)take(all, 1, 9.0f);
    assert_true(sky_guides_count(all) <= 3);
    sky_guides_destroy(&all);
    close_scene();
    environment_fixture_close(&f);
}
