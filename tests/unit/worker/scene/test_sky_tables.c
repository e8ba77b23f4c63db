/* Tables of an environment map's bins: what they promise against what comes out. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/worker/scene/environment_draws.h"
#include "worker/scene/sky_tables.h"

static struct sky_table tables[SKY_TABLE_NORMALS];

static void fill(float rotation_rad, const float *open)
{
    struct sky_tables *t = sky_tables_create(f.map, rotation_rad);
    assert_non_null(t);
    sky_tables_fill(t, open, tables);
    sky_tables_destroy(&t);
    assert_null(t);
}

static const struct sky_table *table_of(float x, float y, float z)
{
    const float length = sqrtf(x * x + y * y + z * z);
    const float normal[3] = {x / length, y / length, z / length};
    return &tables[sky_table_of(normal)];
}

/* Counts where every unit goes, by its ends. */
static void check_choices(const struct sky_table *t)
{
    uint32_t seen[ENVIRONMENT_BINS] = {0};
    float sum = 0.0f;
    for (uint32_t unit = 0; unit < SKY_TABLE_UNITS; unit++) {
        float first = (float)unit / (float)SKY_TABLE_UNITS;
        float last = nextafterf((float)(unit + 1) / (float)SKY_TABLE_UNITS, 0.0f);
        const uint32_t bin = sky_table_choose(t, &first);
        seen[bin]++;
        assert_int_equal(sky_table_choose(t, &last), bin);
        assert_true(first >= 0.0f && first < last && last < 1.0f);
    }
    for (uint32_t i = 0; i < ENVIRONMENT_BINS; i++) {
        const float probability = sky_table_probability(t, i);
        assert_true(probability == (float)seen[i] / (float)SKY_TABLE_UNITS);
        assert_int_equal(probability > 0.0f, environment_bin_share(f.map, i) > 0.0);
        sum += probability;
    }
    assert_true(sum == 1.0f);
}

static void check_all(void)
{
    for (size_t i = 0; i < SKY_TABLE_NORMALS; i++)
        if (i != SKY_TABLE_NORMALS / 2) check_choices(&tables[i]);
}

/* Also of a sun that leaves the other bins a unit each. */
TEST(choices_come_out_as_often_as_tables_say)
{
    static float texels[3 * 70 * 35], open[OPENNESS_BINS];
    numbers.state = 21;
    for (int round = 0; round < 3; round++) {
        for (uint32_t i = 0; i < 70 * 35; i++) {
            const float sun = round == 1 && i == 700 ? 1e9f : 1.0f;
            const float dark = i / 70 > 20 && i % 70 < 20 ? 0.0f : 1.0f;
            for (uint32_t k = 0; k < 3; k++) texels[3 * i + k] = sun * dark * random_unit(&numbers);
        }
        for (uint32_t i = 0; i < OPENNESS_BINS; i++)
            open[i] = fmaxf(0.0f, 4.0f * random_unit(&numbers) - 3.0f);
        environment_fixture_open(&f, 70, 35, texels);
        fill(0.0f, NULL);
        check_all();
        fill(2.0f * (float)round, open);
        check_all();
        environment_fixture_close(&f);
    }
}

TEST(a_black_map_has_one_bin_without_light)
{
    const float texels[3 * 4 * 2] = {0.0f};
    environment_fixture_open(&f, 4, 2, texels);
    fill(1.0f, NULL);
    for (size_t i = 0; i < SKY_TABLE_NORMALS; i++)
        for (uint32_t k = 0; k < 4; k++) {
            const float before = k == 3 ? 0x1.fffffep-1f : 0.3f * (float)k;
            float choice = before;
            assert_int_equal(sky_table_choose(&tables[i], &choice), 0);
            assert_true(choice == before);
        }
    assert_true(environment_bin_share(f.map, 0) == 0.0);
    environment_fixture_close(&f);
}

