/* Light that samples share which the middle of the lens does not see. */
#include <math.h>

#include "server/reconstruct/lighting/disocclusion.h"
#include "tests/unit/unit.h"

enum { SIDE = 40, EACH = 3 };

/* One sample: where it is to be placed, and on which surface. */
struct placed {
    int32_t column, row;
    float across, down, off, point[3], normal[3];
};

static struct lens_relight_row row_of(struct placed *p)
{
    return (struct lens_relight_row){.column = &p->column,
                                     .row = &p->row,
                                     .across = &p->across,
                                     .down = &p->down,
                                     .off = &p->off,
                                     .point = {p->point, p->point + 1, p->point + 2},
                                     .normal = {p->normal, p->normal + 1, p->normal + 2}};
}

/* On a wall at z, a sample in the middle of cell (x, y). */
static struct placed on_wall(int32_t x, int32_t y, float z)
{
    return (struct placed){.column = x,
                           .row = y,
                           .across = 0.2f,
                           .down = 0.3f,
                           .off = 0.1f,
                           .point = {(float)x, (float)y, z},
                           .normal = {0, 0, 1}};
}

static int add(struct disocclusion *h, struct placed p, float value, size_t at)
{
    const struct lens_relight_row row = row_of(&p);
    const float light[3] = {value, 2.0f * value, 0.5f * value};
    const float rest[3] = {10.0f * value, value, value};
    return disocclusion_add(h, &row, 0, light, rest, DISOCCLUSION_LIGHT, at);
}

/* Pixels in the cells, which have nothing to lend. */
static struct light_lookup_pixel unlit[SIDE * SIDE];

static float shared(const struct disocclusion *h, const struct light_lookup_pixel *pixels, size_t k,
                    float rest[3])
{
    float light[3];
    disocclusion_share(h, pixels, &h->list[k], light, rest);
    return light[0];
}

static float found(uint32_t i)
{
    return (float)(i * 2654435761u >> 24);
}

/* A field of samples whose light is noise around 127.5. */
static void fill(struct disocclusion *h, uint32_t l)
{
    uint32_t n = 0;
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, l, h), 0);
    for (int32_t y = 0; y < SIDE - 2; y++)
        for (int32_t x = 0; x < SIDE - 2; x++)
            for (int k = 0; k < EACH; k++, n++)
                assert_int_equal(add(h, on_wall(x, y, 5), found(n), n), 1);
    assert_int_equal(h->count, n);
}

/* Root of the mean squared distance from the mean of all, and that mean. */
static double spread(const struct disocclusion *h, double *mean)
{
    double sum = 0.0, square = 0.0;
    for (size_t k = 0; k < h->count; k++) {
        float light[3], rest[3];
        assert_int_equal(h->list[k].at, k);
        disocclusion_share(h, unlit, &h->list[k], light, rest);
        assert_true(rest[0] == h->list[k].rest[0]);
        assert_true(fabsf(light[1] - 2.0f * light[0]) < 1e-3f);
        assert_true(fabsf(light[2] - 0.5f * light[0]) < 1e-3f);
        sum += (double)light[0];
        square += (double)light[0] * (double)light[0];
    }
    *mean = sum / (double)h->count;
    return sqrt(square / (double)h->count - *mean * *mean);
}

/* Noise goes, light stays; more samples a pixel share over fewer pixels. */
TEST(noise_is_shared)
{
    static const uint32_t strata[] = {2, 3, 6, 16};
    double last = 0.0;
    for (size_t k = 0; k < sizeof strata / sizeof *strata; k++) {
        struct disocclusion h;
        double mean, left;
        fill(&h, strata[k]);
        left = spread(&h, &mean);
        print_message("%u x %u: noise of 74 a sample is %.1f\n", strata[k], strata[k], left);
        assert_true(fabs(mean - 127.5) < 1.5);
        assert_true(left < 30.0); /* 43 without neighbours */
        assert_true(k < 2 ? left >= last : left > 1.2 * last);
        last = left;
        disocclusion_fini(&h);
    }
}

/* Other surfaces in a cell, and beside it, have light of their own. */
TEST(surfaces_keep_apart)
{
    struct disocclusion h;
    struct placed turned = on_wall(10, 10, 5);
    float rest[3];
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
    assert_int_equal(add(&h, on_wall(10, 10, 5), 1, 0), 1);
    assert_int_equal(add(&h, on_wall(10, 10, 5.05f), 3, 1), 1);
    assert_int_equal(add(&h, on_wall(10, 10, 6), 100, 2), 1);
    turned.normal[0] = 1;
    turned.normal[2] = 0;
    assert_int_equal(add(&h, turned, 500, 3), 1);
    assert_int_equal(add(&h, on_wall(11, 10, 7), 1000, 4), 1);
    assert_int_equal(add(&h, on_wall(10, 10 + DISOCCLUSION_REACH_PX + 1, 5), 1000, 5), 1);
    assert_int_equal(h.count, 6);
    assert_int_equal(h.spot_count, 5);
    assert_true(fabsf(shared(&h, unlit, 0, rest) - 2.0f) < 1e-5f);
    assert_true(fabsf(shared(&h, unlit, 2, rest) - 100.0f) < 1e-4f);
    assert_true(fabsf(shared(&h, unlit, 3, rest) - 500.0f) < 1e-3f);
    assert_true(fabsf(shared(&h, unlit, 4, rest) - 1000.0f) < 1e-3f);
    disocclusion_fini(&h);
}

