/* shearwater compare: how far one EXR is from another, as one JSON line. */
#include <jansson.h>
#include <stdio.h>

#include "server/cli/cli.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"
#include "server/image/difference.h"
#include "server/image/exr.h"

static json_t *three(const double v[3])
{
    return json_pack("[fff]", v[0], v[1], v[2]);
}

static void print_line(const struct difference *d, const char *layer)
{
    json_t *line = json_pack("{s:s, s:f, s:f, s:f, s:f, s:f, s:b, s:o, s:o}", "layer", layer,
                             "rmse", d->rmse, "relmse", d->relmse, "bias", d->bias, "p999", d->p999,
                             "max", d->max, "finite", (int)d->finite, "mean_reference",
                             three(d->mean_reference), "mean_test", three(d->mean_test));
    json_dumpf(line, stdout, JSON_COMPACT | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(line);
}

int cli_compare(int argc, char **argv)
{
    const char *layer = "beauty";
    const struct option_line lines[] = {
        {"layer", 'l', OPTION_TEXT, "NAME", "beauty (default), direct, albedo, ...", 0, 0, &layer},
    };
    const struct option_table table = {
        .usage = "shearwater compare REF.exr TEST.exr [--layer NAME]",
        .summary =
            "Prints rmse, relmse, bias, the 99.9th percentile of the error, and whether both\n"
            "pictures are finite, on linear values, as one JSON line.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 2,
        .most_arguments = 2,
    };
    struct fault fault = {0};
    struct image *reference = NULL, *test = NULL;
    struct difference difference;
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    int error = exr_read(argv[1], &reference, &fault);
    if (!error) error = exr_read(argv[2], &test, &fault);
    if (!error) error = image_difference(reference, test, layer, &difference, &fault);
    if (!error) print_line(&difference, layer);
    status = error ? job_file_complain("compare", &fault) : 0;
    image_destroy(&reference);
    image_destroy(&test);
    return status;
}
