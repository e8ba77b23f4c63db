#pragma once
/* How this process is doing: what a BEAT tells. */
#include <stdint.h>

struct vitals {
    uint64_t rss_bytes, peak_rss_bytes;
    uint64_t cpu_us; /* user and system, all threads, since the start */
};

void vitals_read(struct vitals *out);
