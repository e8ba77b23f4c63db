#include "server/import/rgbd/white.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* What part of a picture is as bright as white or brighter. */
#define WHITE_SHARE   0.05
#define DARKEST_WHITE 1e-4f

#define WHITE_ALBEDO 0.8f
#define ALBEDO_MAX   0.95f
#define SHINING      2.0f /* of white */

/* Returns the value that would be the n-th of a colour's if they were sorted: none is negative, so
 * their bits have their order, and half of these are found at a time. */
static float nth_of(const float *color, size_t count, size_t n)
{
    static uint32_t counts[1 << 16];
    uint32_t found = 0;
    for (int shift = 16; shift >= 0; shift -= 16) {
        uint32_t digit = 0;
        memset(counts, 0, sizeof counts);
        for (size_t i = 0; i < count; i++) {
            const float value = color[3 * i] + 0.0f; /* no negative 0 */
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            if (shift == 16 || bits >> 16 == found) counts[bits >> shift & 0xffff]++;
        }
        while (n >= counts[digit]) n -= counts[digit++];
        found = found << 16 | digit;
    }
    float value;
    memcpy(&value, &found, sizeof value);
    return value;
}

void white_find(const struct depth_map *map, const struct rgbd_document *d, float white[3])
{
    const size_t count = (size_t)map->width * (size_t)map->height;
    memcpy(white, d->white, sizeof d->white);
    if (white[0] > 0) return;
    for (size_t c = 0; c < 3; c++)
        white[c] =
            fmaxf(nth_of(map->color + c, count, (size_t)((1 - WHITE_SHARE) * (double)(count - 1))),
                  DARKEST_WHITE);
}

float white_albedo(float color, float white)
{
    return fminf(color * WHITE_ALBEDO / white, ALBEDO_MAX);
}

bool white_is_outshone(const float white[3], const float color[3])
{
    static const float luminance[3] = {0.2126f, 0.7152f, 0.0722f};
    float own = 0, most = 0;
    for (int c = 0; c < 3; c++) {
        own += luminance[c] * color[c];
        most += luminance[c] * white[c];
    }
    return own > SHINING * most;
}
