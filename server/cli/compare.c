/* shearwater compare: how far one EXR is from another, as one JSON line. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "server/cli/cli.h"
#include "server/cli/client/output_file.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"
#include "server/compare/difference.h"
#include "server/compare/difference_pair.h"
#include "server/compare/difference_picture.h"
#include "server/compare/perceptual_metrics.h"
#include "server/compare/reduce.h"
#include "server/compare/zscore.h"
#include "server/image/exr.h"
#include "server/image/png.h"

struct comparison {
    const char *layer, *crop, *picture, *where, *second_path;
    long box_px, reference_box_px, range_percent;
    struct image *reference, *test; /* owned */
    struct image *second;           /* owned; another reference, or NULL */
    int32_t dropped[2];             /* columns, rows that fill no box */
    char mask_layer[32];            /* of `where`; "": all pixels count */
    struct difference_where mask;
    struct difference difference;
    struct difference_pair pair; /* beside both references */
    struct zscore zscore;
    struct perceptual_metrics perceptual;
    bool has_zscore;
};

static json_t *number(double v)
{
    return isfinite(v) ? json_real(v) : json_null();
}

static json_t *three(const double v[3])
{
    return json_pack("[ooo]", number(v[0]), number(v[1]), number(v[2]));
}

static json_t *zscore_json(const struct zscore *z)
{
    static const char *const channels[] = {"R", "G", "B"};
    return json_pack("{s:I, s:I, s:f, s:f, s:f, s:f, s:f, s:f, s:{s:f, s:i, s:i, s:s}, s:o, s:f}",
                     "count", (json_int_t)z->count, "without", (json_int_t)z->without, "mean",
                     z->mean, "rms", z->rms, "median", z->median, "beyond2", z->beyond[0],
                     "beyond3", z->beyond[1], "beyond4", z->beyond[2], "worst", "z", z->worst, "x",
                     (int)z->worst_x, "y", (int)z->worst_y, "channel", channels[z->worst_channel],
                     "mean_error", three(z->mean_error), "relmse", z->relmse);
}

static void tell_pair(const struct difference_pair *p, json_t *line)
{
    json_object_set_new(line, "psnr_db", number(p->psnr_db));
    json_object_set_new(line, "rmse01", number(p->rmse01));
    json_object_set_new(line, "relmse999", number(p->relmse999));
    if (isnan(p->psnr_db) || isnan(p->rmse01) || p->relmse999 <= 0)
        json_object_set_new(line, "reason",
                            json_string("what is null or not above 0: the picture is as near to "
                                        "both references as their noise lets one tell"));
}

static void print_line(const struct comparison *c)
{
    const struct difference *d = &c->difference;
    json_t *line = json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:b, s:o, s:o, s:o, s:i, s:i}", "layer", c->layer, "rmse",
        number(d->rmse), "relmse", number(d->relmse), "bias", number(d->bias), "p999",
        number(d->p999), "max", number(d->max), "finite", (int)d->finite, "mean_reference",
        three(d->mean_reference), "mean_test", three(d->mean_test), "ratio", three(d->ratio),
        "width", (int)c->test->width_px, "height", (int)c->test->height_px);
    if (c->box_px > 1) json_object_set_new(line, "box", json_integer(c->box_px));
    if (c->dropped[0] || c->dropped[1])
        json_object_set_new(line, "dropped_px",
                            json_pack("[ii]", (int)c->dropped[0], (int)c->dropped[1]));
    if (c->where) {
        json_object_set_new(line, "where", json_string(c->where));
        json_object_set_new(line, "pixels", json_integer((json_int_t)d->pixels));
    }
    if (c->second) tell_pair(&c->pair, line);
    if (c->has_zscore) json_object_set_new(line, "z", zscore_json(&c->zscore));
    perceptual_metrics_tell(&c->perceptual, line);
    json_dumpf(line, stdout, JSON_COMPACT | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(line);
}

/* Takes the place of *image what is left of it. */
static int reduce(struct image **image, struct rect crop, long box_px, struct fault *fault)
{
    struct image *reduced = NULL;
    int error = image_reduce(*image, crop, (int32_t)box_px, &reduced, fault);
    if (error) return error;
    image_destroy(image);
    *image = reduced;
    return 0;
}

/* Parses "x,y,w,h" inside `all`; `all` itself without text. */
static int parse_crop(const char *text, struct rect all, struct rect *out, struct fault *fault)
{
    int x, y, w, h, end = 0;
    *out = all;
    if (!text) return 0;
    if (sscanf(text, "%6d,%6d,%6d,%6d%n", &x, &y, &w, &h, &end) != 4 || text[end] || x < 0 ||
        y < 0 || w < 1 || h < 1)
        return fault_set(fault, ERR_SYNTAX, "", "--crop: \"%.60s\" is not X,Y,WIDTH,HEIGHT", text);
    *out = (struct rect){x, y, x + w, y + h};
    if (out->x1 > all.x1 || out->y1 > all.y1)
        return fault_set(fault, ERR_RANGE, "", "--crop: %s reaches beyond %d x %d", text, all.x1,
                         all.y1);
    return 0;
}

