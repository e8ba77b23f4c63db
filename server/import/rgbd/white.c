#include "server/import/rgbd/white.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What part of a picture is as bright as white or brighter. */
#define WHITE_SHARE   0.05
#define DARKEST_WHITE 1e-4f

#define WHITE_ALBEDO 0.8f
#define ALBEDO_MAX   0.95f
#define SHINING      2.0f /* of white */

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

int white_find(const struct depth_map *map, const struct rgbd_document *d, float white[3],
               struct fault *fault)
{
    const size_t count = (size_t)map->width * (size_t)map->height;
    memcpy(white, d->white, sizeof d->white);
    if (white[0] > 0) return 0;
    float *light = malloc(count * sizeof *light);
    if (light == NULL) return fault_set(fault, ERR_MEMORY, "/rgbd", "no memory for colours");
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < count; i++) light[i] = map->color[3 * i + c];
        qsort(light, count, sizeof *light, compare);
        white[c] = fmaxf(light[(size_t)((1 - WHITE_SHARE) * (double)(count - 1))], DARKEST_WHITE);
    }
    free(light);
    return 0;
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
