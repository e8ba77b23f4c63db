/* Sample positions are the same for ever. */
#include "proto/pattern.h"
#include "tests/unit/unit.h"

/* Anyone may recompute a sample of a result that is years old: these never change. */
TEST(positions_are_golden)
{
    static const struct {
        uint64_t seed;
        uint32_t frame;
        int32_t x, y;
        uint32_t dimension;
        float jitter[2], shuffled[2], pixel[2];
    } golden[] = {
        {1u,
         1,
         0,
         0,
         0,
         {0x1.8175acp-2f, 0x1.01293cp-1f},
         {0x1.0e996ap-1f, 0x1.a40416p-2f},
         {0x1.4e6a48p-2f, 0x1.8795c4p-2f}},
        {1u,
         1,
         1,
         0,
         1,
         {0x1.e25d1ep-1f, 0x1.ebce6p-3f},
         {0x1.f71a56p-1f, 0x1.f38de6p-1f},
         {0x1.c3f2c8p-1f, 0x1.9c3544p-3f}},
        {1u,
         1,
         719,
         719,
         16,
         {0x1.26e04cp-1f, 0x1.9e85f6p-1f},
         {0x1.92d8dp-2f, 0x1.7ae5e6p-2f},
         {0x1.db4bbcp-2f, 0x1.49b5a8p-3f}},
        {7u,
         3,
         100,
         200,
         2,
         {0x1.175b1p-2f, 0x1.c64804p-2f},
         {0x1.015fb4p-2f, 0x1.3b733ep-1f},
         {0x1.53256cp-1f, 0x1.258e1ap-1f}},
        {9007199254740992u,
         1073741824,
         16383,
         8191,
         79,
         {0x1.cd7076p-1f, 0x1.dfa9ecp-2f},
         {0x1.cc407ap-3f, 0x1.f0a4fp-2f},
         {0x1.e158dep-1f, 0x1.642e46p-1f}},
        {0u,
         0,
         12,
         34,
         4,
         {0x1.d7e2ep-4f, 0x1.7e0754p-2f},
         {0x1.349548p-3f, 0x1.8d348p-7f},
         {0x1.927948p-4f, 0x1.3640cp-1f}},
        {1u,
         1,
         5,
         6,
         3,
         {0x1.705288p-3f, 0x1.8ac40ep-1f},
         {0x1.32574p-1f, 0x1.c84ecep-3f},
         {0x1.bc7d94p-1f, 0x1.9b1c78p-2f}},
    };
    for (size_t i = 0; i < sizeof golden / sizeof golden[0]; i++) {
        const struct pattern p = {golden[i].seed, golden[i].frame};
        const int32_t x = golden[i].x, y = golden[i].y;
        float jitter[2], shuffled[2], pixel[2];
        pattern_jitter(&p, x, y, golden[i].dimension, jitter);
        pattern_shuffled(&p, x, y, golden[i].dimension, 3, 5, shuffled);
        pattern_pixel(&p, x, y, 1, 3, pixel);
        assert_memory_equal(jitter, golden[i].jitter, sizeof jitter);
        assert_memory_equal(shuffled, golden[i].shuffled, sizeof shuffled);
        assert_memory_equal(pixel, golden[i].pixel, sizeof pixel);
    }
}
