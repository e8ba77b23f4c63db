#include "server/stream/meter.h"

#include <time.h>

static uint64_t thread_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static void count(struct meter *meter)
{
    const uint64_t now_ns = thread_ns();
    if (meter->kind != METER_NOBODY) meter->spent_ns[meter->kind] += now_ns - meter->at_ns;
    meter->at_ns = now_ns;
}

enum meter_kind meter_switch(struct meter *meter, enum meter_kind kind)
{
    const enum meter_kind was = meter->kind;
    if (was == kind) return was;
    count(meter);
    meter->kind = kind;
    return was;
}

uint64_t meter_us(struct meter *meter, enum meter_kind kind)
{
    if (meter->kind == kind && kind != METER_NOBODY) count(meter);
    return meter->spent_ns[kind] / 1000;
}
