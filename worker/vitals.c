#include "worker/vitals.h"

#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

static uint64_t resident_bytes(void)
{
    unsigned long long total = 0, resident = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    if (!f) return 0;
    int n = fscanf(f, "%llu %llu", &total, &resident);
    fclose(f);
    return n == 2 ? resident * (uint64_t)sysconf(_SC_PAGESIZE) : 0;
}

static uint64_t micros(struct timeval t)
{
    return (uint64_t)t.tv_sec * 1000000u + (uint64_t)t.tv_usec;
}

void vitals_read(struct vitals *out)
{
    struct rusage usage = {0};
    getrusage(RUSAGE_SELF, &usage);
    out->rss_bytes = resident_bytes();
    out->peak_rss_bytes = (uint64_t)usage.ru_maxrss * 1024u;
    out->cpu_us = micros(usage.ru_utime) + micros(usage.ru_stime);
}
