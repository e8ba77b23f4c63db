#include "tests/property/sky.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 16, HEIGHT = 8, SUN_RISES = HEIGHT / 2 };
#define SUN 30.0f

bool sky_has_map(const struct property_case *c, const struct change *change)
{
    return c->map > 0 && !change->no_environment;
}

double sky_rotation_deg(const struct change *change)
{
    return -90.0 * change->turns; /* as stage_turn does */
}

/* Column x shows what lies at the angle 2 pi ((x + 1/2) / WIDTH - 1/2) from +x towards +z: where x
 * turns its sign, another one's. */
static int column_of(int x, bool mirrored)
{
    return mirrored ? (WIDTH + WIDTH / 2 - 1 - x) % WIDTH : x;
}

void sky_build(const struct property_case *c, const struct change *change,
               struct environment_blob *out)
{
    const size_t size = sizeof(struct environment_header) + 3 * WIDTH * HEIGHT * sizeof(float);
    struct random r = {c->map};
    struct environment_header header;
    struct fault fault = {0};
    uint8_t *blob = aligned_alloc(64, (size + 63) / 64 * 64);
    if (!blob) abort();
    float *texels = (float *)(void *)(blob + sizeof header);
    const uint64_t sun = random_bits(&r) % (WIDTH * SUN_RISES);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            float *texel = texels + 3 * (y * WIDTH + column_of(x, change->mirrored));
            const float level = (uint64_t)(y * WIDTH + x) == sun ? SUN : 1;
            for (int k = 0; k < 3; k++) texel[k] = level * random_unit(&r);
        }
    if (environment_describe(WIDTH, HEIGHT, texels, &header, &fault)) abort();
    memcpy(blob, &header, sizeof header);
    if (environment_open(blob, size, out, &fault)) abort();
}
