/* Where mirrors and lenses gather light. Of a flat mirror it is known: from the lamp's image. */
#include <math.h>

#include "tests/unit/worker/scene/environment_fixture.h"
#include "tests/unit/worker/scene/room_fixture.h"
#include "worker/scene/caustics.h"

static struct room_fixture r;

/* A floor at y = 0 and a lamp at x = -1, y = 2 that faces down. */
static void begin(void)
{
    room_fixture_begin(&r);
    const uint32_t floor = fixture_material(r.parts, 0.5f, 0.5f, 0.5f);
    const uint32_t lamp = fixture_material(r.parts, 0, 0, 0);
    r.parts->materials[lamp].emission[1] = 10.0f;
    fixture_panel(r.parts, floor, (float[]){0, 0, 0}, (float[]){9, 0, 0}, (float[]){0, 0, -9});
    fixture_panel(r.parts, lamp, (float[]){-1, 2, 0}, (float[]){0.1f, 0, 0}, (float[]){0, 0, 0.1f});
}

/* In the plane x = 1, above the floor. */
static uint32_t add_mirror(float roughness, float metallic)
{
    const uint32_t mirror = fixture_glossy(r.parts, (float[]){1, 1, 1}, roughness, metallic);
    fixture_panel(r.parts, mirror, (float[]){1, 1, 0}, (float[]){0, 1, 0}, (float[]){0, 0, 2});
    return mirror;
}

static const struct photons *lamps(void)
{
    room_fixture_build(&r);
    return r.scene->caustics;
}

TEST(photons_of_a_mirror_come_from_the_lamps_image)
{
    begin();
    add_mirror(0.0f, 1.0f);
    const struct photons *map = lamps();
    assert_non_null(map);
    for (uint32_t i = 0; i < map->count; i++) {
        const struct photon *p = &map->photons[i];
        assert_true(fabsf(p->from[0] - 1.0f) < 1e-4f && fabsf(p->place[1]) < 1e-4f);
        /* back along the line from the place, to the image at x = 3, y = 2 */
        const float way = (2.0f - p->place[1]) / (p->from[1] - p->place[1]);
        const float x = p->place[0] + way * (p->from[0] - p->place[0]);
        const float z = p->place[2] + way * (p->from[2] - p->place[2]);
        assert_true(fabsf(x - 3.0f) < 0.11f && fabsf(z) < 0.11f);
    }
    room_fixture_close(&r);
}

/* Returns the flux over the irradiance of the image, a small lamp: luminance area cos cos /
 * distance^2. Boxes around few photons are smaller than what they stand for. */
static double flux_over_images(void)
{
    const struct photons *map = lamps();
    double ratio = 0.0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < map->leaf_count; i++) {
        const struct photon_leaf *leaf = &map->leaves[i];
        const double x = 0.5 * (leaf->low[0] + leaf->high[0]) - 3.0;
        const double z = 0.5 * (leaf->low[2] + leaf->high[2]), d2 = x * x + z * z + 4.0;
        const double size = leaf->high[0] - leaf->low[0] + leaf->high[2] - leaf->low[2];
        if (size > 0.4) continue;
        ratio += leaf->flux / (0.7152 * 10.0 * 0.04 * 4.0 / (d2 * d2));
        count++;
    }
    assert_true(count > 20);
    return ratio / count;
}

TEST(flux_is_that_of_the_image)
{
    begin();
    add_mirror(0.0f, 1.0f);
    const double whole = flux_over_images();
    assert_true(whole > 0.9 && whole < 2.2);
    room_fixture_close(&r);
    begin(); /* of as many spheres around one place each photon counts once */
    const uint32_t mirror = fixture_glossy(r.parts, (float[]){1, 1, 1}, 0.0f, 1.0f);
    for (int k = 0; k < 16; k++)
        fixture_panel(r.parts, mirror, (float[]){1, 1, 0.25f * (float)k - 1.875f},
                      (float[]){0, 1, 0}, (float[]){0, 0, 0.125f});
    const double parts = flux_over_images();
    assert_true(parts > 0.8 * whole && parts < 1.25 * whole);
    room_fixture_close(&r);
    begin(); /* what colours take is lost */
    const uint32_t dark = add_mirror(0.0f, 1.0f);
    for (int k = 0; k < 3; k++) r.parts->materials[dark].base_color[k] = 0.25f;
    const double left = flux_over_images();
    assert_true(left > 0.2 * whole && left < 0.3 * whole);
    room_fixture_close(&r);
}

