/* exr_pixel IN.exr X Y: a pixel's channels as JSON, with all their digits. */
#include <stdio.h>
#include <stdlib.h>

#include "server/image/exr.h"

int main(int argc, char **argv)
{
    struct image *in = NULL;
    struct fault fault = {0};
    if (argc != 4) {
        fprintf(stderr, "usage: exr_pixel IN.exr X Y\n");
        return 2;
    }
    if (exr_read(argv[1], &in, &fault)) {
        fprintf(stderr, "exr_pixel: %s: %s\n", argv[1], fault.detail);
        return 1;
    }
    const int x = atoi(argv[2]), y = atoi(argv[3]);
    const bool inside = x >= 0 && y >= 0 && x < in->width_px && y < in->height_px;
    if (!inside) fprintf(stderr, "exr_pixel: %d,%d is outside %s\n", x, y, argv[1]);
    for (uint32_t c = 0; inside && c < in->channel_count; c++) {
        const struct image_channel *channel = &in->channels[c];
        const float v = channel->plane.data[(size_t)y * (size_t)in->width_px + (size_t)x];
        printf("%s\"%s\": %.9g", c > 0 ? ", " : "{", channel->name, (double)v);
    }
    if (inside) puts("}");
    image_destroy(&in);
    return inside ? 0 : 1;
}
