#include "server/stream/rate_limit.h"

#include <stddef.h>

#include "server/stream/reader.h"

#define FIRST_TURN_US 100 /* until some were seen */

void rate_limit_init(struct rate_limit *limit, int64_t bytes_per_s, uint64_t now_us)
{
    *limit = (struct rate_limit){.bytes_per_s = bytes_per_s,
                                 .credit_bytes = bytes_per_s,
                                 .turn_us = FIRST_TURN_US,
                                 .at_us = now_us};
}

bool rate_limit_is_on(const struct rate_limit *limit)
{
    return (limit->bytes_per_s > 0 || limit->timed) && limit->pictures > 0 &&
           limit->readers > RATE_LIMIT_FREE_READERS;
}

static bool has_turn(const struct rate_limit *limit)
{
    return (limit->bytes_per_s == 0 || limit->credit_bytes >= RATE_LIMIT_TURN_BYTES) &&
           (!limit->timed || limit->room_us > 0);
}

/* At most a second's worth is saved up; longer times than that give no more. */
static void give_credit(struct rate_limit *limit, uint64_t now_us)
{
    uint64_t passed_us = now_us - limit->at_us;
    if (passed_us > 1000000) passed_us = 1000000;
    limit->at_us = now_us;
    limit->credit_bytes += limit->bytes_per_s * (int64_t)passed_us / 1000000;
    if (limit->credit_bytes > limit->bytes_per_s) limit->credit_bytes = limit->bytes_per_s;
}

static void give_turn(struct rate_limit *limit, struct reader *reader)
{
    if (limit->bytes_per_s > 0) limit->credit_bytes -= RATE_LIMIT_TURN_BYTES;
    if (limit->timed) limit->room_us -= limit->turn_us;
    limit->turns++;
    reader->turn_bytes += RATE_LIMIT_TURN_BYTES;
}

static void stand_in_line(struct rate_limit *limit, struct reader *reader)
{
    if (!limit->first) limit->last = &limit->first;
    reader->waits = true;
    reader->wait_next = NULL;
    reader->wait_link = limit->last;
    *limit->last = reader;
    limit->last = &reader->wait_next;
    limit->waits++;
}

bool rate_limit_ask(struct rate_limit *limit, struct reader *reader, uint64_t now_us)
{
    if (!limit->first) give_credit(limit, now_us);
    if (limit->first || !has_turn(limit)) {
        stand_in_line(limit, reader);
        return false;
    }
    give_turn(limit, reader);
    return true;
}

void rate_limit_leave(struct rate_limit *limit, struct reader *reader)
{
    if (!reader->waits) return;
    reader->waits = false;
    *reader->wait_link = reader->wait_next;
    if (reader->wait_next)
        reader->wait_next->wait_link = reader->wait_link;
    else
        limit->last = reader->wait_link;
    reader->wait_next = NULL;
    reader->wait_link = NULL;
}

bool rate_limit_deal(struct rate_limit *limit, uint64_t now_us)
{
    if (limit->bytes_per_s > 0) give_credit(limit, now_us);
    while (limit->first && (!rate_limit_is_on(limit) || has_turn(limit))) {
        struct reader *reader = limit->first;
        rate_limit_leave(limit, reader);
        if (rate_limit_is_on(limit)) give_turn(limit, reader);
        reader_wake(reader);
    }
    return limit->first != NULL;
}

void rate_limit_return(struct rate_limit *limit, int64_t bytes)
{
    if (limit->bytes_per_s > 0) limit->credit_bytes += bytes;
}

void rate_limit_set_room(struct rate_limit *limit, int64_t room_us)
{
    limit->timed = room_us < INT64_MAX;
    limit->room_us = room_us;
}

void rate_limit_learn(struct rate_limit *limit, uint64_t bytes, uint64_t spent_us)
{
    if (bytes < (uint64_t)RATE_LIMIT_TURN_BYTES) return;
    const int64_t took_us = (int64_t)(spent_us * (uint64_t)RATE_LIMIT_TURN_BYTES / bytes);
    limit->turn_us += (took_us - limit->turn_us) / 4;
    if (limit->turn_us < 1) limit->turn_us = 1;
}
