/* exr_difference REFERENCE.exr TEST.exr LAYER TIMES [WHERE,ABOVE,BELOW]: how far a layer is from
 * the reference's after both are multiplied by the reference's layer TIMES, as light is by albedo:
 * one weight for both, so that light alone is judged. Over the pixels where the reference's layer
 * WHERE lies between the two; all of them without. Prints one JSON line: rmse, relmse, bias, p999,
 * finite, pixels and mean, the reference's. */
#include <stdio.h>
#include <string.h>

#include "server/compare/difference.h"
#include "server/image/exr.h"

struct judged {
    struct image *reference, *test; /* owned */
    char where[32];
    struct difference_where mask;
};

static int complain(const char *path, const struct fault *fault)
{
    fprintf(stderr, "exr_difference: %s: %s\n", path, fault->detail);
    return -1;
}

/* Multiplies the layer of *image; both layers are colours, or numbers. */
static int multiply(const struct image *image, const char *layer, const struct plane *const by[3])
{
    const struct plane *planes[3];
    if (!image_layer_planes(image, layer, planes)) return -1;
    int channels = planes[0] == planes[1] ? 1 : 3;
    for (int c = 0; c < channels; c++)
        for (int32_t y = 0; y < image->height_px; y++)
            for (int32_t x = 0; x < image->width_px; x++)
                *plane_at(planes[c], x, y) *= *plane_at(by[c], x, y);
    return 0;
}

static int read_both(char **argv, struct judged *j)
{
    struct fault fault = {0};
    const struct plane *by[3];
    if (exr_read(argv[1], &j->reference, &fault)) return complain(argv[1], &fault);
    if (exr_read(argv[2], &j->test, &fault)) return complain(argv[2], &fault);
    if (j->reference->width_px != j->test->width_px ||
        j->reference->height_px != j->test->height_px) {
        fprintf(stderr, "exr_difference: %s: another size than %s\n", argv[2], argv[1]);
        return -1;
    }
    if (strcmp(argv[3], argv[4]) == 0 || !image_layer_planes(j->reference, argv[4], by)) {
        fprintf(stderr, "exr_difference: %s: no layer %s to multiply by\n", argv[1], argv[4]);
        return -1;
    }
    if (!multiply(j->test, argv[3], by) && !multiply(j->reference, argv[3], by)) return 0;
    fprintf(stderr, "exr_difference: there is no layer %s\n", argv[3]);
    return -1;
}

static int print(const struct judged *j, const char *layer)
{
    struct difference d;
    struct fault fault = {0};
    if (image_difference_where(j->reference, j->test, layer, j->mask.layer ? &j->mask : NULL, &d,
                               &fault))
        return complain(layer, &fault);
    printf("{\"rmse\":%.9g,\"relmse\":%.9g,\"bias\":%.9g,\"p999\":%.9g,\"finite\":%s,"
           "\"pixels\":%lld,\"mean\":%.9g}\n",
           d.rmse, d.relmse, d.bias, d.p999, d.finite ? "true" : "false", (long long)d.pixels,
           d.mean);
    return 0;
}

int main(int argc, char **argv)
{
    struct judged j = {0};
    int rc = argc == 5 || argc == 6 ? 0 : 2;
    if (argc == 6) {
        j.mask.layer = j.where;
        if (sscanf(argv[5], "%31[a-z_0-9],%lf,%lf", j.where, &j.mask.above, &j.mask.below) != 3)
            rc = 2;
    }
    if (rc)
        fprintf(stderr,
                "usage: exr_difference REFERENCE.exr TEST.exr LAYER TIMES [WHERE,ABOVE,BELOW]\n");
    else
        rc = read_both(argv, &j) || print(&j, argv[3]) ? 1 : 0;
    image_destroy(&j.reference);
    image_destroy(&j.test);
    return rc;
}