/* Parses "layer,above,below". */
static int parse_where(struct comparison *c, struct fault *fault)
{
    int end = 0;
    if (!c->where) return 0;
    if (sscanf(c->where, "%31[a-z_0-9],%lf,%lf%n", c->mask_layer, &c->mask.above, &c->mask.below,
               &end) != 3 ||
        c->where[end] || !(c->mask.above < c->mask.below))
        return fault_set(fault, ERR_SYNTAX, "", "--where: \"%.60s\" is not LAYER,ABOVE,BELOW",
                         c->where);
    c->mask.layer = c->mask_layer;
    return 0;
}

static int check_size(const struct comparison *c, const struct image *reference,
                      struct fault *fault)
{
    if (reference->width_px == c->test->width_px && reference->height_px == c->test->height_px)
        return 0;
    return fault_set(fault, ERR_MISMATCH, "", "sizes differ: %d x %d%s and %d x %d",
                     reference->width_px, reference->height_px,
                     c->reference_box_px > 1 ? " (averaged)" : "", c->test->width_px,
                     c->test->height_px);
}

/* Prepares all pictures for the comparison. */
static int prepare(struct comparison *c, struct fault *fault)
{
    struct image **const all[] = {&c->reference, &c->second, &c->test};
    struct rect crop;
    int error = 0;
    for (int i = 0; i < 2 && *all[i] && !error; i++) {
        if (c->reference_box_px > 1)
            error = reduce(all[i], image_rect(*all[i]), c->reference_box_px, fault);
        if (!error) error = check_size(c, *all[i], fault);
    }
    if (!error) error = parse_crop(c->crop, image_rect(c->test), &crop, fault);
    if (error || (!c->crop && c->box_px == 1)) return error;
    c->dropped[0] = (int32_t)(rect_width(crop) % c->box_px);
    c->dropped[1] = (int32_t)(rect_height(crop) % c->box_px);
    for (int i = 0; i < 3 && !error; i++)
        if (*all[i]) error = reduce(all[i], crop, c->box_px, fault);
    return error;
}

/* Finds the figures beside both references, and puts their mean in the reference's place. */
static int take_pair(struct comparison *c, struct fault *fault)
{
    struct image *mean;
    if (!c->second) return 0;
    int error = difference_pair(c->reference, c->second, c->test, c->layer, &c->pair, fault);
    if (!error) error = difference_pair_mean(c->reference, c->second, &mean, fault);
    if (error) return error;
    image_destroy(&c->reference);
    c->reference = mean;
    return 0;
}

static int write_picture(const struct comparison *c, struct fault *fault)
{
    struct image *picture = NULL;
    struct output_file file;
    const struct png_options plain = {0};
    uint8_t *png = NULL;
    size_t size_bytes = 0;
    int error = difference_picture(c->reference, c->test, c->layer, (double)c->range_percent / 100,
                                   (int32_t)c->box_px, &picture, fault);
    if (error) return error;
    error = png_encode(picture, "beauty", &plain, &png, &size_bytes);
    image_destroy(&picture);
    if (error) return fault_set(fault, error, "", "the difference picture cannot be encoded");
    error = output_file_open(&file, c->picture, fault);
    if (!error) {
        bool whole = fwrite(png, 1, size_bytes, file.file) == size_bytes;
        error = output_file_close(&file, whole, fault);
        if (!whole) error = fault_set(fault, ERR_IO, "", "%s: cannot be written", c->picture);
    }
    free(png);
    return error;
}

/* Checks the options before a file is opened. */
static int check_options(struct comparison *c, struct fault *fault)
{
    int error = parse_where(c, fault);
    if (!error) error = perceptual_metrics_parse(&c->perceptual, fault);
    if (!error && c->where && (c->perceptual.ssim || c->perceptual.flip))
        error =
            fault_set(fault, ERR_RANGE, "", "--ssim and --flip cannot be combined with --where");
    if (!error && c->where && c->second_path)
        error = fault_set(fault, ERR_RANGE, "", "--reference-pair cannot be combined with --where");
    if (!error && c->picture) error = output_file_check(c->picture, fault);
    return error;
}

static int read_all(struct comparison *c, char **paths, struct fault *fault)
{
    int error = exr_read(paths[0], &c->reference, fault);
    if (!error && c->second_path) error = exr_read(c->second_path, &c->second, fault);
    return error ? error : exr_read(paths[1], &c->test, fault);
}

