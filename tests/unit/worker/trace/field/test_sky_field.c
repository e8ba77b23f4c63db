/* Light fields that bring the soft share of an environment without a lens: with paths they are the
 * picture that the path tracer gives alone. */
#include <stdio.h>
#include <stdlib.h>

#include "tests/unit/unit.h"
#include "tests/unit/worker/trace/field/field_room.h"

static void add_lobes(struct plan *p)
{
    p->planes |= PLANES_GLOSSY;
    p->paths.without_glossy_indirect = 1;
}

static double lobe_at(const struct samples *s, uint32_t c, int i)
{
    return samples_u16(s, PLANE_GLOSSY_LOBE, c)[i] / 65535.0 * half_at(s, PLANE_GLOSSY_MEAN, c, i);
}

/* Fields that bring the soft share of the sky take it from paths, whatever lobes there are. */
static void compare_sky(enum kind kind, uint32_t shines, bool lobes)
{
    struct scene_fixture *f = fixture_new();
    struct plan plain = room(f, kind, shines);
    plain.bounces = 2;
    struct plan hybrid = plain;
    add_field(&hybrid, 16);
    if (lobes) add_lobes(&hybrid);
    hybrid.sub_samples = 3;
    struct plan sky = hybrid;
    sky.paths.without_diffuse_indirect = INDIRECT_LEFT_SKY;
    struct sums *a = trace_sums(f, &plain), *b = trace_sums(f, &hybrid), *d = trace_sums(f, &sky);
    double field = 0, more = 0, direct = 0, less = 0;
    for (uint32_t c = 0; c < 3; c++) {
        double together[AREA];
        char what[96];
        for (int i = 0; i < AREA; i++) {
            together[i] = d->radiance[c][i] + field_at(d->first, c, i);
            if (lobes) together[i] += lobe_at(d->first, c, i);
            field += field_at(b->first, c, i), more += field_at(d->first, c, i);
            direct += b->direct[c][i], less += d->direct[c][i];
        }
        snprintf(what, sizeof what, "sky, kind %d, lights %u, channel %u", (int)kind, shines, c);
        expect_same(what, a->radiance[c], together, 0.02);
    }
    assert_true(more > 1.2 * field);
    assert_true(less < 0.9 * direct);
    sums_free(&a);
    sums_free(&b);
    sums_free(&d);
    free(f);
}

TEST(fields_bring_the_sky)
{
    static const enum kind kinds[] = {LAMBERT, DIELECTRIC, COATED, PHONG};
    for (int k = 0; k < 4; k++) {
        compare_sky(kinds[k], SHINES_SKY, false);
        compare_sky(kinds[k], SHINES_RECT | SHINES_MAP, k % 2);
    }
    compare_sky(DIELECTRIC, SHINES_RECT | SHINES_SKY, true);
}
