/* EXR files: what was written comes back, bytes depend on content alone, hostile files are errors.
 */
#include <OpenEXR/openexr.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "proto/half.h"
#include "tests/unit/server/image/exr_room.h"

EACH_TEST(make_dir, remove_dir);

static const struct exr_metadata metadata = {
    .job = "01JOB", .build = "0.1.0+abc", .seed = 9007199254740992u, .spp = 9, .frame = 3};

static uint32_t random_state = 7;

static float noise(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (float)(random_state >> 8) * 0x1p-24f;
}

/* Noise, ramps and constants, so that all ways of the codec are taken. */
static void fill(struct image *image)
{
    for (uint32_t c = 0; c < image->channel_count; c++) {
        for (int32_t y = 0; y < image->height_px; y++) {
            float *row = plane_row(&image->channels[c].plane, y);
            for (int32_t x = 0; x < image->width_px; x++) {
                if (c % 3 == 0)
                    row[x] = noise() * 10.0f;
                else if (c % 3 == 1)
                    row[x] = (float)(x + y) * 0.01f;
                else
                    row[x] = 0.25f;
            }
        }
    }
}

static struct image *make_image(uint32_t layers, int32_t width, int32_t height)
{
    struct image *image;
    assert_int_equal(image_create(layers, width, height, &image), 0);
    fill(image);
    return image;
}

static void write_file(const char *path, const struct image *image, const struct exr_metadata *m)
{
    struct fault fault = {0};
    if (exr_write(path, image, m, &fault)) fail_msg("%s: %s", fault.pointer, fault.detail);
}

static void assert_channels(const struct image *a, const struct image *b)
{
    assert_int_equal(a->channel_count, b->channel_count);
    assert_int_equal(a->width_px, b->width_px);
    assert_int_equal(a->height_px, b->height_px);
    size_t bytes = (size_t)a->width_px * (size_t)a->height_px * sizeof(float);
    for (uint32_t c = 0; c < a->channel_count; c++) {
        const struct plane *other = image_plane(b, a->channels[c].name);
        assert_non_null(other);
        assert_memory_equal(a->channels[c].plane.data, other->data, bytes);
    }
}

TEST(floats_come_back_bit_by_bit)
{
    static const int32_t sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {97, 33}, {720, 70}, {2000, 17}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct image *image = make_image(0xfff, sizes[i][0], sizes[i][1]);
        write_file(path_of("a.exr"), image, &metadata);
        struct image *back = read_back(path_of("a.exr"));
        assert_channels(image, back);
        image_destroy(&back);
        image_destroy(&image);
    }
}

TEST(strange_floats_come_back)
{
    struct image *image = make_image(1, 8, 2);
    static const float values[] = {INFINITY, -INFINITY, -0.0f, 1e-45f, 3.4e38f, -7.0f, 65520.0f, 0};
    memcpy(image->data, values, sizeof values);
    image->data[9] = NAN;
    write_file(path_of("a.exr"), image, &metadata);
    struct image *back = read_back(path_of("a.exr"));
    assert_channels(image, back);
    image_destroy(&back);
    image_destroy(&image);
}

TEST(halves_are_rounded_and_clamped)
{
    struct exr_metadata m = metadata;
    m.half = true;
    struct image *image = make_image(0xfff, 50, 20);
    const struct plane *red = image_plane(image, "R");
    red->data[0] = 1e9f;
    red->data[1] = -1e9f;
    image_plane(image, "id.I")->data[0] = 4000001.0f;
    write_file(path_of("a.exr"), image, &m);
    struct image *back = read_back(path_of("a.exr"));
    for (uint32_t c = 0; c < image->channel_count; c++) {
        const char *name = image->channels[c].name;
        bool whole =
            !strcmp(name, "depth.Z") || !strcmp(name, "id.I") || !strcmp(name, "samples.N");
        for (size_t i = 0; i < 1000; i++) {
            float v = image->channels[c].plane.data[i];
            float expected = whole ? v : half_to_float(half_from_float(v));
            assert_true(image_plane(back, name)->data[i] == expected);
        }
    }
    assert_true(image_plane(back, "R")->data[0] == HALF_MAX);
    image_destroy(&back);
    image_destroy(&image);
}

