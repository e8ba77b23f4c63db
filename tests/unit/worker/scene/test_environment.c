/* Environment maps: samples against their densities. */
#include <math.h>
#include <stdio.h>

#include "tests/unit/worker/scene/environment_draws.h"
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_HDR
#include <stb/stb_image.h>

/* Of the texel that a direction lies in, in double. */
static uint32_t texel_of(const float d[3], uint32_t width, uint32_t height)
{
    const double u = 0.5 + atan2((double)d[2], (double)d[0]) / (2.0 * M_PI);
    const double v = atan2(hypot((double)d[0], (double)d[2]), (double)d[1]) / M_PI;
    const uint32_t x = (uint32_t)(u * width), y = (uint32_t)(v * height);
    return (y < height ? y : height - 1) * width + (x < width ? x : 0);
}

static double solid_angle(uint32_t y, uint32_t width, uint32_t height)
{
    return 2.0 * M_PI / width * (environment_edge(y + 1, height) - environment_edge(y, height));
}

static double luminance_of(const float rgb[3])
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

/* The upper tail of chi-square, by Wilson and Hilferty's cube root. */
static double chi_square_p(double chi2, double freedom)
{
    const double spread = 2.0 / (9.0 * freedom);
    return 0.5 * erfc((cbrt(chi2 / freedom) - (1.0 - spread)) / sqrt(2.0 * spread));
}

/* What lookups inside a texel give in the mean: bilinear weights integrate to 6 and 1 eighths. */
static double mean_lookup(uint32_t i)
{
    static const double eighths[3] = {0.125, 0.75, 0.125};
    const int32_t width = (int32_t)f.blob.header->width_px;
    const int32_t height = (int32_t)f.blob.header->height_px;
    double sum = 0.0;
    for (int32_t dy = -1; dy <= 1; dy++)
        for (int32_t dx = -1; dx <= 1; dx++) {
            const int32_t x = ((int32_t)i % width + dx + width) % width;
            int32_t y = (int32_t)i / width + dy;
            y = y < 0 ? 0 : y < height ? y : height - 1;
            sum += eighths[dx + 1] * eighths[dy + 1] *
                   luminance_of(f.blob.texels + 3 * (size_t)(y * width + x));
        }
    return sum;
}

/* Half the map's mean is left to scattering, but a tenth of the weight stays. */
static double weight_of(uint32_t i, double mean)
{
    const double whole = mean_lookup(i);
    return fmax(whole - 0.5 * mean, 0.1 * whole);
}

static double mean_of_map(void)
{
    const uint32_t width = f.blob.header->width_px, height = f.blob.header->height_px;
    double sum = 0.0;
    for (uint32_t i = 0; i < width * height; i++)
        sum += mean_lookup(i) * solid_angle(i / width, width, height);
    return sum / (4.0 * M_PI);
}

/* Of `samples` samples in texels grouped `group` x `group`. Samples next to a texel's border may
 * round over it: groups that expect nothing may hold a few. */
static void check_chi_square(uint32_t group, uint32_t samples)
{
    const uint32_t width = f.blob.header->width_px, height = f.blob.header->height_px;
    const uint32_t across = width / group, down = height / group;
    double *expected = calloc((size_t)across * down, sizeof *expected), total = 0.0;
    const double mean = mean_of_map();
    uint32_t *seen = calloc((size_t)across * down, sizeof *seen), strays = 0, cells = 0;
    for (uint32_t i = 0; i < width * height; i++) {
        const double part = weight_of(i, mean) * solid_angle(i / width, width, height);
        expected[i / width / group * across + i % width / group] += part;
        total += part;
    }
    for (uint32_t s = 0; s < samples; s++) {
        float d[3];
        assert_true(draw(d) > 0.0f);
        const uint32_t i = texel_of(d, width, height);
        seen[i / width / group * across + i % width / group]++;
    }
    double chi2 = 0.0, rest_expected = 0.0, rest_seen = 0.0;
    for (uint32_t c = 0; c < across * down; c++) {
        const double e = expected[c] / total * samples;
        if (expected[c] <= 0.0) {
            strays += seen[c];
        } else if (e < 8.0) {
            rest_expected += e;
            rest_seen += seen[c];
        } else {
            chi2 += (seen[c] - e) * (seen[c] - e) / e;
            cells++;
        }
    }
    if (rest_expected >= 8.0) {
        chi2 += (rest_seen - rest_expected) * (rest_seen - rest_expected) / rest_expected;
        cells++;
    }
    assert_true(strays <= samples / 100000u);
    if (cells > 1) {
        const double p = chi_square_p(chi2, cells - 1.0);
        print_message("# %u x %u: chi-square %.1f over %u cells, p = %.4f\n", width, height, chi2,
                      cells, p);
        assert_true(p > 1e-4);
    }
    free(expected);
    free(seen);
}

