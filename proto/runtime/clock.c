#include "proto/runtime/clock.h"

uint64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    if (clock_gettime(clock, &t) != 0) return 0;
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t clock_us(clockid_t clock)
{
    return clock_ns(clock) / 1000;
}

uint64_t thread_cpu_us(void)
{
    return clock_us(CLOCK_THREAD_CPUTIME_ID);
}
