/* Sample positions: the same for ever, even over strata and pixels, better than chance, and not
 * tied to each other. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "proto/pattern.h"
#include "tests/unit/unit.h"

static const struct pattern some = {.seed = 1, .frame = 1};
static const uint32_t dimensions[] = {
    PATTERN_PIXEL,     PATTERN_INDIRECT,      PATTERN_INDIRECT_CHOICE, PATTERN_INDIRECT_LIGHT,
    PATTERN_LENS,      PATTERN_LIGHT,         PATTERN_LIGHT + 1,       PATTERN_LIGHT + 63,
    PATTERN_LIGHT_NET, PATTERN_LIGHT_NET + 63};
#define DIMENSIONS (sizeof dimensions / sizeof dimensions[0])

static void is_inside(const float v[2])
{
    for (int i = 0; i < 2; i++)
        if (!(v[i] >= 0.0f && v[i] < 1.0f)) fail_msg("%.9g is not in [0,1)", (double)v[i]);
}

TEST(extremes_stay_inside)
{
    static const int32_t places[] = {0, 1, 16383, INT32_MAX, -1, INT32_MIN};
    for (size_t d = 0; d < DIMENSIONS; d++)
        for (size_t i = 0; i < 6; i++)
            for (size_t j = 0; j < 6; j++) {
                const struct pattern p = {UINT64_MAX - i, UINT32_MAX - (uint32_t)j};
                float v[2];
                pattern_jitter(&p, places[i], places[j], dimensions[d], v);
                is_inside(v);
                pattern_shuffled(&p, places[i], places[j], dimensions[d], 256, 65535, v);
                is_inside(v);
                for (uint32_t k = 0; k < 4; k++) {
                    pattern_pixel(&p, places[i], places[j], k, 4, v);
                    is_inside(v);
                }
            }
}

/* However near 1 the jitter is, a sample stays in its own stratum. */
TEST(strata_hold_their_samples)
{
    static const float jitters[] = {0.0f, 0.5f, 0x1.fffffep-1f};
    for (uint32_t l = 1; l <= 256; l = l < 20 ? l + 1 : l * 2)
        for (uint32_t i = 0; i < l * l; i++)
            for (int j = 0; j < 3; j++) {
                const float jitter[2] = {jitters[j], jitters[2 - j]};
                float v[2];
                pattern_stratum(jitter, l, i, v);
                is_inside(v);
                assert_int_equal((int)((double)v[0] * l + 1e-5), i % l);
                assert_int_equal((int)((double)v[1] * l + 1e-5), i / l);
            }
}

static uint32_t stratum_of(const float v[2], uint32_t l)
{
    const uint32_t a = (uint32_t)((double)v[0] * l + 1e-5);
    return a + l * (uint32_t)((double)v[1] * l + 1e-5);
}

TEST(shuffles_are_permutations)
{
    static uint8_t seen[65536];
    static const uint32_t sides[] = {1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 37, 100, 255, 256};
    for (size_t s = 0; s < sizeof sides / sizeof sides[0]; s++)
        for (int32_t x = 0; x < 5; x++) {
            const uint32_t l = sides[s];
            memset(seen, 0, sizeof seen);
            for (uint32_t i = 0; i < l * l; i++) {
                float v[2];
                pattern_shuffled(&some, x, 7, PATTERN_INDIRECT_LIGHT, l, i, v);
                is_inside(v);
                const uint32_t stratum = stratum_of(v, l);
                assert_in_range(stratum, 0, l * l - 1);
                if (seen[stratum]++) fail_msg("l %u: stratum %u comes twice", l, stratum);
            }
        }
}

TEST(decks_deal_shuffled_samples)
{
    static const uint32_t sides[] = {1, 3, 8, 9, 16};
    for (size_t s = 0; s < sizeof sides / sizeof sides[0]; s++) {
        struct pattern_deck deck;
        pattern_deck_init(&deck, &some, 4, 9, PATTERN_INDIRECT_CHOICE, sides[s]);
        for (uint32_t i = 0; i < sides[s] * sides[s]; i++) {
            float dealt[2], shuffled[2];
            pattern_deck_draw(&deck, i, dealt);
            pattern_shuffled(&some, 4, 9, PATTERN_INDIRECT_CHOICE, sides[s], i, shuffled);
            assert_memory_equal(dealt, shuffled, sizeof dealt);
        }
    }
}

