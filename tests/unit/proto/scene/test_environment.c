/* Environment blobs: a good one opens, and each field and texel is broken once. */
#include <math.h>
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/scene/environment.h"
#include "proto/scene/scene.h"
#include "tests/unit/unit.h"

#define WIDTH  4u
#define HEIGHT 3u
#define TEXELS (3u * WIDTH * HEIGHT)

static struct {
    struct environment_header header;
    float texels[TEXELS];
} made;

static void make(void)
{
    struct fault fault = {0};
    for (uint32_t i = 0; i < TEXELS; i++) made.texels[i] = (float)(i % 7) * 0.5f;
    if (environment_describe(WIDTH, HEIGHT, made.texels, &made.header, &fault))
        fail_msg("%s: %s", fault.pointer, fault.detail);
}

/* Opens `made` in memory that ends with it, so that a sanitizer sees a read beyond. */
static int open_exact(size_t size_bytes, struct fault *fault)
{
    void *exact;
    struct environment_blob e;
    assert_int_equal(posix_memalign(&exact, 64, size_bytes + (size_bytes == 0)), 0);
    memcpy(exact, &made, size_bytes < sizeof made ? size_bytes : sizeof made);
    memset(fault, 0, sizeof *fault);
    const int error = environment_open(exact, size_bytes, &e, fault);
    assert_int_equal(error, fault->code);
    if (error) assert_null(e.blob);
    free(exact);
    return error;
}

static void refuses(int code, const char *pointer)
{
    struct fault fault;
    const int error = open_exact(sizeof made, &fault);
    if (error != code || strcmp(fault.pointer, pointer) != 0)
        fail_msg("%s at %s: %s", error_name(error), fault.pointer, fault.detail);
    assert_true(fault.detail[0] != '\0');
    make();
}

TEST(good_blobs_open)
{
    struct fault fault = {0};
    struct environment_blob e;
    alignas(64) uint8_t blob[sizeof made];
    make();
    memcpy(blob, &made, sizeof made);
    assert_int_equal(environment_open(blob, sizeof made, &e, &fault), 0);
    assert_int_equal(e.header->width_px, WIDTH);
    assert_int_equal(e.header->height_px, HEIGHT);
    assert_memory_equal(e.texels, made.texels, sizeof made.texels);
    for (int c = 0; c < 3; c++) {
        assert_true(e.header->maximum[c] == 3.0f);
        assert_true(e.header->mean[c] > 1.0f && e.header->mean[c] < 2.0f);
    }
    assert_int_equal(environment_open(blob + 1, sizeof made - 1, &e, &fault), ERR_RANGE);
}

TEST(the_mean_weighs_by_solid_angle)
{
    static float texels[3 * 2 * 64];
    struct environment_header h;
    /* cos^2 of the angle from +y: 1/3 over the sphere */
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t i = 0; i < 6; i++) {
            const double c = cos(M_PI * (y + 0.5) / 64.0);
            texels[6 * y + i] = (float)(c * c) * (float)(1 + i % 3);
        }
    assert_int_equal(environment_describe(2, 64, texels, &h, NULL), 0);
    for (int c = 0; c < 3; c++)
        assert_true(fabs((double)h.mean[c] - (1 + c) / 3.0) < 5e-4 * (1 + c));
    /* A constant stays what it is. */
    for (uint32_t i = 0; i < 6 * 64; i++) texels[i] = 0.7f;
    assert_int_equal(environment_describe(2, 64, texels, &h, NULL), 0);
    for (int c = 0; c < 3; c++) {
        assert_true(h.maximum[c] == 0.7f);
        assert_true(h.mean[c] <= 0.7f && h.mean[c] > 0.6999999f);
    }
}

TEST(edges_are_those_of_the_cosine)
{
    for (uint32_t height = 1; height < 400; height += 7)
        for (uint32_t y = 0; y <= height; y++) {
            const double half = sin(M_PI * y / (2.0 * height)), exact = 2.0 * half * half;
            assert_true(fabs(environment_edge(y, height) - exact) <= 1e-15 * (1e-3 + exact));
        }
    assert_true(environment_edge(0, 5) == 0.0 && environment_edge(5, 5) == 2.0);
}

TEST(files_are_mapped)
{
    char path[] = "/tmp/shearwater-test-environment-XXXXXX";
    struct fault fault = {0};
    struct environment_blob e;
    make();
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(environment_map(path, &e, &fault), ERR_TRUNCATED);
    assert_int_equal(write(fd, &made, sizeof made), sizeof made);
    assert_int_equal(environment_map(path, &e, &fault), 0);
    assert_memory_equal(e.blob, &made, sizeof made);
    environment_unmap(&e);
    assert_null(e.blob);
    environment_unmap(&e);
    assert_int_equal(ftruncate(fd, 100), 0);
    assert_int_equal(environment_map(path, &e, &fault), ERR_TRUNCATED);
    assert_null(e.blob);
    close(fd);
    unlink(path);
    assert_int_equal(environment_map(path, &e, &fault), ERR_IO);
    assert_int_equal(environment_map("/tmp", &e, &fault), ERR_IO);
}

