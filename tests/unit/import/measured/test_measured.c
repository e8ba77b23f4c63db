/* Measured reflectances: files as MERL's are, made here of lobes that are known, what is fitted to
 * them, and what files are refused for. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "tests/unit/import/gltf/material_document.h"

#include "server/import/measured/lobe_fit.h"

enum { H = 45, D = 30, P = 30, ALL = H * D * P };

static const double pi = 3.14159265358979324;

/* A file of three numbers a bin. */
static struct {
    int32_t bins[3];
    double value[3 * ALL];
} __attribute__((packed)) file;

struct surface {
    double diffuse[3], specular[2][3], grazing[2], alpha[2];
    bool beckmann; /* whose facets are spread otherwise than the fit's */
};

static double smith(const double w[3], double alpha)
{
    return sqrt(w[2] * w[2] + alpha * alpha * (1 - w[2] * w[2]));
}

/* Walter's and Heitz' GGX for a pair of directions, in terms of angles to the normal; or Beckmann's
 * spread with the same shadows. */
static double facets(const struct surface *s, int lobe, const double wi[3], const double wo[3],
                     double hz)
{
    const double alpha = s->alpha[lobe], square = alpha * alpha, t = (square - 1) * hz * hz + 1;
    const double bell = exp((1 - 1 / (hz * hz)) / square) / (pi * square * pow(hz, 4));
    const double spread = s->beckmann ? bell : square / (pi * t * t);
    return spread / (2 * (wo[2] * smith(wi, alpha) + wi[2] * smith(wo, alpha)));
}

static double reflected(const struct surface *s, int c, const double wi[3], const double wo[3],
                        double hz, double cosine)
{
    const double g = pow(1 - cosine, 5);
    double f = s->diffuse[c] / pi * 1.05 * (1 - pow(1 - wi[2], 5)) * (1 - pow(1 - wo[2], 5));
    for (int k = 0; k < 2; k++)
        f += (s->specular[k][c] * (1 - g) + s->grazing[k] * g) * facets(s, k, wi, wo, hz);
    return f;
}

/* Fills the numbers of so many bins by Rusinkiewicz' angles; below the horizon stands -1, as in
 * MERL's. */
static void fill(const struct surface *s, const int32_t bins[3], uint8_t *value)
{
    static const double scale[3] = {1500, 1500 / 1.15, 1500 / 1.66};
    const int h = bins[0], d = bins[1], p = bins[2], all = h * d * p;
    for (int i = 0; i < all; i++) {
        const double r = (i / (d * p) + 0.5) / h, th = pi / 2 * r * r;
        const double td = pi / 2 * (i / p % d + 0.5) / d, pd = pi * (i % p + 0.5) / p;
        const double w[3] = {sin(td) * cos(pd), sin(td) * sin(pd), cos(td)};
        const double wi[3] = {cos(th) * w[0] + sin(th) * w[2], w[1],
                              cos(th) * w[2] - sin(th) * w[0]};
        const double wo[3] = {cos(th) * -w[0] + sin(th) * w[2], -w[1],
                              cos(th) * w[2] + sin(th) * w[0]};
        for (int c = 0; c < 3; c++) {
            const bool above = wi[2] > 0 && wo[2] > 0;
            const double v = above ? reflected(s, c, wi, wo, cos(th), cos(td)) * scale[c] : -1;
            memcpy(value + (size_t)(c * all + i) * sizeof v, &v, sizeof v);
        }
    }
}

static void measure(const struct surface *s)
{
    file.bins[0] = H, file.bins[1] = D, file.bins[2] = P;
    fill(s, (const int32_t[3]){H, D, P}, (uint8_t *)file.value);
}

static const struct surface paint = {
    {0.3, 0.2, 0.1}, {{0.08, 0.06, 0.04}, {0.1, 0.12, 0.2}}, {0.6, 0.3}, {0.12, 0.5}, false};

static struct merl open_file(void)
{
    struct merl merl;
    const struct file_view view = {(const uint8_t *)&file, sizeof file};
    if (merl_open(&view, "m", &merl, &room_fault) != 0)
        fail_msg("%s: %s", room_fault.pointer, room_fault.detail);
    return merl;
}

static void expect_near(const char *what, double value, double truth, double off)
{
    if (fabs(value - truth) > off) fail_msg("%s: %g in place of %g", what, value, truth);
}

static void expect_lobes(const struct lobe_fit *fit, const struct surface *s)
{
    for (int k = 0; k < 2; k++) {
        expect_near("alpha", (double)fit->alpha[k], s->alpha[k], 0.02 * s->alpha[k]);
        expect_near("grazing", (double)fit->grazing[k], s->grazing[k], 0.1);
        for (int c = 0; c < 3; c++)
            expect_near("specular", (double)fit->specular[k][c], s->specular[k][c], 0.01);
    }
    for (int c = 0; c < 3; c++)
        expect_near("diffuse", (double)fit->diffuse[c], s->diffuse[c], 0.01);
    expect_near("share elsewhere", fit->off, 0, 0.02);
}