/* Many pixels at once get what each gets alone. */
TEST(blocks_draw_the_same_jitter)
{
    const int32_t x[3] = {0, 719, 16383}, y[3] = {5, 0, 8191};
    float first[3], second[3], alone[2];
    pattern_jitters(&some, x, y, 3, PATTERN_LIGHT + 2, first, second);
    for (int i = 0; i < 3; i++) {
        pattern_jitter(&some, x[i], y[i], PATTERN_LIGHT + 2, alone);
        assert_true(alone[0] == first[i] && alone[1] == second[i]);
    }
}

/* Sum over bins of (count - expected)^2 / expected. */
static double chi_square(const uint32_t *bins, size_t count)
{
    double total = 0.0, sum = 0.0;
    for (size_t i = 0; i < count; i++) total += bins[i];
    const double expected = total / (double)count;
    for (size_t i = 0; i < count; i++)
        sum += (bins[i] - expected) * (bins[i] - expected) / expected;
    return sum;
}

/* Five standard deviations above the mean of a chi-square with n - 1 degrees of freedom. */
static void is_even(const uint32_t *bins, size_t count, const char *what, uint32_t which)
{
    const double freedom = (double)count - 1.0;
    const double found = chi_square(bins, count), most = freedom + 5.0 * sqrt(2.0 * freedom);
    if (found > most) fail_msg("%s %u: chi-square %g above %g", what, which, found, most);
}

static size_t bin_of(const float v[2], size_t side)
{
    return (size_t)(v[0] * (float)side) + side * (size_t)(v[1] * (float)side);
}

TEST(positions_are_uniform)
{
    for (size_t d = 0; d < DIMENSIONS; d++) {
        uint32_t jittered[256] = {0}, shuffled[256] = {0}, order[9] = {0};
        for (int32_t y = 0; y < 128; y++)
            for (int32_t x = 0; x < 128; x++) {
                float v[2];
                pattern_jitter(&some, x, y, dimensions[d], v);
                jittered[bin_of(v, 16)]++;
                pattern_shuffled(&some, x, y, dimensions[d], 3, 4, v);
                shuffled[bin_of(v, 16)]++;
                order[stratum_of(v, 3)]++;
            }
        is_even(jittered, 256, "jitter of dimension", dimensions[d]);
        is_even(shuffled, 256, "shuffled samples of dimension", dimensions[d]);
        is_even(order, 9, "strata of dimension", dimensions[d]);
    }
}

/* Every pair of strata is as likely as any other to come first and last. */
TEST(orders_are_uniform)
{
    for (uint32_t l = 2; l <= 9; l += l < 4 ? 1 : 5) { /* 2, 3, 4 shuffled; 9 by bijection */
        static uint32_t pairs[81 * 81];
        const uint32_t n = l * l;
        uint32_t count = 0, used = 0;
        memset(pairs, 0, sizeof pairs);
        for (; count < n * n * 20; count++) {
            float first[2], last[2];
            const int32_t x = (int32_t)(count % 256), y = (int32_t)(count / 256);
            pattern_shuffled(&some, x, y, PATTERN_INDIRECT_CHOICE, l, 0, first);
            pattern_shuffled(&some, x, y, PATTERN_INDIRECT_CHOICE, l, n - 1, last);
            pairs[stratum_of(first, l) * n + stratum_of(last, l)]++;
        }
        for (uint32_t i = 0; i < n * n; i++) /* the diagonal stays empty */
            if (i / n != i % n)
                pairs[used++] = pairs[i];
            else
                assert_int_equal(pairs[i], 0);
        is_even(pairs, used, "first and last of l", l);
    }
}

