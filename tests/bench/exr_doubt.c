/* exr_doubt HALF.exr HALF.exr TEST.exr LAYER [TIMES] [WHERE,ABOVE,BELOW]: how well the squared
 * error of a layer is known when the reference is the mean of two independent halves a and b.
 *
 * With e the true error at a pixel, (x - a)(x - b) has the mean e^2 whatever the halves' noise:
 * that is the squared error less a quarter of the halves' own difference squared. What noise leaves
 * in its sum has the variance of the sum of (x - m) d, where m is the mean of the halves and d
 * their difference: half of what judging by one half instead of the other changes. Sums over
 * squares of pixels take as independent what lies in different squares only; the sum over all of
 * them is looked at, too, for noise that the whole picture shares.
 *
 * The layer is multiplied by the first half's layer TIMES in all three, as exr_difference does.
 * Prints one JSON line: rmse, doubt (its standard error as a part of it; 1 where no error is left),
 * pixels. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/image/exr.h"

enum { SQUARE_PX = 16 };

struct judged {
    struct image *images[3]; /* owned: both halves, the test */
    const struct plane *planes[3][3], *times[3], *where;
    int channels;
    double above, below;
};

struct sums {
    double squared, of_squares, all;
    long long pixels;
};

static int complain(const char *path, const char *what)
{
    fprintf(stderr, "exr_doubt: %s: %s\n", path, what);
    return -1;
}

static int read_images(char **argv, struct judged *j)
{
    struct fault fault = {0};
    for (int i = 0; i < 3; i++) {
        if (exr_read(argv[1 + i], &j->images[i], &fault))
            return complain(argv[1 + i], fault.detail);
        if (j->images[i]->width_px != j->images[0]->width_px ||
            j->images[i]->height_px != j->images[0]->height_px)
            return complain(argv[1 + i], "another size than the first");
        if (!image_layer_planes(j->images[i], argv[4], j->planes[i]))
            return complain(argv[1 + i], "no such layer");
    }
    j->channels = j->planes[0][0] == j->planes[0][1] ? 1 : 3;
    return 0;
}

/* The words after the layer: what to multiply by, and where. */
static int read_words(int argc, char **argv, struct judged *j)
{
    const struct plane *planes[3];
    char layer[32];
    for (int i = 5; i < argc; i++) {
        bool where = sscanf(argv[i], "%31[a-z_0-9],%lf,%lf", layer, &j->above, &j->below) == 3;
        if (!image_layer_planes(j->images[0], where ? layer : argv[i], planes))
            return complain(argv[1], "no layer to multiply by, or to look where");
        if (where)
            j->where = planes[0];
        else
            memcpy(j->times, planes, sizeof planes);
    }
    return 0;
}

static bool counts(const struct judged *j, int32_t x, int32_t y)
{
    if (!j->where) return true;
    double v = (double)*plane_at(j->where, x, y);
    return v > j->above && v < j->below;
}

/* What a pixel adds: to the squared error, and, returned, to its doubt. */
static double add_pixel(const struct judged *j, int32_t x, int32_t y, struct sums *sums)
{
    double doubt = 0;
    for (int c = 0; c < j->channels; c++) {
        double v[3], times = j->times[0] ? (double)*plane_at(j->times[c], x, y) : 1;
        for (int i = 0; i < 3; i++) v[i] = times * (double)*plane_at(j->planes[i][c], x, y);
        sums->squared += (v[2] - v[0]) * (v[2] - v[1]);
        doubt += (v[2] - 0.5 * (v[0] + v[1])) * (v[0] - v[1]);
    }
    sums->pixels++;
    return doubt;
}

static void add_square(const struct judged *j, int32_t left, int32_t top, struct sums *sums)
{
    const struct image *image = j->images[0];
    double doubt = 0;
    for (int32_t y = top; y < top + SQUARE_PX && y < image->height_px; y++)
        for (int32_t x = left; x < left + SQUARE_PX && x < image->width_px; x++)
            if (counts(j, x, y)) doubt += add_pixel(j, x, y, sums);
    sums->of_squares += doubt * doubt;
    sums->all += doubt;
}

static int print(const struct judged *j)
{
    struct sums sums = {0};
    for (int32_t y = 0; y < j->images[0]->height_px; y += SQUARE_PX)
        for (int32_t x = 0; x < j->images[0]->width_px; x += SQUARE_PX) add_square(j, x, y, &sums);
    if (sums.pixels == 0) return complain("where", "no pixel lies there");
    double error = sqrt(fmax(sums.of_squares, sums.all * sums.all));
    double doubt = sums.squared > 0 ? fmin(0.5 * error / sums.squared, 1) : 1;
    double count = (double)sums.pixels * j->channels;
    printf("{\"rmse\":%.9g,\"doubt\":%.9g,\"pixels\":%lld}\n", sqrt(fmax(sums.squared, 0) / count),
           doubt, sums.pixels);
    return 0;
}

int main(int argc, char **argv)
{
    struct judged j = {0};
    int rc = argc >= 5 && argc <= 7 ? 0 : 2;
    if (rc)
        fprintf(stderr, "usage: exr_doubt HALF.exr HALF.exr TEST.exr LAYER [TIMES] "
                        "[WHERE,ABOVE,BELOW]\n");
    else
        rc = read_images(argv, &j) || read_words(argc, argv, &j) || print(&j) ? 1 : 0;
    for (int i = 0; i < 3; i++) image_destroy(&j.images[i]);
    return rc;
}