TEST(one_texel_has_one_bin)
{
    environment_fixture_open(&f, 1, 1, (const float[]){1, 2, 3});
    fill(0.5f, NULL);
    check_all();
    assert_true(sky_table_probability(table_of(0, 1, 0), environment_bin_at(0, 0)) == 1.0f);
    environment_fixture_close(&f);
}

/* Texels as wide as many bins count as where they lie: the first of two lies towards -z. */
TEST(few_texels_are_chosen_by_where_they_lie)
{
    environment_fixture_open(&f, 2, 1, (const float[]){1, 1, 1, 1, 1, 1});
    const uint32_t before = environment_bin_at(0, 0), behind = environment_bin_at(16, 0);
    fill(0.0f, NULL);
    check_all();
    assert_true(sky_table_probability(table_of(0, 0, -1), before) > 0.9f);
    assert_true(sky_table_probability(table_of(0, 0, 1), behind) > 0.9f);
    assert_true(fabsf(sky_table_probability(table_of(0, 1, 0), before) - 0.5f) < 0.01f);
    assert_true(fabsf(sky_table_probability(table_of(1, 0, 0), before) - 0.5f) < 0.01f);
    environment_fixture_close(&f);
}

static void open_even(void)
{
    static float texels[3 * 64 * 32];
    for (size_t i = 0; i < sizeof texels / sizeof texels[0]; i++) texels[i] = 1.0f;
    environment_fixture_open(&f, 64, 32, texels);
}

/* The part of a table's samples with a positive cosine to an axis. */
static float share_along(const struct sky_table *t, const float axis[3])
{
    float sum = 0.0f;
    for (uint32_t v = 0; v < ENVIRONMENT_BINS_V; v++)
        for (uint32_t u = 0; u < ENVIRONMENT_BINS_U; u++) {
            float d[3];
            towards((u + 0.5) / ENVIRONMENT_BINS_U, (v + 0.5) / ENVIRONMENT_BINS_V, d);
            if (d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2] > 0.0f)
                sum += sky_table_probability(t, environment_bin_at(u, v));
        }
    return sum;
}

TEST(surfaces_are_lit_from_before_them)
{
    float least = 1.0f;
    numbers.state = 22;
    open_even();
    fill(0.0f, NULL);
    for (int i = 0; i < 2000; i++) {
        float n[3];
        random_direction(n);
        least = fminf(least, share_along(table_of(n[0], n[1], n[2]), n));
    }
    print_message("# at least %.3f of samples\n", (double)least);
    assert_true(least > 0.8f);
    environment_fixture_close(&f);
}

/* A window of 2 x 2 bins towards +x under maps that are turned, by what is not whole bins, too:
 * what the map shows along +x then lies along (cos, 0, sin). */
TEST(tables_prefer_windows)
{
    static float open[OPENNESS_BINS];
    for (uint32_t i = 0; i < 4; i++) open[(7 + i / 2) * OPENNESS_U + 15 + i % 2] = 1.0f;
    open_even();
    for (int k = 0; k < 3; k++) {
        const double turns = 0.25 * k + (k == 2 ? 0.016 : 0.0);
        float within = 0.0f, d[3];
        fill((float)(2.0 * M_PI * turns), open);
        towards(0.5 - turns, 0.5, d); /* to the window, as the map has it */
        const struct sky_table *t = table_of(d[0], d[1], d[2]);
        for (uint32_t i = 0; i < 8; i++) {
            const double u = 0.5 - turns + (i % 4 - 1.5) / ENVIRONMENT_BINS_U;
            const uint32_t column = (uint32_t)((u - floor(u)) * ENVIRONMENT_BINS_U);
            within += sky_table_probability(t, environment_bin_at(column, 7 + i / 4));
        }
        print_message("# turned by %.3f: %.2f of samples go there\n", turns, (double)within);
        assert_true(within > 0.3f);
        check_choices(t);
    }
    environment_fixture_close(&f);
}
