/* The light of scenes that have none: neutral, and what it does to a white surface. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "server/job/prepare/studio_light.h"
#include "tests/unit/unit.h"

static float texels[3 * STUDIO_WIDTH_PX * STUDIO_HEIGHT_PX];

/* The radiance that a white Lambert surface of this normal sends on. */
static double sent_on(const double n[3])
{
    double sum = 0;
    for (uint32_t y = 0; y < STUDIO_HEIGHT_PX; y++) {
        const double polar = M_PI * (y + 0.5) / STUDIO_HEIGHT_PX;
        const double solid = 2 * M_PI * M_PI / (STUDIO_WIDTH_PX * STUDIO_HEIGHT_PX) * sin(polar);
        for (uint32_t x = 0; x < STUDIO_WIDTH_PX; x++) {
            const double around = 2 * M_PI * ((x + 0.5) / STUDIO_WIDTH_PX - 0.5);
            const double cosine = n[0] * sin(polar) * cos(around) + n[1] * cos(polar) +
                                  n[2] * sin(polar) * sin(around);
            if (cosine > 0)
                sum += cosine * solid * (double)texels[3 * (y * STUDIO_WIDTH_PX + x)] / M_PI;
        }
    }
    return sum;
}

TEST(white_surfaces_are_neither_dark_nor_burnt)
{
    static const double normals[][3] = {{0, 1, 0},  {1, 0, 0},  {-1, 0, 0},        {0, 0, 1},
                                        {0, 0, -1}, {0, -1, 0}, {-0.18, 0.7, 0.68}};
    double most = 0, least = 1e9;
    studio_light_draw(texels);
    for (size_t i = 0; i < sizeof normals / sizeof *normals; i++) {
        const double sent = sent_on(normals[i]);
        most = fmax(most, sent);
        least = fmin(least, sent);
    }
    assert_true(least > 0.2 && most < 1.2);
    assert_true(most > 3 * least);                 /* it gives shape */
    assert_true(sent_on(normals[6]) > 0.9 * most); /* the side of the key light */
}

TEST(it_is_grey_and_closes_around)
{
    studio_light_draw(texels);
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        assert_true(texels[i] == texels[i / 3 * 3] && texels[i] > 0.1f && texels[i] < 10);
    for (size_t y = 0; y < STUDIO_HEIGHT_PX; y++)
        assert_true(fabsf(texels[3 * y * STUDIO_WIDTH_PX] -
                          texels[3 * ((y + 1) * STUDIO_WIDTH_PX - 1)]) < 0.2f);
}

TEST(its_blob_is_one_that_workers_take)
{
    char dir[] = "/tmp/studio_XXXXXX", path[OBJECTS_PATH_BYTES];
    struct objects objects;
    struct environment_header header;
    struct environment_blob blob;
    struct digest first, second;
    struct fault fault = {0};
    assert_non_null(mkdtemp(dir));
    assert_int_equal(objects_open(&objects, dir, true), 0);
    assert_int_equal(studio_light_place(&objects, &header, &first, &fault), 0);
    assert_int_equal(studio_light_place(&objects, &header, &second, &fault), 0);
    assert_memory_equal(&first, &second, sizeof first);
    assert_false(objects_is_held(&objects, &first));
    objects_path(&objects, &first, path);
    assert_int_equal(environment_map(path, &blob, &fault), 0);
    assert_memory_equal(blob.header, &header, sizeof header);
    environment_unmap(&blob);
    objects_remove_dir(dir);
}
