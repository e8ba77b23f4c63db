/* exr_depth IN.exr OUT.pgm YFOV_DEG UNITS_PER_M NOISE [SEED]: a layer `depth`, distances along
 * camera rays, as a sensor sees it: z in millimetres as 16 bits, with noise that grows with the
 * square of the distance (Nguyen, Izadi and Lovell 2012) times NOISE, and without a value where
 * depth jumps for the pixel beside it. NOISE 0: as it is. Prints the root of the mean square of the
 * noise. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/image/exr.h"

struct sensor {
    const struct plane *depth;
    int width, height;
    double half, units, noise;
    uint64_t state;
};

static double uniform(struct sensor *s)
{
    s->state = s->state * 6364136223846793005u + 1442695040888963407u;
    return ((double)(s->state >> 11) + 0.5) * 0x1p-53;
}

static double normal(struct sensor *s)
{
    return sqrt(-2 * log(uniform(s))) * cos(2 * M_PI * uniform(s));
}

/* Returns metres along the camera's axis. */
static double true_z(const struct sensor *s, int x, int y)
{
    const double a = (2 * (x + 0.5) / s->width - 1) * s->half * s->width / s->height;
    const double b = (1 - 2 * (y + 0.5) / s->height) * s->half;
    return (double)*plane_at(s->depth, x, y) / sqrt(1 + a * a + b * b) / s->units;
}

static bool is_edge(const struct sensor *s, int x, int y)
{
    const double z = true_z(s, x, y);
    return x + 1 < s->width && s->noise > 0 && fabs(true_z(s, x + 1, y) - z) > 0.1 * z;
}

static int write_depth(struct sensor *s, FILE *out)
{
    double squares = 0, count = 0;
    fprintf(out, "P5 %d %d 65535\n", s->width, s->height);
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            const double z = true_z(s, x, y), far = z > 0.4 ? z - 0.4 : 0;
            const double off =
                s->noise > 0 ? s->noise * (0.0012 + 0.0019 * far * far) * normal(s) : 0;
            const double mm = z > 0 && !is_edge(s, x, y) ? round(1000 * (z + off)) : 0;
            const unsigned v = mm > 0 && mm < 65535 ? (unsigned)mm : 0;
            fputc((int)(v >> 8), out);
            fputc((int)(v & 255), out);
            squares += off * off;
            count++;
        }
    printf("{\"noise_m\": %.6f}\n", sqrt(squares / count));
    return ferror(out) ? 1 : 0;
}

int main(int argc, char **argv)
{
    struct image *in = NULL;
    struct fault fault = {0};
    const struct plane *depth[3];
    if (argc < 6 || argc > 7) {
        fprintf(stderr, "usage: exr_depth IN.exr OUT.pgm YFOV_DEG UNITS_PER_M NOISE [SEED]\n");
        return 2;
    }
    if (exr_read(argv[1], &in, &fault)) {
        fprintf(stderr, "exr_depth: %s: %s\n", argv[1], fault.detail);
        return 1;
    }
    FILE *out = fopen(argv[2], "wb");
    int status = 1;
    if (out && image_layer_planes(in, "depth", depth)) {
        struct sensor s = {.depth = depth[0],
                           .width = in->width_px,
                           .height = in->height_px,
                           .half = tan(atof(argv[3]) * M_PI / 360),
                           .units = atof(argv[4]),
                           .noise = atof(argv[5]),
                           .state = argc > 6 ? (uint64_t)atoll(argv[6]) : 1};
        status = write_depth(&s, out);
    } else {
        fprintf(stderr, "exr_depth: no layer depth in %s, or %s cannot be written\n", argv[1],
                argv[2]);
    }
    if (out && fclose(out) != 0) status = 1;
    image_destroy(&in);
    return status;
}