TEST(pixels_are_covered)
{
    for (uint32_t count = 1; count <= 4; count++) {
        uint32_t all[256] = {0}, each[4][64] = {{0}};
        for (int32_t y = 0; y < 128; y++)
            for (int32_t x = 0; x < 128; x++)
                for (uint32_t k = 0; k < count; k++) {
                    float v[2];
                    pattern_pixel(&some, x, y, k, count, v);
                    all[bin_of(v, 16)]++;
                    each[k][bin_of(v, 8)]++;
                }
        is_even(all, 256, "rays of", count);
        for (uint32_t k = 0; k < count; k++) is_even(each[k], 64, "ray", k);
    }
}

/* Three rays lie on three sides of the centre: no half of the pixel is without one. */
TEST(rays_surround_the_centre)
{
    for (int32_t x = 0; x < 1000; x++) {
        double angles[3], widest = 0.0;
        for (uint32_t k = 0; k < 3; k++) {
            float v[2];
            pattern_pixel(&some, x, 3, k, 3, v);
            angles[k] = atan2((double)v[1] - 0.5, (double)v[0] - 0.5);
        }
        for (int k = 0; k < 3; k++) {
            double next = 10.0;
            for (int j = 0; j < 3; j++)
                if (j != k) next = fmin(next, fmod(angles[j] - angles[k] + 4.0 * M_PI, 2.0 * M_PI));
            widest = fmax(widest, next);
        }
        assert_true(widest < M_PI);
    }
}

static uint64_t random_state = 12345;
static float random_float(void)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(random_state >> 40) * 0x1p-24f;
}

/* RMS error of the area of quarter planes, each estimated from one window of 8 x 8 pixels. */
static double window_error(uint32_t dimension, bool at_random)
{
    double sum = 0.0;
    uint32_t windows = 0;
    for (int32_t wy = 0; wy < 128; wy += 8)
        for (int32_t wx = 0; wx < 128; wx += 8, windows++) {
            const float a = 0.2f + 0.6f * random_float(), b = 0.2f + 0.6f * random_float();
            uint32_t inside = 0;
            for (int32_t y = wy; y < wy + 8; y++)
                for (int32_t x = wx; x < wx + 8; x++) {
                    float v[2] = {random_float(), random_float()};
                    if (!at_random) pattern_jitter(&some, x, y, dimension, v);
                    inside += v[0] < a && v[1] < b;
                }
            const double error = inside / 64.0 - (double)a * (double)b;
            sum += error * error;
        }
    return sqrt(sum / windows);
}

TEST(neighbours_beat_chance)
{
    const double chance = window_error(0, true);
    for (size_t d = 0; d < DIMENSIONS; d++) {
        const double found = window_error(dimensions[d], false);
        if (found > 0.6 * chance)
            fail_msg("dimension %u: %g, by chance %g", dimensions[d], found, chance);
    }
}

/* How a sample of a dimension is drawn where two dimensions meet in one integral. */
static void draw(uint32_t dimension, bool shuffled, int32_t x, int32_t y, float out[2])
{
    if (shuffled)
        pattern_shuffled(&some, x, y, dimension, 1, 0, out);
    else
        pattern_jitter(&some, x, y, dimension, out);
}

/* Pairs are uniform together, and so are their sums and differences on the circle, which translates
 * of one lattice are not: theirs are a constant. */
static void check_pair(uint32_t a, bool a_shuffled, uint32_t b, bool b_shuffled)
{
    for (int i = 0; i < 4; i++) {
        uint32_t joint[64] = {0}, sums[16] = {0}, differences[16] = {0};
        for (int32_t y = 0; y < 128; y++)
            for (int32_t x = 0; x < 128; x++) {
                float u[2], v[2];
                draw(a, a_shuffled, x, y, u);
                draw(b, b_shuffled, x, y, v);
                const float p[2] = {u[i & 1], v[i >> 1]};
                joint[bin_of(p, 8)]++;
                sums[(size_t)(fmodf(p[0] + p[1], 1.0f) * 16.0f) & 15]++;
                differences[(size_t)(fmodf(p[0] - p[1] + 1.0f, 1.0f) * 16.0f) & 15]++;
            }
        is_even(joint, 64, "pair with dimension", b);
        is_even(sums, 16, "sums with dimension", b);
        is_even(differences, 16, "differences with dimension", b);
    }
}

