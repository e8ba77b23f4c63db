#pragma once
/* The CPU time of this thread, and the median of what was measured. */
#include <stddef.h>
#include <stdlib.h>
#include <time.h>

static inline double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the numbers. */
static inline double median(double *v, size_t count)
{
    qsort(v, count, sizeof *v, compare_doubles);
    return v[count / 2];
}