static char *slurp(const char *path, size_t *size_bytes)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size_bytes = (size_t)ftell(f);
    rewind(f);
    char *data = malloc(*size_bytes + 1);
    assert_int_equal(fread(data, 1, *size_bytes, f), *size_bytes);
    fclose(f);
    return data;
}

static void spill(const char *path, const char *data, size_t size_bytes)
{
    FILE *f = fopen(path, "wb");
    assert_int_equal(fwrite(data, 1, size_bytes, f), size_bytes);
    fclose(f);
}

TEST(equal_images_are_equal_files)
{
    size_t a_bytes, b_bytes;
    struct image *image = make_image(0xfff, 200, 90);
    write_file(path_of("a.exr"), image, &metadata);
    char *a = slurp(path_of("a.exr"), &a_bytes);
    write_file(path_of("b.exr"), image, &metadata);
    char *b = slurp(path_of("b.exr"), &b_bytes);
    assert_int_equal(a_bytes, b_bytes);
    assert_memory_equal(a, b, a_bytes);
    free(a);
    free(b);
    image_destroy(&image);
}

/* Rows that are not final yet hold anything; the file is the same as one that is written at once.
 */
TEST(rows_from_the_top_are_the_same_file)
{
    static const int32_t steps[][4] = {
        {90, 90, 90, 90}, {7, 16, 17, 64}, {0, 33, 33, 89}, {1, 2, 3, 90}};
    struct exr_metadata m = metadata;
    for (size_t i = 0; i < 2 * sizeof steps / sizeof steps[0]; i++) {
        struct image *image = make_image(0xfff, 70, 90), *forming = make_image(0xfff, 70, 90);
        struct exr_rows *rows;
        struct fault fault = {0};
        size_t a_bytes, b_bytes;
        m.half = i % 2 == 1;
        write_file(path_of("a.exr"), image, &m);
        assert_int_equal(exr_rows_begin(path_of("b.exr"), forming, &m, &rows, &fault), 0);
        for (int k = 0; k < 4; k++) {
            const int32_t end = steps[i / 2][k];
            for (uint32_t c = 0; c < image->channel_count; c++)
                for (int32_t y = 0; y < end; y++)
                    memcpy(plane_row(&forming->channels[c].plane, y),
                           plane_row(&image->channels[c].plane, y), 70 * sizeof(float));
            assert_int_equal(exr_rows_write(rows, end, &fault), 0);
        }
        memcpy(forming->data, image->data, (size_t)70 * 90 * image->channel_count * sizeof(float));
        assert_int_equal(exr_rows_finish(&rows, &fault), 0);
        assert_null(rows);
        char *a = slurp(path_of("a.exr"), &a_bytes), *b = slurp(path_of("b.exr"), &b_bytes);
        assert_int_equal(a_bytes, b_bytes);
        assert_memory_equal(a, b, a_bytes);
        free(a);
        free(b);
        image_destroy(&forming);
        image_destroy(&image);
    }
}

TEST(given_up_rows_leave_nothing)
{
    struct image *image = make_image(1, 70, 90);
    struct exr_rows *rows;
    struct fault fault = {0};
    char command[96];
    assert_int_equal(exr_rows_begin(path_of("a.exr"), image, &metadata, &rows, &fault), 0);
    assert_int_equal(exr_rows_write(rows, 40, &fault), 0);
    exr_rows_abort(&rows);
    assert_null(rows);
    exr_rows_abort(&rows);
    snprintf(command, sizeof command, "test -z \"$(ls -A '%s')\"", dir);
    assert_int_equal(system(command), 0);
    image_destroy(&image);
}

