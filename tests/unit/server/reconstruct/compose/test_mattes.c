/* Layers of ids: the planes' bits, where compositors look for them. */
#include <string.h>

#include "proto/half.h"
#include "proto/job/job.h"
#include "tests/unit/server/reconstruct/film_picture.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

static uint32_t id_of(int32_t x, int32_t y, uint32_t rank)
{
    return 0x3f800000u + (uint32_t)(16 * x + y) * 8 + rank;
}

static void put(struct samples *s, const struct plan *plan, int32_t x, int32_t y, size_t i,
                const void *ctx)
{
    (void)plan;
    (void)ctx;
    for (uint32_t r = 0; r < 6; r++) {
        samples_u32(s, PLANE_MATTE_OBJECTS, r)[i] = id_of(x, y, r);
        samples_u16(s, PLANE_MATTE_OBJECT_SHARES, r)[i] = half_from_float(0.5f / (float)(1u << r));
    }
}

TEST(ids_keep_their_bits_beside_their_shares)
{
    static const char *const channels[] = {
        "CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B", "CryptoObject00.A",
        "CryptoObject01.R", "CryptoObject01.G", "CryptoObject01.B", "CryptoObject01.A",
        "CryptoObject02.R", "CryptoObject02.G", "CryptoObject02.B", "CryptoObject02.A"};
    struct plan plan;
    struct image *image;
    synthetic_paths_plan(&plan, 12, 10, 8, 16);
    plan.planes |= PLANES_MATTE;
    struct film *film = picture_film(&plan, 4, 0);
    picture_land_pixels(&plan, film, put, NULL);
    assert_int_equal(image_create(LAYERS_CRYPTO, 12, 10, &image), 0);
    picture_draw(&plan, film, image, NULL);
    for (int32_t y = 0; y < 10; y++)
        for (int32_t x = 0; x < 12; x++)
            for (uint32_t r = 0; r < 6; r++) {
                const uint32_t expected = id_of(x, y, r);
                const float id = picture_at(image, channels[2 * r], x, y);
                assert_memory_equal(&id, &expected, sizeof id);
                assert_true(picture_at(image, channels[2 * r + 1], x, y) ==
                            0.5f / (float)(1u << r));
                assert_true(picture_at(image, "CryptoMaterial00.G", x, y) == 0.0f);
            }
    film_destroy(&film);
    image_destroy(&image);
}
