/* What streams may take of the machine, and what they have taken. */

#include "proto/runtime/clock.h"
#include "server/stream/streams.h"

uint64_t streams_clock_us(void)
{
    return clock_us(CLOCK_MONOTONIC);
}

void streams_limit(struct streams *s, const struct streams_limits *limits)
{
    const struct rate_limit was = s->rate_limit;
    const uint64_t now_us = streams_clock_us();
    rate_limit_init(&s->rate_limit, limits->feed_bytes_per_s, now_us);
    s->rate_limit.pictures = was.pictures;
    s->rate_limit.readers = was.readers;
    cpu_budget_init(&s->cpu_budget, limits->cpu_us_per_s, now_us);
    rate_limit_set_room(&s->rate_limit, cpu_budget_for_feeds_us(&s->cpu_budget));
    s->stuck_ms = limits->stuck_ms;
}

enum cpu_meter_kind streams_meter(struct streams *s, enum cpu_meter_kind kind)
{
    return cpu_meter_switch(&s->meter, kind);
}

void streams_meter_run(struct streams *s)
{
    (void)cpu_meter_switch(&s->meter, s->due ? s->due : CPU_METER_OTHER);
    s->due = CPU_METER_NONE;
}

void streams_meter_ran(struct streams *s)
{
    (void)cpu_meter_switch(&s->meter, CPU_METER_NONE);
}

void streams_settle(struct streams *s)
{
    const struct settled all = {.events_us = cpu_meter_us(&s->meter, CPU_METER_EVENTS),
                                .pixels_us = cpu_meter_us(&s->meter, CPU_METER_PIXELS),
                                .pixel_bytes = s->pixel_bytes};
    const uint64_t events_us = all.events_us - s->settled.events_us;
    const uint64_t pixels_us = all.pixels_us - s->settled.pixels_us;
    /* While nothing is in work there is nothing to protect. */
    cpu_budget_settle(&s->cpu_budget, streams_clock_us(), events_us,
                      s->rate_limit.pictures > 0 ? pixels_us : 0);
    rate_limit_learn(&s->rate_limit, all.pixel_bytes - s->settled.pixel_bytes, pixels_us);
    rate_limit_set_room(&s->rate_limit, cpu_budget_for_feeds_us(&s->cpu_budget));
    s->settled = all;
}

void streams_settle_when_due(struct streams *s)
{
    if (streams_clock_us() - s->cpu_budget.at_us >= RATE_LIMIT_EVERY_MS * 1000u) streams_settle(s);
}

void stream_set_in_work(struct stream *stream, bool in_work)
{
    struct rate_limit *limit = &stream->streams->rate_limit;
    if (in_work && !stream->in_work) limit->pictures++;
    if (!in_work && stream->in_work) limit->pictures--;
    stream->in_work = in_work;
}

bool streams_may_tell(struct streams *s)
{
    streams_settle_when_due(s);
    const bool may = cpu_budget_has_for_events(&s->cpu_budget);
    s->tells_late += !may;
    return may;
}

bool streams_pace(struct streams *s)
{
    if (!s->rate_limit.first) return false;
    const enum cpu_meter_kind was = cpu_meter_switch(&s->meter, CPU_METER_PIXELS);
    streams_settle(s);
    const bool wait = rate_limit_deal(&s->rate_limit, streams_clock_us());
    (void)cpu_meter_switch(&s->meter, was);
    return wait;
}

bool streams_wait(const struct streams *s)
{
    return s->rate_limit.first != NULL;
}