TEST(metadata_is_in_the_header)
{
    exr_context_t file;
    const char *text;
    int32_t length, number;
    struct image *image = make_image(1, 10, 10);
    write_file(path_of("a.exr"), image, &metadata);
    assert_int_equal(exr_start_read(&file, path_of("a.exr"), NULL), 0);
    assert_int_equal(exr_attr_get_string(file, 0, "shearwater:job", &length, &text), 0);
    assert_string_equal(text, "01JOB");
    assert_int_equal(exr_attr_get_string(file, 0, "shearwater:build", &length, &text), 0);
    assert_string_equal(text, "0.1.0+abc");
    assert_int_equal(exr_attr_get_string(file, 0, "shearwater:seed", &length, &text), 0);
    assert_string_equal(text, "9007199254740992");
    assert_int_equal(exr_attr_get_int(file, 0, "shearwater:spp", &number), 0);
    assert_int_equal(number, 9);
    assert_int_equal(exr_attr_get_int(file, 0, "shearwater:frame", &number), 0);
    assert_int_equal(number, 3);
    assert_int_not_equal(exr_attr_get_string(file, 0, "shearwater:denoiser", &length, &text), 0);
    exr_finish(&file);
    image_destroy(&image);
}

TEST(a_denoiser_is_named)
{
    exr_context_t file;
    const char *text;
    int32_t length;
    struct image *image = make_image(1, 10, 10);
    struct exr_metadata named = metadata;
    named.denoiser = "Open Image Denoise 2.3.1";
    write_file(path_of("a.exr"), image, &named);
    assert_int_equal(exr_start_read(&file, path_of("a.exr"), NULL), 0);
    assert_int_equal(exr_attr_get_string(file, 0, "shearwater:denoiser", &length, &text), 0);
    assert_string_equal(text, named.denoiser);
    exr_finish(&file);
    image_destroy(&image);
}

TEST(a_file_is_replaced_or_left_alone)
{
    struct fault fault = {0};
    struct stat st;
    struct image *image = make_image(1, 10, 10);
    write_file(path_of("a.exr"), image, &metadata);
    write_file(path_of("a.exr"), image, &metadata);
    assert_int_equal(exr_write(path_of("none/a.exr"), image, &metadata, &fault), ERR_IO);
    assert_true(strlen(fault.detail) > 0);
    assert_int_equal(mkdir(path_of("taken"), 0777), 0);
    assert_int_equal(exr_write(path_of("taken"), image, &metadata, &fault), ERR_IO);
    char command[96];
    snprintf(command, sizeof command, "ls '%s' | grep -q tmp", dir);
    assert_int_not_equal(system(command), 0); /* nothing is left beside */
    assert_int_equal(stat(path_of("a.exr"), &st), 0);
    image_destroy(&image);
}

/* Must end in an error or in an image; what it must not do the sanitizers see. */
static int try_read(const char *data, size_t size_bytes)
{
    struct image *image;
    struct fault fault = {0};
    spill(path_of("m.exr"), data, size_bytes);
    int error = exr_read(path_of("m.exr"), &image, &fault);
    if (error) {
        assert_null(image);
        assert_int_equal(fault.code, error);
        assert_true(strlen(fault.detail) > 0);
    }
    image_destroy(&image);
    return error;
}

TEST(damaged_files_are_errors)
{
    size_t size;
    struct image *image = make_image(3, 70, 40);
    write_file(path_of("a.exr"), image, &metadata);
    char *data = slurp(path_of("a.exr"), &size);
    assert_int_equal(try_read(data, size), 0);
    assert_int_not_equal(try_read("", 0), 0);
    assert_int_not_equal(try_read("not an EXR file at all, but long enough to be one", 49), 0);
    for (size_t cut = 1; cut < size; cut += cut < 600 ? 7 : 997)
        assert_int_not_equal(try_read(data, cut), 0);
    for (int i = 0; i < 600; i++) {
        size_t at = (size_t)(noise() * (i < 400 ? 700.0f : (float)size)) % size;
        char kept = data[at];
        data[at] = (char)(data[at] ^ (1 << (i % 8)));
        try_read(data, size);
        data[at] = kept;
    }
    free(data);
    image_destroy(&image);
}

TEST(it_is_quick)
{
    struct timespec a, b;
    struct stat st;
    struct image *image = make_image(1, 720, 720);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &a);
    write_file(path_of("q.exr"), image, &metadata);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &b);
    stat(path_of("q.exr"), &st);
    double ms = (double)(b.tv_sec - a.tv_sec) * 1e3 + (double)(b.tv_nsec - a.tv_nsec) * 1e-6;
    print_message("# 720 x 720 float: %.1f ms, %ld bytes\n", ms, (long)st.st_size);
    image_destroy(&image);
}