static int compare(struct comparison *c, char **paths, struct fault *fault)
{
    const struct plane *rgb[3];
    int error = check_options(c, fault);
    if (!error) error = read_all(c, paths, fault);
    if (!error) error = prepare(c, fault);
    if (!error) error = take_pair(c, fault);
    if (!error)
        error = image_difference_where(c->reference, c->test, c->layer, c->where ? &c->mask : NULL,
                                       &c->difference, fault);
    if (error) return error;
    c->has_zscore =
        !c->where && !strcmp(c->layer, "beauty") && image_layer_planes(c->test, "error", rgb);
    if (c->has_zscore)
        error = image_zscore(c->reference, c->test, c->difference.mean, &c->zscore, fault);
    if (!error)
        error = perceptual_metrics_find(&c->perceptual, c->reference, c->test, c->layer, fault);
    if (!error && c->picture) error = write_picture(c, fault);
    return error;
}

int cli_compare(int argc, char **argv)
{
    struct comparison c = {
        .layer = "beauty", .box_px = 1, .reference_box_px = 1, .range_percent = 10};
    const struct option_line lines[] = {
        {"reference-pair", 0, OPTION_TEXT, "REF2.exr",
         "second reference with independent noise; also print psnr_db, rmse01 and relmse999", 0, 0,
         &c.second_path},
        {"layer", 'l', OPTION_TEXT, "NAME", "layer to compare (default: beauty)", 0, 0, &c.layer},
        {"box", 'b', OPTION_NUMBER, "N",
         "average both pictures over N x N pixels first; incomplete boxes are left out", 1,
         LIMIT_IMAGE_SIDE_PX, &c.box_px},
        {"reference-box", 0, OPTION_NUMBER, "N",
         "average only REF, for a TEST that is N times smaller", 1, LIMIT_IMAGE_SIDE_PX,
         &c.reference_box_px},
        {"crop", 'c', OPTION_TEXT, "X,Y,W,H", "compare only these pixels of TEST", 0, 0, &c.crop},
        {"where", 'w', OPTION_TEXT, "LAYER,ABOVE,BELOW",
         "compare only where this layer of REF lies between two values, such as "
         "visibility,0.02,0.98",
         0, 0, &c.where},
        {"difference", 'd', OPTION_TEXT, "OUT.png", "draw TEST / REF - 1: blue below 0, red above",
         0, 0, &c.picture},
        {"range", 0, OPTION_NUMBER, "PERCENT",
         "difference at which its colours are darkest (default: 10)", 1, 100000, &c.range_percent},
        {"ssim", 0, OPTION_FLAG, NULL,
         "also print structural similarity (Wang et al. 2004); 1: identical", 0, 0,
         &c.perceptual.ssim},
        {"flip", 0, OPTION_FLAG, NULL,
         "also print FLIP (Andersson et al. 2020), mean and weighted quartiles; 0: identical", 0, 0,
         &c.perceptual.flip},
        {"exposure", 0, OPTION_TEXT, "STOPS",
         "exposure of both pictures for SSIM and FLIP (default: 0)", 0, 0, &c.perceptual.exposure},
        {"gamma", 0, OPTION_TEXT, "GAMMA",
         "gamma of both pictures for SSIM and FLIP (default: 1, sRGB alone)", 0, 0,
         &c.perceptual.gamma},
        {"curve", 0, OPTION_TEXT, "linear|filmic|agx",
         "tone curve of both pictures for SSIM and FLIP (default: linear)", 0, 0,
         &c.perceptual.curve},
        {"ppd", 0, OPTION_TEXT, "PIXELS",
         "pixels per degree of visual angle, for FLIP (default: 67.02, 3840 pixels on 0.7 m at "
         "0.7 m)",
         0, 0, &c.perceptual.ppd},
    };
    const struct option_table table = {
        .usage = "shearwater compare REF.exr [--reference-pair REF2.exr] TEST.exr [options]",
        .summary =
            "Compares two pictures on linear values and prints one line of JSON: rmse, relmse, "
            "bias, the 99.9th percentile of the error, whether both pictures are finite, and "
            "their means with the ratio. If TEST has the layer error, it also prints how z = "
            "(test - ref) / standard error is spread. With a pair of references it also prints "
            "three errors without the references' own noise: psnr_db of sRGB values, rmse01 of "
            "values clipped to [0, 1], and relmse999, which leaves out the worst thousandth of the "
            "pixels. The first two are null where the picture is as near as that noise can "
            "show. All other figures are then about the mean of the pair.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 2,
        .most_arguments = 2,
    };
    struct fault fault = {0};
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    int error = compare(&c, argv + 1, &fault);
    if (!error) print_line(&c);
    image_destroy(&c.reference);
    image_destroy(&c.second);
    image_destroy(&c.test);
    return error ? job_file_complain("compare", &fault) : 0;
}
