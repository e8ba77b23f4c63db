#include "server/compare/perceptual_metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job.h"

/* Parses a decimal number; `otherwise` without a text. */
static int parse(const char *option, const char *text, double least, double most, double otherwise,
                 double *out, struct fault *fault)
{
    char *end = NULL;
    *out = otherwise;
    if (!text) return 0;
    if (strspn(text, "+-.0123456789") == strlen(text)) *out = strtod(text, &end);
    if (!end || *end || end == text)
        return fault_set(fault, ERR_SYNTAX, "", "--%s: \"%.60s\" is not a number", option, text);
    if (*out >= least && *out <= most) return 0;
    return fault_set(fault, ERR_RANGE, "", "--%s: %.60s is not between %g and %g", option, text,
                     least, most);
}

int perceptual_metrics_parse(struct perceptual_metrics *l, struct fault *fault)
{
    int error = parse("exposure", l->exposure, -32, 32, 0, &l->view.exposure_ev, fault);
    if (!error) error = parse("gamma", l->gamma, 0.2, 5, 1, &l->view.gamma, fault);
    if (!error)
        error = parse("ppd", l->ppd, FLIP_PPD_MIN, FLIP_PPD_MAX, FLIP_PPD, &l->pixels_per_degree,
                      fault);
    if (error) return error;
    l->view.curve = VIEW_LINEAR;
    if (l->curve && !view_curve_from_name(l->curve, &l->view.curve))
        return fault_set(fault, ERR_SYNTAX, "", "--curve: \"%.60s\" is not linear, filmic or agx",
                         l->curve);
    return 0;
}

int perceptual_metrics_find(struct perceptual_metrics *l, const struct image *reference,
                            const struct image *test, const char *layer, struct fault *fault)
{
    struct display_pair pair;
    if (!l->ssim && !l->flip) return 0;
    int error = display_pair_create(reference, test, layer, &l->view, &pair, fault);
    if (error) return error;
    float *map = malloc((size_t)pair.width_px * (size_t)pair.height_px * sizeof *map);
    error = map ? 0 : ERR_MEMORY;
    if (!error && l->ssim) error = ssim_map(&pair, map, &l->ssim_mean);
    if (!error && l->flip) error = flip_map(&pair, l->pixels_per_degree, map, &l->flip_figures);
    l->pixels = pair.count;
    free(map);
    display_pair_fini(&pair);
    return error ? fault_set(fault, error, "", "memory is exhausted") : 0;
}

void perceptual_metrics_tell(const struct perceptual_metrics *l, json_t *line)
{
    const struct flip *f = &l->flip_figures;
    if (l->ssim) json_object_set_new(line, "ssim", json_real(l->ssim_mean));
    if (!l->flip) return;
    json_object_set_new(line, "flip",
                        json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:I}", "mean", f->mean, "q1",
                                  f->quartile[0], "median", f->quartile[1], "q3", f->quartile[2],
                                  "max", f->max, "ppd", l->pixels_per_degree, "pixels",
                                  (json_int_t)l->pixels));
}