TEST(densities_integrate_to_one)
{
    static const uint32_t sizes[][2] = {{1, 1}, {3, 1}, {1, 2}, {16, 8}, {33, 17}, {128, 64}};
    numbers.state = 3;
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        const uint32_t width = sizes[k][0], height = sizes[k][1];
        double sum = 0.0;
        open_random(width, height);
        if (width * height == 1) { /* open_random makes the first texel black */
            environment_fixture_close(&f);
            continue;
        }
        for (uint32_t i = 0; i < width * height; i++) {
            float d[3];
            towards((i % width + 0.4) / width, (i / width + 0.6) / height, d);
            sum += (double)environment_pdf(f.map, d) * solid_angle(i / width, width, height);
        }
        assert_true(fabs(sum - 1.0) < 1e-5);
        environment_fixture_close(&f);
    }
}

TEST(samples_follow_their_density)
{
    static const uint32_t sizes[][2] = {{2, 1}, {1, 4}, {16, 8}, {21, 11}, {64, 32}};
    numbers.state = 4;
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        open_random(sizes[k][0], sizes[k][1]);
        check_chi_square(1, 400000);
        environment_fixture_close(&f);
    }
}

TEST(a_sample_tells_its_density)
{
    numbers.state = 5;
    open_random(512, 256);
    uint32_t others = 0;
    for (int i = 0; i < 200000; i++) {
        float d[3];
        const float pdf = draw(d);
        const double length = sqrt((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        assert_true(fabs(length - 1.0) < 3e-7);
        /* On a border the direction's roundings may fall to the other side. */
        others += environment_pdf(f.map, d) != pdf;
    }
    print_message("# %u of 200000 samples rounded into a neighbour\n", others);
    assert_true(others < 60);
    environment_fixture_close(&f);
}

/* All samples go where lookups show the texel, and none counts for much more than another: a sun's
 * rim, too, is sampled as often as it shines. */
TEST(one_bright_texel_takes_all_samples)
{
    static float texels[3 * 64 * 32];
    static const uint32_t places[] = {64 * 8, 64 * 8 + 63, 64 * 16 + 5, 64 * 23 + 32};
    numbers.state = 6;
    for (int k = 0; k < 4; k++) {
        memset(texels, 0, sizeof texels);
        texels[3 * places[k] + 2] = 1e12f;
        environment_fixture_open(&f, 64, 32, texels);
        double sum = 0.0, most = 0.0;
        enum { COUNT = 40000 };
        for (int i = 0; i < COUNT; i++) {
            float d[3], rgb[3];
            const double pdf = (double)draw(d);
            const uint32_t at = texel_of(d, 64, 32);
            const int32_t across = (int32_t)(at % 64) - (int32_t)(places[k] % 64);
            const int32_t down = (int32_t)(at / 64) - (int32_t)(places[k] / 64);
            assert_true((across + 65) % 64 <= 2 && down >= -1 && down <= 1);
            environment_lookup(f.map, d, rgb);
            sum += (double)rgb[2] / pdf;
            most = fmax(most, (double)rgb[2] / pdf);
        }
        print_message("# largest sample over the mean: %.2f\n", most / (sum / COUNT));
        assert_true(most < 17.0 * sum / COUNT);
        environment_fixture_close(&f);
    }
}

TEST(a_black_map_gives_no_samples)
{
    const float texels[3 * 4 * 2] = {0.0f};
    environment_fixture_open(&f, 4, 2, texels);
    for (int i = 0; i < 100; i++) {
        float d[3];
        assert_true(draw(d) == 0.0f);
        assert_true(d[0] == 0.0f && d[1] == 1.0f && d[2] == 0.0f);
        random_direction(d);
        assert_true(environment_pdf(f.map, d) == 0.0f);
    }
    environment_fixture_close(&f);
}

TEST(one_texel_is_the_whole_sphere)
{
    numbers.state = 7;
    environment_fixture_open(&f, 1, 1, (const float[3]){0.5f, 0.5f, 0.5f});
    double mean[3] = {0}, squares = 0.0;
    for (int i = 0; i < 100000; i++) {
        float d[3];
        assert_true(fabs((double)draw(d) * 4.0 * M_PI - 1.0) < 1e-6);
        for (int c = 0; c < 3; c++) mean[c] += (double)d[c] / 1e5;
        squares += (double)(d[1] * d[1]) / 1e5;
    }
    for (int c = 0; c < 3; c++) assert_true(fabs(mean[c]) < 4.0 * sqrt(1.0 / 3e5));
    assert_true(fabs(squares - 1.0 / 3.0) < 4.0 * sqrt(4.0 / 45.0 / 1e5));
    environment_fixture_close(&f);
}

/* Maps of many texels leave a float few digits to compare inside a slot: alternating columns show
 * whether the choice gets more. */
TEST(large_maps_are_chosen_from_finely)
{
    const uint32_t width = 2048, height = 1024, samples = 400000;
    float *texels = malloc(3 * sizeof(float) * width * height);
    uint32_t dim = 0;
    numbers.state = 8;
    for (uint32_t i = 0; i < 3 * width * height; i++) texels[i] = i / 3 % 2 ? 1.7f : 0.3f;
    environment_fixture_open(&f, width, height, texels);
    for (uint32_t s = 0; s < samples; s++) {
        float d[3];
        draw(d);
        dim += texel_of(d, width, height) % 2 == 0;
    }
    /* Three quarters of 0.3 and a quarter of 1.7, less half the mean, over both columns' sum. */
    assert_true(fabs((double)dim - 0.15 * samples) < 4.0 * sqrt(0.15 * 0.85 * samples));
    assert_int_equal(environment_bytes(f.map) / (width * height), 12);
    environment_fixture_close(&f);
    free(texels);
}

/* The mean of radiance over density is the integral of what lookups return. */
TEST(samples_estimate_the_integral)
{
    float texels[3 * 12 * 6];
    double exact = 0.0, sum = 0.0, squares = 0.0;
    const int fine = 60, samples = 200000;
    numbers.state = 9;
    for (uint32_t i = 0; i < 216; i++) texels[i] = 0.2f + random_unit(&numbers);
    environment_fixture_open(&f, 12, 6, texels);
    for (int y = 0; y < 6 * fine; y++)
        for (int x = 0; x < 12 * fine; x++) {
            float d[3], rgb[3];
            towards((x + 0.5) / (12 * fine), (y + 0.5) / (6 * fine), d);
            environment_lookup(f.map, d, rgb);
            exact += luminance_of(rgb) * solid_angle((uint32_t)y, 12u * 60u, 6u * 60u);
        }
    for (int s = 0; s < samples; s++) {
        float d[3], rgb[3];
        const double pdf = (double)draw(d);
        environment_lookup(f.map, d, rgb);
        const double value = luminance_of(rgb) / pdf;
        sum += value;
        squares += value * value;
    }
    const double mean = sum / samples;
    const double error = sqrt((squares / samples - mean * mean) / samples);
    print_message("# integral %.5f, estimate %.5f +- %.5f\n", exact, mean, error);
    assert_true(fabs(mean - exact) < 4.0 * error + 1e-4 * exact);
    environment_fixture_close(&f);
}

TEST(a_real_sky_is_sampled_right)
{
    char path[UNIT_PATH_BYTES];
    int width, height, channels;
    scene_path("hdr/park.hdr", path);
    float *texels = stbi_loadf(path, &width, &height, &channels, 3);
    assert_non_null(texels);
    numbers.state = 10;
    environment_fixture_open(&f, (uint32_t)width, (uint32_t)height, texels);
    stbi_image_free(texels);
    check_chi_square(16, 1000000);
    uint32_t others = 0;
    for (int i = 0; i < 100000; i++) {
        float d[3];
        const float pdf = draw(d);
        others += environment_pdf(f.map, d) != pdf;
    }
    assert_true(others < 100);
    environment_fixture_close(&f);
}