/* A cell has room for eight surfaces; who comes later keeps what is his. */
TEST(crowds_keep_their_light)
{
    struct disocclusion h;
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
    for (int k = 0; k < 12; k++)
        assert_int_equal(add(&h, on_wall(10, 10, (float)(5 + k)), 1, (size_t)k), k < 8);
    assert_int_equal(add(&h, on_wall(10, 10, 6), 1, 12), 1);
    disocclusion_fini(&h);
}

/* Of a surface of few samples, others that face about the same way take part, and pixels beside;
 * the less the more it has of its own. */
TEST(others_do_for_few)
{
    static struct light_lookup_pixel pixels[SIDE * SIDE];
    float rest[3], last = 0.0f;
    pixels[11 * SIDE + 10] = (struct light_lookup_pixel){
        .plane = {0.5f, 0, sqrtf(0.75f)}, .light = {8, 8, 8, 5}, .point = {10, 11, 5}};
    pixels[12 * SIDE + 10] = (struct light_lookup_pixel){
        .plane = {0, 0, 1}, .light = {500, 500, 500, 5}, .point = {10, 12, 5}};
    for (int many = 1; many <= 64; many *= 4) {
        struct disocclusion h;
        assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
        struct placed slanted = on_wall(11, 10, 5);
        slanted.normal[0] = 0.5f;
        slanted.normal[2] = sqrtf(0.75f);
        for (int k = 0; k < many; k++) assert_int_equal(add(&h, on_wall(10, 10, 5), 0, 0), 1);
        slanted.point[0] = 10;
        assert_int_equal(add(&h, slanted, 4, 1), 1);
        const float own = shared(&h, pixels, 0, rest);
        if (many == 1) assert_true(own > 5.0f && own < 8.0f);
        if (many > 1) assert_true(own < last);
        if (many == 64) assert_true(own == 0.0f);
        last = own;
        disocclusion_fini(&h);
    }
}

/* What samples send besides is shared by those alone that ask for it, and its mean stays. */
TEST(reflections_are_shared)
{
    struct disocclusion h;
    const float zero[3] = {0}, bright[3] = {6, 3, 9};
    float rest[3];
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
    struct placed p = on_wall(10, 10, 5);
    const struct lens_relight_row row = row_of(&p);
    assert_int_equal(disocclusion_add(&h, &row, 0, bright, bright, DISOCCLUSION_REST, 0), 1);
    assert_int_equal(disocclusion_add(&h, &row, 0, zero, zero, DISOCCLUSION_REST, 1), 1);
    assert_int_equal(disocclusion_add(&h, &row, 0, zero, zero, 3, 2), 1);
    assert_int_equal(disocclusion_add(&h, &row, 0, zero, bright, DISOCCLUSION_LIGHT, 3), 1);
    assert_true(shared(&h, unlit, 0, rest) == 6.0f);
    assert_true(rest[0] == 2.0f && rest[1] == 1.0f && rest[2] == 3.0f);
    assert_true(shared(&h, unlit, 2, rest) == 0.0f);
    assert_true(rest[0] == 2.0f && rest[1] == 1.0f && rest[2] == 3.0f);
    assert_true(shared(&h, unlit, 3, rest) == 0.0f);
    assert_true(rest[0] == 6.0f);
    disocclusion_fini(&h);
}

/* A small bright surface beside a large dim one keeps what it reflects, and so do both together. */
TEST(reflections_stay_on_their_surface)
{
    struct disocclusion h;
    float light[3], rest[3], sum = 0.0f;
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
    struct placed dim = on_wall(10, 10, 5), bent = on_wall(10, 10, 5);
    bent.normal[0] = 0.5f;
    bent.normal[2] = sqrtf(0.75f);
    const struct lens_relight_row dims = row_of(&dim), bents = row_of(&bent);
    for (int k = 0; k < 104; k++) {
        const float sent[3] = {k < 4 ? 100.0f : 1.0f, 1, 1};
        assert_int_equal(disocclusion_add(&h, k < 4 ? &bents : &dims, 0, sent, sent,
                                          DISOCCLUSION_REST, (size_t)k),
                         1);
    }
    assert_int_equal(h.spot_count, 2);
    for (size_t k = 0; k < h.count; k++) {
        disocclusion_share(&h, unlit, &h.list[k], light, rest);
        sum += rest[0];
    }
    assert_true(fabsf(sum - 500.0f) < 0.01f);
    disocclusion_fini(&h);
}

/* A sample belongs to the pixel whose middle is nearest, of the four between which it lies. */
TEST(samples_belong_to_the_nearest_pixel)
{
    struct disocclusion h;
    assert_int_equal(disocclusion_create(NULL, SIDE, SIDE, 3, &h), 0);
    for (size_t k = 0; k < 4; k++) {
        struct placed p = on_wall(10, 20, 5);
        p.across = k & 1 ? 0.6f : 0.4f;
        p.down = k & 2 ? 0.6f : 0.4f;
        assert_int_equal(add(&h, p, 1, k), 1);
        assert_int_equal(h.first[(20 + k / 2) * SIDE + 10 + k % 2], h.list[k].spot);
    }
    disocclusion_fini(&h);
}
