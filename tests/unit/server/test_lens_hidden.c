/* Light that samples share which the middle of the lens does not see. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "server/reconstruct/lens_hidden.h"

enum { SIDE = 40, EACH = 3 };

/* One sample: where it is to be placed, and on which surface. */
struct placed {
    int32_t column, row;
    float across, down, off, point[3], normal[3];
};

static struct lens_light_row row_of(struct placed *p)
{
    return (struct lens_light_row){.column = &p->column,
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

static int add(struct lens_hidden *h, struct placed p, float value, size_t at)
{
    const struct lens_light_row row = row_of(&p);
    const float light[3] = {value, 2.0f * value, 0.5f * value};
    return lens_hidden_add(h, &row, 0, light, at);
}

static float found(uint32_t i)
{
    return (float)(i * 2654435761u >> 24);
}

/* A field of samples whose light is noise around 127.5. */
static void fill(struct lens_hidden *h, uint32_t l)
{
    uint32_t n = 0;
    assert_int_equal(lens_hidden_create(NULL, SIDE, SIDE, l, h), 0);
    for (int32_t y = 0; y < SIDE - 2; y++)
        for (int32_t x = 0; x < SIDE - 2; x++)
            for (int k = 0; k < EACH; k++, n++)
                assert_int_equal(add(h, on_wall(x, y, 5), found(n), n), 1);
    assert_int_equal(h->count, n);
}

/* Root of the mean squared distance from the mean of all, and that mean. */
static double spread(const struct lens_hidden *h, double *mean)
{
    double sum = 0.0, square = 0.0;
    for (size_t k = 0; k < h->count; k++) {
        float light[3];
        assert_int_equal(h->list[k].at, k);
        lens_hidden_share(h, h->list[k].cell, light);
        assert_true(fabsf(light[1] - 2.0f * light[0]) < 1e-3f);
        assert_true(fabsf(light[2] - 0.5f * light[0]) < 1e-3f);
        sum += (double)light[0];
        square += (double)light[0] * (double)light[0];
    }
    *mean = sum / (double)h->count;
    return sqrt(square / (double)h->count - *mean * *mean);
}

/* Noise goes, light stays; more samples a pixel share over fewer pixels. */
static void noise_is_shared(void **state)
{
    static const uint32_t strata[] = {2, 3, 6, 16};
    double last = 0.0;
    (void)state;
    for (size_t k = 0; k < sizeof strata / sizeof *strata; k++) {
        struct lens_hidden h;
        double mean, left;
        fill(&h, strata[k]);
        left = spread(&h, &mean);
        print_message("%u x %u: noise of 74 a sample is %.1f\n", strata[k], strata[k], left);
        assert_true(fabs(mean - 127.5) < 1.5);
        assert_true(left < 30.0); /* 43 without neighbours */
        assert_true(k < 2 ? left >= last : left > 1.2 * last);
        last = left;
        lens_hidden_fini(&h);
    }
}

/* Another surface in a cell does not share, and one beside it lends nothing. */
static void surfaces_keep_apart(void **state)
{
    struct lens_hidden h;
    struct placed turned = on_wall(10, 10, 5);
    float light[3];
    (void)state;
    assert_int_equal(lens_hidden_create(NULL, SIDE, SIDE, 3, &h), 0);
    assert_int_equal(add(&h, on_wall(10, 10, 5), 1, 0), 1);
    assert_int_equal(add(&h, on_wall(10, 10, 5.05f), 3, 1), 1);
    assert_int_equal(add(&h, on_wall(10, 10, 6), 100, 2), 0);
    turned.normal[0] = turned.normal[2] = sqrtf(0.5f);
    assert_int_equal(add(&h, turned, 100, 3), 0);
    assert_int_equal(add(&h, on_wall(11, 10, 6), 1000, 4), 1);
    assert_int_equal(add(&h, on_wall(10, 10 + LENS_HIDDEN_REACH_PX + 1, 5), 1000, 5), 1);
    assert_int_equal(h.count, 4);
    lens_hidden_share(&h, h.list[0].cell, light);
    assert_true(fabsf(light[0] - 2.0f) < 1e-5f);
    lens_hidden_share(&h, h.list[2].cell, light);
    assert_true(fabsf(light[0] - 1000.0f) < 1e-3f);
    lens_hidden_fini(&h);
}

/* A sample belongs to the pixel whose middle is nearest, of the four between which it lies. */
static void samples_belong_to_the_nearest_pixel(void **state)
{
    struct lens_hidden h;
    (void)state;
    assert_int_equal(lens_hidden_create(NULL, SIDE, SIDE, 3, &h), 0);
    for (size_t k = 0; k < 4; k++) {
        struct placed p = on_wall(10, 20, 5);
        p.across = k & 1 ? 0.6f : 0.4f;
        p.down = k & 2 ? 0.6f : 0.4f;
        assert_int_equal(add(&h, p, 1, k), 1);
        assert_int_equal(h.list[k].cell, (20 + k / 2) * SIDE + 10 + k % 2);
    }
    lens_hidden_fini(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(noise_is_shared),
                                       cmocka_unit_test(surfaces_keep_apart),
                                       cmocka_unit_test(samples_belong_to_the_nearest_pixel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