TEST(lobes_come_back)
{
    struct lobe_fit fit;
    measure(&paint);
    const struct merl merl = open_file();
    assert_int_equal(lobe_fit_make(&merl, &fit), 0);
    expect_lobes(&fit, &paint);
}

/* Fits lobes to a file as large as those of the database, whose numbers end at its last byte and
 * lie on no multiple of their size. */
static struct lobe_fit fit_of_real_size(const struct surface *s)
{
    static const int32_t bins[3] = {90, 90, 180};
    const size_t size = 12 + 3 * (size_t)(90 * 90 * 180) * sizeof(double);
    uint8_t *data = malloc(size);
    struct lobe_fit fit;
    struct merl merl;
    assert_non_null(data);
    memcpy(data, bins, sizeof bins);
    fill(s, bins, data + 12);
    assert_int_equal(size, 34992012);
    assert_int_equal(merl_open(&(struct file_view){data, size - 1}, "m", &merl, &room_fault),
                     ERR_TRUNCATED);
    assert_int_equal(merl_open(&(struct file_view){data, size}, "m", &merl, &room_fault), 0);
    assert_int_equal(lobe_fit_make(&merl, &fit), 0);
    free(data);
    return fit;
}

TEST(files_of_the_databases_size_are_fitted)
{
    const struct lobe_fit fit = fit_of_real_size(&paint);
    expect_lobes(&fit, &paint);
}

/* Beckmann's facets are fitted by GGX ones as well as these can, and the fit says how well. */
TEST(facets_of_another_spread_are_fitted)
{
    const struct surface beckmann = {{0.2, 0.2, 0.2}, {{0.3, 0.3, 0.3}}, {1, 0}, {0.2, 1}, true};
    const struct lobe_fit fit = fit_of_real_size(&beckmann);
    expect_near("diffuse", (double)fit.diffuse[0], 0.2, 0.06);
    assert_true(fit.off > 0.1 && fit.off < 0.2);
}

/* Of what is no GGX lobe the fit is not exact, and says so. */
TEST(what_does_not_fit_is_told)
{
    struct lobe_fit good, bad;
    measure(&paint);
    struct merl merl = open_file();
    assert_int_equal(lobe_fit_make(&merl, &good), 0);
    for (int i = 0; i < 3 * ALL; i++)
        if (i / (D * P) % H < H / 3) file.value[i] *= 0.25; /* a hole where the highlight was */
    assert_int_equal(lobe_fit_make(&merl, &bad), 0);
    assert_true(bad.off > 0.05 && bad.off > 3 * good.off && bad.off < 1);
}

/* Nothing that is fitted reflects more than it receives, or less than nothing. */
TEST(fits_conserve_energy)
{
    static const struct surface all[] = {
        {{0}, {{0}}, {0}, {0.1, 0.5}, false},
        {{2, 1, 0}, {{1, 1, 1}, {3, 0, 0}}, {2, 1}, {0.1, 0.5}, false},
        {{0, 0, 0}, {{0.9, 0.6, 0.3}, {0, 0, 0}}, {1, 0}, {0.004, 0.9}, false}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        struct lobe_fit fit;
        measure(&all[i]);
        const struct merl merl = open_file();
        assert_int_equal(lobe_fit_make(&merl, &fit), 0);
        for (int c = 0; c < 3; c++) {
            const float d = fit.diffuse[c], a = fit.specular[0][c], b = fit.specular[1][c];
            assert_true(d >= 0 && a >= 0 && b >= 0 && d + a + b <= 1.0002f);
        }
        for (int k = 0; k < 2; k++)
            assert_true(fit.grazing[k] >= 0 && fit.alpha[k] > 0 && fit.alpha[k] <= 1);
        assert_true(fit.grazing[0] + fit.grazing[1] <= 1.0002f);
        assert_true(fit.off >= 0 && fit.off < 2);
        if (i == 0) assert_true(fit.diffuse[0] == 0 && fit.specular[0][1] == 0 && fit.off == 0);
    }
}