TEST(cut_and_long_blobs_fail)
{
    struct fault fault;
    make();
    for (size_t cut = 0; cut < sizeof made; cut++)
        assert_int_equal(open_exact(cut, &fault), ERR_TRUNCATED);
    assert_int_equal(open_exact(sizeof made, &fault), 0);
    assert_int_equal(open_exact(sizeof made + 4, &fault), ERR_TRAILING);
}

TEST(each_field_is_checked)
{
    make();
    made.header.magic[3] = 'X';
    refuses(ERR_MAGIC, "header.magic");
    made.header.version = ENVIRONMENT_VERSION + 1;
    refuses(ERR_VERSION, "header.version");
    made.header.width_px = 0;
    refuses(ERR_LIMIT, "header.width_px");
    made.header.height_px = LIMIT_ENVIRONMENT_SIDE_PX + 1;
    refuses(ERR_LIMIT, "header.width_px");
    made.header.width_px = made.header.height_px = LIMIT_ENVIRONMENT_SIDE_PX;
    refuses(ERR_LIMIT, "header.width_px");
    made.header.width_px = UINT32_MAX;
    refuses(ERR_LIMIT, "header.width_px");
    made.header.height_px = HEIGHT + 1;
    refuses(ERR_TRUNCATED, "texels");
    made.header.height_px = HEIGHT - 1;
    refuses(ERR_TRAILING, "texels");
    made.header.flags = 2;
    refuses(ERR_RANGE, "header.flags");
    made.header.flags = 0;
    made.header.warning_bytes = 1;
    refuses(ERR_TRUNCATED, "texels");
    made.header.warning_bytes = 0;
    made.header.reserved[2] = 1;
    refuses(ERR_RANGE, "header.reserved");
    made.header.mean[1] = NAN;
    refuses(ERR_NOT_FINITE, "header.mean[1]");
    made.header.mean[2] = -0.5f;
    refuses(ERR_RANGE, "header.mean[2]");
    made.header.mean[0] = 3.5f;
    refuses(ERR_RANGE, "header.mean[0]");
    made.header.maximum[0] = INFINITY;
    refuses(ERR_NOT_FINITE, "header.maximum[0]");
    made.header.maximum[2] = 2.5f;
    refuses(ERR_RANGE, "header.maximum[2]");
}

TEST(each_texel_is_checked)
{
    static const char *const places[] = {"texels[0][0].R", "texels[1][3].B", "texels[2][3].B"};
    static const uint32_t indexes[] = {0, 23, 35};
    make();
    for (int i = 0; i < 3; i++) {
        made.texels[indexes[i]] = NAN;
        refuses(ERR_NOT_FINITE, places[i]);
        made.texels[indexes[i]] = INFINITY;
        refuses(ERR_NOT_FINITE, places[i]);
        made.texels[indexes[i]] = -1e-30f;
        refuses(ERR_RANGE, places[i]);
        made.texels[indexes[i]] = 2.0f * LIMIT_RADIANCE;
        refuses(ERR_RANGE, places[i]);
    }
    made.texels[5] = LIMIT_RADIANCE;
    assert_int_equal(environment_describe(WIDTH, HEIGHT, made.texels, &made.header, NULL), 0);
    struct fault fault;
    assert_int_equal(open_exact(sizeof made, &fault), 0);
    made.texels[5] = NAN;
    assert_int_equal(environment_describe(WIDTH, HEIGHT, made.texels, &made.header, &fault),
                     ERR_NOT_FINITE);
    assert_string_equal(fault.pointer, "texels[0][1].B");
}

TEST(scenes_and_maps_are_told_apart)
{
    struct fault fault = {0};
    struct scene scene;
    alignas(64) uint8_t blob[sizeof made];
    make();
    memcpy(blob, &made, sizeof made);
    assert_int_equal(scene_open(blob, sizeof made, &scene, &fault), ERR_MAGIC);
    assert_string_equal(fault.detail, "this is an environment map, not a scene");
    memcpy(made.header.magic, SCENE_MAGIC, sizeof SCENE_MAGIC);
    assert_int_equal(open_exact(sizeof made, &fault), ERR_MAGIC);
    assert_string_equal(fault.detail, "this is a scene, not an environment map");
}
