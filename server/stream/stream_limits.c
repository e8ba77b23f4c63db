/* What streams may take of the machine, and what they have taken. */

#include "proto/runtime/clock.h"
#include "server/stream/streams.h"

uint64_t streams_clock_us(void)
{
    return clock_us(CLOCK_MONOTONIC);
}

void streams_limit(struct streams *s, const struct streams_limits *limits)
{
    const struct pace was = s->pace;
    const uint64_t now_us = streams_clock_us();
    pace_init(&s->pace, limits->feed_bytes_per_s, now_us);
    s->pace.pictures = was.pictures;
    s->pace.readers = was.readers;
    share_init(&s->share, limits->cpu_us_per_s, now_us);
    pace_set_room(&s->pace, share_for_feeds_us(&s->share));
    s->stuck_ms = limits->stuck_ms;
}

enum meter_kind streams_meter(struct streams *s, enum meter_kind kind)
{
    return meter_switch(&s->meter, kind);
}

void streams_meter_run(struct streams *s)
{
    (void)meter_switch(&s->meter, s->due ? s->due : METER_OTHER);
    s->due = METER_NOBODY;
}

void streams_meter_ran(struct streams *s)
{
    (void)meter_switch(&s->meter, METER_NOBODY);
}

void streams_settle(struct streams *s)
{
    const struct settled all = {.events_us = meter_us(&s->meter, METER_EVENTS),
                                .pixels_us = meter_us(&s->meter, METER_PIXELS),
                                .pixel_bytes = s->pixel_bytes};
    const uint64_t events_us = all.events_us - s->settled.events_us;
    const uint64_t pixels_us = all.pixels_us - s->settled.pixels_us;
    /* While nothing is in work there is nobody to take it from. */
    share_settle(&s->share, streams_clock_us(), events_us, s->pace.pictures > 0 ? pixels_us : 0);
    pace_learn(&s->pace, all.pixel_bytes - s->settled.pixel_bytes, pixels_us);
    pace_set_room(&s->pace, share_for_feeds_us(&s->share));
    s->settled = all;
}

void streams_settle_when_due(struct streams *s)
{
    if (streams_clock_us() - s->share.at_us >= PACE_EVERY_MS * 1000u) streams_settle(s);
}

void stream_set_in_work(struct stream *stream, bool in_work)
{
    struct pace *pace = &stream->streams->pace;
    if (in_work && !stream->in_work) pace->pictures++;
    if (!in_work && stream->in_work) pace->pictures--;
    stream->in_work = in_work;
}

bool streams_may_tell(struct streams *s)
{
    streams_settle_when_due(s);
    const bool may = share_has_for_events(&s->share);
    s->tells_late += !may;
    return may;
}

bool streams_pace(struct streams *s)
{
    if (!s->pace.first) return false;
    const enum meter_kind was = meter_switch(&s->meter, METER_PIXELS);
    streams_settle(s);
    const bool wait = pace_deal(&s->pace, streams_clock_us());
    (void)meter_switch(&s->meter, was);
    return wait;
}

bool streams_wait(const struct streams *s)
{
    return s->pace.first != NULL;
}
