#include "server/metric/duration_histogram.h"

const double duration_bounds[DURATION_BUCKETS] = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                  0.1,   0.25,   0.5,   1,    5,     30};

void duration_histogram_add(struct duration_histogram *h, uint64_t us)
{
    const double seconds = (double)us * 1e-6;
    int i = 0;
    while (i < DURATION_BUCKETS && seconds > duration_bounds[i]) i++;
    h->count[i]++;
    h->total_us += us;
}