TEST(black_mirrors_gather_nothing)
{
    begin();
    const uint32_t black = add_mirror(0.0f, 1.0f);
    for (int k = 0; k < 3; k++) r.parts->materials[black].base_color[k] = 0.0f;
    assert_null(lamps());
    room_fixture_close(&r);
}

TEST(only_mirrors_and_lenses_gather_light)
{
    static const struct {
        float roughness, metallic, transmission, ior;
        bool volume, gathers;
    } cases[] = {{0.1f, 1, 0, 1.5f, false, true},
                 {0.5f, 1, 0, 1.5f, false, false},
                 {0.1f, 0, 0, 1.5f, false, false},
                 {0, 0, 1, 1.5f, false, false},
                 {0, 0, 1, 1.0f, true, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        begin();
        const uint32_t m = add_mirror(cases[i].roughness, cases[i].metallic);
        r.parts->materials[m].transmission = cases[i].transmission;
        r.parts->materials[m].ior = cases[i].ior;
        if (cases[i].volume) r.parts->materials[m].thickness = 1.0f;
        assert_int_equal(lamps() != NULL, cases[i].gathers);
        room_fixture_close(&r);
    }
}

/* A slab of glass between lamp and floor moves photons aside, and no farther than it is thick. */
TEST(a_slab_lets_light_through)
{
    begin();
    const uint32_t glass = fixture_glossy(r.parts, (float[]){1, 1, 1}, 0.0f, 0.0f);
    r.parts->materials[glass].transmission = 1.0f;
    r.parts->materials[glass].thickness = 1.0f;
    fixture_panel(r.parts, glass, (float[]){-1, 1, 0}, (float[]){2, 0, 0}, (float[]){0, 0, -2});
    fixture_panel(r.parts, glass, (float[]){-1, 0.8f, 0}, (float[]){2, 0, 0}, (float[]){0, 0, 2});
    const struct photons *map = lamps();
    assert_non_null(map);
    uint32_t through = 0;
    for (uint32_t i = 0; i < map->count; i++)
        through += fabsf(map->photons[i].from[1] - 0.8f) < 1e-4f;
    assert_true(through > 0.9 * map->count);
    room_fixture_close(&r);
}

/* A sun low in the west, which a mirror that faces it throws on the floor. */
TEST(suns_are_gathered_and_plain_skies_are_not)
{
    for (int sunny = 0; sunny < 2; sunny++) {
        static float texels[3 * 64 * 32];
        struct environment_fixture sky;
        for (int i = 0; i < 3 * 64 * 32; i++) texels[i] = 0.2f;
        /* u = 0.5 + atan2(z, x) / 2 pi: the first column looks along -x */
        for (int k = 0; sunny && k < 3; k++) texels[3 * (64 * 11) + k] = 900.0f;
        environment_fixture_open(&sky, 64, 32, texels);
        begin();
        add_mirror(0.0f, 1.0f);
        room_fixture_build(&r);
        struct photons *map;
        assert_int_equal(caustics_of_sky(r.scene, sky.map, 1.0f, 0.0f, &map), 0);
        assert_int_equal(map != NULL, sunny);
        for (uint32_t i = 0; map && i < map->count; i++) {
            const struct photon *p = &map->photons[i];
            assert_true(fabsf(p->from[0] - 1.0f) < 1e-4f && p->place[0] < 1.0f);
        }
        photons_destroy(&map);
        room_fixture_close(&r);
        environment_fixture_close(&sky);
    }
}
