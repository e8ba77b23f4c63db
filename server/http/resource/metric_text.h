#pragma once
/* Prometheus' text format 0.0.4: families of samples. Names, labels and help are ours and need no
 * escapes. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "server/metric/duration_histogram.h"

/* Begins a family. type: "counter", "gauge" or "histogram". Its samples follow at once. */
void metric_family(FILE *out, const char *name, const char *type, const char *help);

/* Writes a family of one sample. */
void metric_single(FILE *out, const char *name, const char *type, const char *help, uint64_t value);

/* Samples of a family with one label. */
struct metric_sample {
    const char *label;
    uint64_t value;
};
void metric_labelled(FILE *out, const char *name, const char *label,
                     const struct metric_sample *samples, size_t count);

/* Writes samples of a family of histograms. labels: `a="x",b="y"`, or "". */
void metric_histogram(FILE *out, const char *name, const char *labels,
                      const struct duration_histogram *h);
