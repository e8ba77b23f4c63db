/* exr_flicker REFERENCE_A.exr REFERENCE_B.exr TEST_A.exr TEST_B.exr: how much two frames that
 * follow each other flicker, at the points that both show: where the references' layers
 * motion.forward of A and motion.backward of B agree to half a pixel.
 *
 * What is off in a frame is the test less the reference, which takes out all that really changes.
 * Flicker is how that changes at a point: the mean absolute difference of beauty over points and
 * channels, over the reference's mean. low is that of means over 9 x 9 pixels, high that of what
 * is left. change and reference_change are the differences of the pictures themselves. Prints one
 * JSON line. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "server/image/exr.h"

#define BOX_PX   4
#define AGREE_PX 0.5f

enum { REFERENCE_A, REFERENCE_B, TEST_A, TEST_B, FILES };

struct frames {
    struct image *images[FILES]; /* owned */
    const struct plane *beauty[FILES][3], *forward[2], *backward[2];
    int32_t width, height;
};

/* At the points of frame B, row by row. */
struct changes {
    unsigned char *counts; /* whether A shows the point */
    float *off;            /* owned; of one channel */
};

static int complain(const char *path, const char *what)
{
    fprintf(stderr, "exr_flicker: %s: %s\n", path, what);
    return -1;
}

static int read_frames(char **argv, struct frames *f)
{
    static const char *const channels[] = {"R", "G", "B"};
    struct fault fault = {0};
    for (int k = 0; k < FILES; k++) {
        if (exr_read(argv[k + 1], &f->images[k], &fault))
            return complain(argv[k + 1], fault.detail);
        if (f->images[k]->width_px != f->images[0]->width_px ||
            f->images[k]->height_px != f->images[0]->height_px)
            return complain(argv[k + 1], "another size than the first");
        for (int c = 0; c < 3; c++)
            if (!(f->beauty[k][c] = image_plane(f->images[k], channels[c])))
                return complain(argv[k + 1], "no layer beauty");
    }
    f->width = f->images[0]->width_px, f->height = f->images[0]->height_px;
    f->forward[0] = image_plane(f->images[REFERENCE_A], "motion.forward.X");
    f->forward[1] = image_plane(f->images[REFERENCE_A], "motion.forward.Y");
    f->backward[0] = image_plane(f->images[REFERENCE_B], "motion.backward.X");
    f->backward[1] = image_plane(f->images[REFERENCE_B], "motion.backward.Y");
    if (!f->forward[0] || !f->forward[1]) return complain(argv[1], "no layer motion.forward");
    if (!f->backward[0] || !f->backward[1]) return complain(argv[2], "no layer motion.backward");
    return 0;
}

/* Finds the pixel of A that shows the point of pixel (x, y) of B. False: none does. */
static int find(const struct frames *f, int32_t x, int32_t y, int32_t *from_x, int32_t *from_y)
{
    const float bx = *plane_at(f->backward[0], x, y), by = *plane_at(f->backward[1], x, y);
    const float ax = floorf((float)x + 0.5f + bx), ay = floorf((float)y + 0.5f + by);
    if (!(ax >= 0 && ax < (float)f->width && ay >= 0 && ay < (float)f->height)) return 0;
    *from_x = (int32_t)ax, *from_y = (int32_t)ay;
    return fabsf(*plane_at(f->forward[0], *from_x, *from_y) + bx) <= AGREE_PX &&
           fabsf(*plane_at(f->forward[1], *from_x, *from_y) + by) <= AGREE_PX;
}

static double mean_of_box(const struct frames *f, const struct changes *c, int32_t x, int32_t y)
{
    double sum = 0;
    long count = 0;
    for (int32_t v = y - BOX_PX; v <= y + BOX_PX; v++)
        for (int32_t u = x - BOX_PX; u <= x + BOX_PX; u++) {
            if (u < 0 || u >= f->width || v < 0 || v >= f->height) continue;
            const size_t i = (size_t)v * (size_t)f->width + (size_t)u;
            if (!c->counts[i]) continue;
            sum += (double)c->off[i];
            count++;
        }
    return sum / (double)count;
}

struct sums {
    long points;
    double mean, change, reference_change, flicker, low, high; /* over channels */
};

static void add_channel(const struct frames *f, struct changes *c, int channel, struct sums *s)
{
    for (int32_t y = 0; y < f->height; y++)
        for (int32_t x = 0; x < f->width; x++) {
            const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
            int32_t u, v;
            c->counts[i] = find(f, x, y, &u, &v) != 0;
            if (!c->counts[i]) continue;
            const double reference_b = (double)*plane_at(f->beauty[REFERENCE_B][channel], x, y);
            const double reference =
                reference_b - (double)*plane_at(f->beauty[REFERENCE_A][channel], u, v);
            const double test = (double)*plane_at(f->beauty[TEST_B][channel], x, y) -
                                (double)*plane_at(f->beauty[TEST_A][channel], u, v);
            c->off[i] = (float)(test - reference);
            s->points += channel == 0;
            s->mean += reference_b;
            s->change += fabs(test);
            s->reference_change += fabs(reference);
            s->flicker += fabs(test - reference);
        }
    for (int32_t y = 0; y < f->height; y++)
        for (int32_t x = 0; x < f->width; x++) {
            const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
            if (!c->counts[i]) continue;
            const double low = mean_of_box(f, c, x, y);
            s->low += fabs(low);
            s->high += fabs((double)c->off[i] - low);
        }
}

static int print(const struct frames *f)
{
    const size_t area = (size_t)f->width * (size_t)f->height;
    struct changes c = {.counts = malloc(area), .off = malloc(area * sizeof(float))};
    struct sums s = {0};
    const int made = c.counts && c.off;
    for (int channel = 0; made && channel < 3; channel++) add_channel(f, &c, channel, &s);
    free(c.counts);
    free(c.off);
    if (!made) return complain("", "memory is exhausted");
    if (s.points == 0) return complain("", "no point is in both frames");
    printf("{\"points\":%ld,\"change\":%.6g,\"reference_change\":%.6g,\"flicker\":%.6g,"
           "\"low\":%.6g,\"high\":%.6g}\n",
           s.points, s.change / s.mean, s.reference_change / s.mean, s.flicker / s.mean,
           s.low / s.mean, s.high / s.mean);
    return 0;
}

int main(int argc, char **argv)
{
    struct frames f = {.width = 0};
    int rc = argc == FILES + 1 ? 0 : 2;
    if (rc)
        fprintf(stderr,
                "usage: exr_flicker REFERENCE_A.exr REFERENCE_B.exr TEST_A.exr TEST_B.exr\n");
    else
        rc = read_frames(argv, &f) || print(&f) ? 1 : 0;
    for (int k = 0; k < FILES; k++) image_destroy(&f.images[k]);
    return rc;
}
