#include "server/http/resource/metric_text.h"

#include <inttypes.h>

void metric_family(FILE *out, const char *name, const char *type, const char *help)
{
    fprintf(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

void metric_single(FILE *out, const char *name, const char *type, const char *help, uint64_t value)
{
    metric_family(out, name, type, help);
    fprintf(out, "%s %" PRIu64 "\n", name, value);
}

void metric_labelled(FILE *out, const char *name, const char *label,
                     const struct metric_sample *samples, size_t count)
{
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%s{%s=\"%s\"} %" PRIu64 "\n", name, label, samples[i].label,
                samples[i].value);
}

void metric_histogram(FILE *out, const char *name, const char *labels,
                      const struct duration_histogram *h)
{
    const char *comma = labels[0] ? "," : "", *open = labels[0] ? "{" : "",
               *close = labels[0] ? "}" : "";
    uint64_t count = 0;
    for (int i = 0; i < DURATION_BUCKETS; i++) {
        count += h->count[i];
        fprintf(out, "%s_bucket{%s%sle=\"%g\"} %" PRIu64 "\n", name, labels, comma,
                duration_bounds[i], count);
    }
    count += h->count[DURATION_BUCKETS];
    fprintf(out, "%s_bucket{%s%sle=\"+Inf\"} %" PRIu64 "\n", name, labels, comma, count);
    fprintf(out, "%s_sum%s%s%s %.6f\n", name, open, labels, close, (double)h->total_us * 1e-6);
    fprintf(out, "%s_count%s%s%s %" PRIu64 "\n", name, open, labels, close, count);
}
