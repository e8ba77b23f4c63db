#include "server/stream/meter.h"

#include "proto/runtime/clock.h"

static void count(struct meter *meter)
{
    const uint64_t now_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
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