/* Of an angle with few bins some are looked at, too. */
TEST(files_of_any_shape_are_fitted)
{
    static const uint32_t shapes[][3] = {
        {1024, 2, 1024}, {1024, 1024, 2}, {2, 2, 2}, {2, 1024, 1024}, {1024, 3, 90}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        const uint32_t *bins = shapes[i];
        const size_t count = 3 * (size_t)bins[0] * bins[1] * bins[2];
        uint8_t *data = malloc(12 + count * sizeof(double));
        memcpy(data, bins, 12);
        for (size_t k = 0; k < count; k++)
            memcpy(data + 12 + k * sizeof(double), &(double){300 / pi}, sizeof(double));
        const struct file_view view = {data, 12 + count * sizeof(double)};
        struct lobe_fit fit;
        struct merl merl;
        assert_int_equal(merl_open(&view, "m", &merl, &room_fault), 0);
        assert_int_equal(lobe_fit_make(&merl, &fit), 0);
        assert_true(fit.diffuse[0] + fit.specular[0][0] + fit.specular[1][0] > 0.05f);
        free(data);
    }
}

#define MEASURED                                                                                   \
    "\"extras\": {\"shearwater\": {\"model\": \"measured\", \"uri\": \"paint.binary\"}}"
#define URI "materials[0].extras.shearwater.uri"

TEST(materials_are_measured)
{
    struct scene s;
    measure(&paint);
    room_write("paint.binary", &file, sizeof file);
    const struct scene_material *m = read_one(MEASURED, &s);
    assert_int_equal(m->model, MODEL_MEASURED);
    expect_near("alpha", (double)m->alpha_u, 0.12, 0.003);
    expect_near("second alpha", (double)m->second_alpha, 0.5, 0.01);
    expect_near("albedo", (double)m->base_color[0], 0.3, 0.01);
    expect_near("grazing", (double)m->grazing[0], 0.6, 0.1);
    assert_true(room_warned("fitted by a diffuse lobe and two of alpha 0.12"));
    scene_unmap(&s);
}

/* The place of bin h, d, p in a channel. */
static size_t bin(int channel, int h, int d, int p)
{
    return (size_t)(channel * ALL + (h * D + d) * P + p);
}

static void refuses(const void *data, size_t size_bytes, int code, const char *part)
{
    room_write("paint.binary", data, size_bytes);
    room_refuses("a.gltf", document(WITH_UVS, MEASURED), code, URI);
    if (!strstr(room_fault.detail, part)) fail_msg("%s lacks %s", room_fault.detail, part);
}

TEST(bad_files_are_refused_with_a_place)
{
    measure(&paint);
    refuses(&file, 0, ERR_TRUNCATED, "header");
    refuses(&file, 11, ERR_TRUNCATED, "header");
    refuses(&file, sizeof file - 1, ERR_TRUNCATED, "only");
    refuses(&file, sizeof file / 2, ERR_TRUNCATED, "only");
    static const double bad[] = {NAN, INFINITY, -0.5};
    for (int k = 0; k < 3; k++) {
        const double was = file.value[bin(1, 3, 4, 5)];
        file.value[bin(1, 3, 4, 5)] = bad[k];
        refuses(&file, sizeof file, k < 2 ? ERR_NOT_FINITE : ERR_RANGE,
                "at theta_h 3, theta_d 4, phi_d 5");
        file.value[bin(1, 3, 4, 5)] = was;
    }
    file.value[bin(2, H - 1, D - 1, 0)] = NAN; /* below the horizon: nobody looks */
    room_write("paint.binary", &file, sizeof file);
    struct scene s;
    read_one(MEASURED, &s);
    scene_unmap(&s);
    static const int32_t bins[] = {0, 1, -1, 1025, INT32_MAX, INT32_MIN};
    for (int k = 0; k < 6; k++) {
        file.bins[k % 3] = bins[k];
        refuses(&file, sizeof file, ERR_RANGE, "bins");
        file.bins[0] = H, file.bins[1] = D, file.bins[2] = P;
    }
    file.bins[2] = P - 1;
    refuses(&file, sizeof file, ERR_SYNTAX, "too many");
}

TEST(files_are_found_beside_the_scene)
{
#define BY(uri) "\"extras\": {\"shearwater\": {\"model\": \"measured\", \"uri\": \"" uri "\"}}"
    room_refuses("a.gltf", document(WITH_UVS, BY("none.binary")), ERR_NOT_FOUND, URI);
    room_refuses("a.gltf", document(WITH_UVS, BY("../paint.binary")), ERR_RANGE, URI);
    room_refuses("a.gltf", document(WITH_UVS, BY("data:;base64,AAAA")), ERR_TRUNCATED, URI);
    room_refuses("a.gltf",
                 document(WITH_UVS, "\"extras\": {\"shearwater\": {\"model\": \"measured\"}}"),
                 ERR_MISSING, URI);
    room_refuses("a.gltf",
                 document(WITH_UVS, "\"extras\": {\"shearwater\": {\"model\": \"measured\", "
                                    "\"uri\": \"t.bin\", \"alpha\": 0.1}}"),
                 ERR_UNKNOWN_MEMBER, "materials[0].extras.shearwater.alpha");
}