TEST(dimensions_are_not_tied)
{
    check_pair(PATTERN_LIGHT, false, PATTERN_PIXEL, false);
    check_pair(PATTERN_LIGHT, false, PATTERN_LENS, false);
    check_pair(PATTERN_INDIRECT, false, PATTERN_LENS, false);
    check_pair(PATTERN_INDIRECT, false, PATTERN_INDIRECT_CHOICE, true);
    check_pair(PATTERN_INDIRECT, false, PATTERN_INDIRECT_LIGHT, true);
    check_pair(PATTERN_INDIRECT_CHOICE, true, PATTERN_INDIRECT_LIGHT, true);
}

/* Where lights have many strata the jitters of an aligned square of 16 x 16 pixels put one into
 * each of 256 boxes of any shape; two squares do so in different orders. */
TEST(nets_are_even)
{
    size_t alike = 0;
    for (int32_t square = 0; square < 16; square++) {
        for (uint32_t across = 0; across <= 8; across++) {
            uint8_t box[256] = {0};
            for (int32_t i = 0; i < 256; i++) {
                float v[2], first[2];
                const int32_t x = i % 16, y = i / 16;
                pattern_jitter(&some, 16 * square + x, 48 + y, PATTERN_LIGHT_NET + 1, v);
                pattern_jitter(&some, x, 48 + y, PATTERN_LIGHT_NET + 1, first);
                is_inside(v);
                alike += square > 0 && floorf(16 * v[0]) == floorf(16 * first[0]) ? 1 : 0;
                const uint32_t column = (uint32_t)(v[0] * (float)(1u << across));
                box[column << (8 - across) | (uint32_t)(v[1] * (float)(256u >> across))]++;
            }
            for (size_t i = 0; i < 256; i++) assert_int_equal(box[i], 1);
        }
    }
    assert_in_range(alike, 1, 15 * 9 * 256 / 8); /* a sixteenth by chance */
}

TEST(strata_choose_dimensions)
{
    assert_int_equal(pattern_light_dimension(3, PATTERN_NET_STRATA - 1), PATTERN_LIGHT + 3);
    assert_int_equal(pattern_light_dimension(3, PATTERN_NET_STRATA), PATTERN_LIGHT_NET + 3);
}

/* Over all frames and seeds the jitter of one pixel is uniform too, so that averages converge. */
TEST(seeds_and_frames_differ)
{
    uint32_t seeds[64] = {0}, frames[64] = {0};
    for (uint32_t i = 0; i < 4096; i++) {
        const struct pattern by_seed = {i, 1}, by_frame = {1, i};
        float v[2];
        pattern_jitter(&by_seed, 5, 5, PATTERN_LIGHT, v);
        seeds[bin_of(v, 8)]++;
        pattern_jitter(&by_frame, 5, 5, PATTERN_LIGHT, v);
        frames[bin_of(v, 8)]++;
    }
    is_even(seeds, 64, "seeds in dimension", PATTERN_LIGHT);
    is_even(frames, 64, "frames in dimension", PATTERN_LIGHT);
}

/* Of as many bins along either axis as there are points, none has more than two. */
TEST(golden_points_are_spaced_evenly)
{
    for (uint32_t count = 16; count <= 1024; count *= 2)
        for (int32_t x = 0; x < 9; x++) {
            uint8_t bins[2][1024] = {{0}};
            float jitter[2];
            pattern_jitter(&some, x, 5, PATTERN_PIXEL, jitter);
            for (uint32_t k = 0; k < count; k++)
                for (int axis = 0; axis < 2; axis++) {
                    const float at = pattern_golden_at(jitter, k, count, axis);
                    assert_true(at >= 0.0f && at < 1.0f);
                    bins[axis][(uint32_t)(at * (float)count)]++;
                }
            for (uint32_t i = 0; i < count; i++)
                for (int axis = 0; axis < 2; axis++) assert_in_range(bins[axis][i], 0, 2);
        }
}
