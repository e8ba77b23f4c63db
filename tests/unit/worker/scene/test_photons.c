/* A map of photons: leaves of near ones, and what they tell of where light comes from. */
#include <math.h>
#include <stdlib.h>

#include "proto/pattern_path.h"
#include "tests/unit/unit.h"
#include "worker/scene/photons.h"

enum { COUNT = 3000 };

static const float up[3] = {0, 1, 0}, down[3] = {0, -1, 0};

static float random_of(uint32_t *state)
{
    *state += 0x9e3779b9u;
    return (float)(path_mix(*state) >> 8) * 0x1p-24f;
}

/* On a square of side 2 in the plane y = 1, from points above that move three times as far. */
static struct photons *square(void)
{
    struct photon *p = malloc(COUNT * sizeof *p);
    uint32_t state = 7;
    for (int i = 0; i < COUNT; i++) {
        const float x = 2.0f * random_of(&state) - 1.0f, z = 2.0f * random_of(&state) - 1.0f;
        p[i] = (struct photon){.place = {x, 1, z}, .from = {3 * x, 5, 3 * z + 0.5f}, .power = 0.5f};
    }
    struct photons *map = photons_create(p, COUNT);
    assert_non_null(map);
    for (uint32_t i = 0; i < map->leaf_count; i++) map->leaves[i].share = 1.0f;
    return map;
}

TEST(every_photon_is_in_its_own_leaf)
{
    struct photons *map = square();
    uint32_t seen = 0, own = 0;
    for (uint32_t i = 0; i < map->leaf_count; i++) {
        const struct photon_leaf *leaf = &map->leaves[i];
        assert_true(leaf->count >= PHOTONS_IN_LEAF / 2 && leaf->count <= PHOTONS_IN_LEAF);
        assert_int_equal(leaf->first, seen);
        seen += leaf->count;
        for (uint32_t k = 0; k < leaf->count; k++)
            own += photons_find(map, map->photons[leaf->first + k].place, up) == leaf;
    }
    assert_int_equal(seen, COUNT);
    assert_int_equal(own, COUNT); /* no two are at one place */
    photons_destroy(&map);
}

TEST(no_leaf_is_where_no_photon_is)
{
    struct photons *map = square();
    assert_null(photons_find(map, (const float[]){0, 1.5f, 0}, up));
    assert_null(photons_find(map, (const float[]){4, 1, 0}, up));
    assert_non_null(photons_find(map, (const float[]){0.3f, 1, 0.2f}, up));
    assert_null(photons_find(map, (const float[]){0.3f, 1, 0.2f}, down)); /* its far side */
    photons_destroy(&map);
}

TEST(a_leaf_without_a_share_is_none)
{
    struct photons *map = square();
    for (uint32_t i = 0; i < map->leaf_count; i++) map->leaves[i].share = 0.0f;
    assert_null(photons_find(map, (const float[]){0.3f, 1, 0.2f}, up));
    photons_destroy(&map);
}

/* All power, over the area of the square; boxes around few photons are smaller than their part. */
TEST(flux_is_power_over_area)
{
    struct photons *map = square();
    double area = 0.0, power = 0.0;
    for (uint32_t i = 0; i < map->leaf_count; i++) {
        const struct photon_leaf *leaf = &map->leaves[i];
        area += 0.5 * leaf->count / leaf->flux;
        power += 0.5 * leaf->count;
    }
    assert_true(power / area > 0.9 * 0.5 * COUNT / 4.0);
    assert_true(power / area < 2.0 * 0.5 * COUNT / 4.0);
    photons_destroy(&map);
}

/* Where last points move with places, they are known to much less than they are apart. */
TEST(what_moves_with_the_place_is_followed)
{
    struct photons *map = square();
    for (uint32_t i = 0; i < map->leaf_count; i++) {
        const struct photon_leaf *leaf = &map->leaves[i];
        assert_true(fabsf(leaf->turn[0][0] - 3.0f) < 0.9f && fabsf(leaf->turn[2][2] - 3.0f) < 0.9f);
        assert_true(fabsf(leaf->turn[0][2]) < 0.3f && fabsf(leaf->turn[1][0]) < 0.3f);
        const float wide = leaf->high[0] - leaf->low[0] + leaf->high[2] - leaf->low[2];
        for (uint32_t k = 0; k < leaf->count; k++)
            assert_true(map->photons[leaf->first + k].reach < 0.6f * wide);
    }
    photons_destroy(&map);
}

TEST(photons_at_one_place_are_finite)
{
    struct photon *p = malloc(64 * sizeof *p);
    for (int i = 0; i < 64; i++)
        p[i] = (struct photon){.place = {1, 2, 3}, .from = {1, (float)i, 3}, .power = 1.0f};
    struct photons *map = photons_create(p, 64);
    for (uint32_t i = 0; i < map->leaf_count; i++) {
        assert_true(map->leaves[i].flux == 0.0f); /* of no area: nobody is sent there */
        for (int k = 0; k < 9; k++) assert_true(map->leaves[i].turn[k / 3][k % 3] == 0.0f);
    }
    for (int i = 0; i < 64; i++) assert_true(isfinite(map->photons[i].reach));
    photons_destroy(&map);
}

TEST(few_photons_make_no_map)
{
    assert_null(
        photons_create(calloc(PHOTONS_IN_LEAF - 1, sizeof(struct photon)), PHOTONS_IN_LEAF - 1));
}
