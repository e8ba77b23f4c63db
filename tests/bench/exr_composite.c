/* exr_composite TRUTH.exr PLATE.exr TEST.exr [X,Y,W,H]: how near a composite
 * (docs/mixed-reality.md) comes to the truth, which is the same room path-traced with the object,
 * where the plate is the room without it. Prints one JSON line: rms        of composite less truth,
 * over channels and the rectangle, over the truth's mean plate_rms  the same of the plate: what the
 * object changes same       the share of pixels whose factor is 1 and whose composite is the plate,
 * to the bit changed    the number of the others */
#include <math.h>
#include <stdio.h>

#include "server/image/exr.h"

struct pictures {
    struct image *truth, *plate, *test; /* owned */
    const struct plane *true_light[3], *plate_light[3], *composite[3], *factor[3];
    int x, y, width, height;
};

static int complain(const char *path, const char *what)
{
    fprintf(stderr, "exr_composite: %s: %s\n", path, what);
    return -1;
}

static int read_one(const char *path, struct image **out)
{
    struct fault fault = {0};
    return exr_read(path, out, &fault) ? complain(path, fault.detail) : 0;
}

static int find(const char *path, const struct image *image, const char *layer,
                const struct plane *out[3])
{
    return image_layer_planes(image, layer, out) ? 0 : complain(path, "it lacks a layer");
}

static int read_all(char **argv, struct pictures *p)
{
    if (read_one(argv[1], &p->truth) || read_one(argv[2], &p->plate) || read_one(argv[3], &p->test))
        return -1;
    if (find(argv[1], p->truth, "beauty", p->true_light) ||
        find(argv[2], p->plate, "beauty", p->plate_light) ||
        find(argv[3], p->test, "composite", p->composite) ||
        find(argv[3], p->test, "catcher", p->factor))
        return -1;
    p->width = p->test->width_px, p->height = p->test->height_px;
    if (p->truth->width_px != p->width || p->plate->width_px != p->width ||
        p->truth->height_px != p->height || p->plate->height_px != p->height)
        return complain(argv[3], "another size than the others");
    return 0;
}

static int read_rectangle(const char *text, struct pictures *p)
{
    int w, h;
    if (sscanf(text, "%d,%d,%d,%d", &p->x, &p->y, &w, &h) != 4 || p->x < 0 || p->y < 0 || w < 1 ||
        h < 1 || w > p->width - p->x || h > p->height - p->y)
        return complain(text, "it is no rectangle of the pictures");
    p->width = w, p->height = h;
    return 0;
}

static void measure(const struct pictures *p)
{
    double off = 0, change = 0, sum = 0;
    long same = 0;
    const long pixels = (long)p->width * p->height;
    for (int y = p->y; y < p->y + p->height; y++)
        for (int x = p->x; x < p->x + p->width; x++) {
            bool is_same = true;
            for (int c = 0; c < 3; c++) {
                const float truth = *plane_at(p->true_light[c], x, y);
                const float plate = *plane_at(p->plate_light[c], x, y);
                const float composite = *plane_at(p->composite[c], x, y);
                off += ((double)composite - (double)truth) * ((double)composite - (double)truth);
                change += ((double)plate - (double)truth) * ((double)plate - (double)truth);
                sum += (double)truth;
                is_same &= composite == plate && *plane_at(p->factor[c], x, y) == 1.0f;
            }
            same += is_same;
        }
    const double count = 3.0 * (double)pixels, mean = sum / count;
    printf("{\"rms\": %.5f, \"plate_rms\": %.5f, \"same\": %.5f, \"changed\": %ld}\n",
           sqrt(off / count) / mean, sqrt(change / count) / mean, (double)same / (double)pixels,
           pixels - same);
}

int main(int argc, char **argv)
{
    struct pictures p = {0};
    if (argc < 4 || argc > 5) {
        fprintf(stderr, "usage: exr_composite TRUTH.exr PLATE.exr TEST.exr [X,Y,W,H]\n");
        return 2;
    }
    int error = read_all(argv, &p);
    if (!error && argc == 5) error = read_rectangle(argv[4], &p);
    if (!error) measure(&p);
    image_destroy(&p.truth);
    image_destroy(&p.plate);
    image_destroy(&p.test);
    return error ? 1 : 0;
}
