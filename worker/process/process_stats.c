#include "worker/process/process_stats.h"

#include <stdio.h>
#include <sys/resource.h>

/* Reads memory from the kernel's status page. getrusage's maximum would include the parent before
 * exec. */
static void read_memory(struct process_stats *out)
{
    char line[128];
    unsigned long long kib;
    FILE *f = fopen("/proc/self/status", "re");
    if (!f) return;
    while (fgets(line, sizeof line, f)) {
        if (sscanf(line, "VmHWM: %llu kB", &kib) == 1) out->peak_rss_bytes = kib * 1024u;
        if (sscanf(line, "VmRSS: %llu kB", &kib) == 1) out->rss_bytes = kib * 1024u;
    }
    fclose(f);
}

static uint64_t micros(struct timeval t)
{
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_usec;
}

void process_stats_read(struct process_stats *out)
{
    struct rusage usage = {0};
    *out = (struct process_stats){0};
    read_memory(out);
    getrusage(RUSAGE_SELF, &usage);
    out->cpu_us = micros(usage.ru_utime) + micros(usage.ru_stime);
}
