/* exr_crop IN.exr LAYER X,Y,W,H ZOOM SCALE OUT.png [MINUS.exr]: a piece of a picture for people,
 * every pixel as ZOOM x ZOOM; with MINUS, how far the two are apart. Values are times SCALE. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/compare/reduce.h"
#include "server/image/exr.h"
#include "server/image/png.h"

struct crop {
    struct rect rect;
    int32_t zoom;
    float scale;
};

static int complain(const char *path, const struct fault *fault)
{
    fprintf(stderr, "exr_crop: %s: %s\n", path, fault->detail);
    return -1;
}

static int parse(char **argv, struct crop *c)
{
    int x, y, w, h;
    if (sscanf(argv[0], "%6d,%6d,%6d,%6d", &x, &y, &w, &h) != 4 || x < 0 || y < 0 || w < 1 || h < 1)
        return -1;
    c->rect = (struct rect){x, y, x + w, y + h};
    c->zoom = atoi(argv[1]);
    c->scale = strtof(argv[2], NULL);
    return c->zoom < 1 || c->zoom > 16 || !(c->scale > 0) ? -1 : 0;
}

/* The piece of the file's picture; NULL after a complaint. */
static struct image *read_piece(const char *path, struct rect rect)
{
    struct image *whole = NULL, *piece = NULL;
    struct fault fault = {0};
    int error = exr_read(path, &whole, &fault);
    if (!error) error = image_reduce(whole, rect, 1, &piece, &fault);
    if (error) complain(path, &fault);
    image_destroy(&whole);
    return piece;
}

/* `minus` may be NULL. NULL when the layer is missing. */
static struct image *enlarge(const struct image *in, const struct image *minus, const char *layer,
                             const struct crop *c)
{
    static const char *const names[] = {"R", "G", "B"};
    const struct plane *from[3], *less[3];
    struct image *out = NULL;
    if (!image_layer_planes(in, layer, from)) return NULL;
    if (minus && !image_layer_planes(minus, layer, less)) return NULL;
    if (image_create_named(names, 3, in->width_px * c->zoom, in->height_px * c->zoom, &out))
        return NULL;
    for (int k = 0; k < 3; k++)
        for (int32_t y = 0; y < out->height_px; y++)
            for (int32_t x = 0; x < out->width_px; x++) {
                int32_t i = x / c->zoom, j = y / c->zoom;
                float v = *plane_at(from[k], i, j);
                if (minus) v = fabsf(v - *plane_at(less[k], i, j));
                *plane_at(&out->channels[k].plane, x, y) = v * c->scale;
            }
    return out;
}

static int write_png(const struct image *image, const char *path)
{
    uint8_t *png = NULL;
    size_t size_bytes = 0;
    FILE *f = fopen(path, "wb");
    const struct png_options options = {.view = VIEW_LINEAR};
    int rc = f ? png_encode(image, "beauty", &options, &png, &size_bytes) : -1;
    if (!rc && fwrite(png, 1, size_bytes, f) != size_bytes) rc = -1;
    if (f && fclose(f)) rc = -1;
    free(png);
    if (rc) fprintf(stderr, "exr_crop: %s: cannot be written\n", path);
    return rc;
}

int main(int argc, char **argv)
{
    struct crop c = {.zoom = 1};
    struct image *in = NULL, *minus = NULL, *out = NULL;
    int rc = 1;
    if ((argc != 7 && argc != 8) || parse(argv + 3, &c)) {
        fprintf(stderr, "usage: exr_crop IN.exr LAYER X,Y,W,H ZOOM SCALE OUT.png [MINUS.exr]\n");
        return 2;
    }
    in = read_piece(argv[1], c.rect);
    if (argc == 8) minus = read_piece(argv[7], c.rect);
    if (!in || (argc == 8 && !minus)) goto done;
    out = enlarge(in, minus, argv[2], &c);
    if (!out)
        fprintf(stderr, "exr_crop: %s: there is no layer %s\n", argv[1], argv[2]);
    else if (!write_png(out, argv[6]))
        rc = 0;
done:
    image_destroy(&in);
    image_destroy(&minus);
    image_destroy(&out);
    return rc;
}
