#include "server/stream/cpu_meter.h"

#include "proto/runtime/clock.h"

static void count(struct cpu_meter *meter)
{
    const uint64_t now_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    if (meter->kind != CPU_METER_NONE) meter->spent_ns[meter->kind] += now_ns - meter->at_ns;
    meter->at_ns = now_ns;
}

enum cpu_meter_kind cpu_meter_switch(struct cpu_meter *meter, enum cpu_meter_kind kind)
{
    const enum cpu_meter_kind was = meter->kind;
    if (was == kind) return was;
    count(meter);
    meter->kind = kind;
    return was;
}

uint64_t cpu_meter_us(struct cpu_meter *meter, enum cpu_meter_kind kind)
{
    if (meter->kind == kind && kind != CPU_METER_NONE) count(meter);
    return meter->spent_ns[kind] / 1000;
}
