#pragma once
/* A histogram of durations, in buckets that are the same for all. */
#include <stdint.h>

#define DURATION_BUCKETS 12

/* Upper bounds in seconds, each included. Longer durations are counted behind the last. */
extern const double duration_bounds[DURATION_BUCKETS];

struct duration_histogram {
    uint64_t count[DURATION_BUCKETS + 1]; /* in each bucket alone */
    uint64_t total_us;
};

void duration_histogram_add(struct duration_histogram *h, uint64_t us);
