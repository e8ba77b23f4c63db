#pragma once
/* The memory and CPU time of this process, for BEAT. */
#include <stdint.h>

struct process_stats {
    uint64_t rss_bytes, peak_rss_bytes;
    uint64_t cpu_us; /* user and system time of all threads since the start */
};

void process_stats_read(struct process_stats *out);
