#include "server/stream/pace.h"

#include <stddef.h>

#include "server/stream/reader.h"

#define FIRST_TURN_US 100 /* until some were seen */

void pace_init(struct pace *pace, int64_t bytes_per_s, uint64_t now_us)
{
    *pace = (struct pace){.bytes_per_s = bytes_per_s,
                          .credit_bytes = bytes_per_s,
                          .turn_us = FIRST_TURN_US,
                          .at_us = now_us};
}

bool pace_is_on(const struct pace *pace)
{
    return (pace->bytes_per_s > 0 || pace->timed) && pace->pictures > 0 &&
           pace->readers > PACE_FREE_READERS;
}

static bool has_turn(const struct pace *pace)
{
    return (pace->bytes_per_s == 0 || pace->credit_bytes >= PACE_TURN_BYTES) &&
           (!pace->timed || pace->room_us > 0);
}

/* At most a second's worth is saved up; longer times than that give no more. */
static void give_credit(struct pace *pace, uint64_t now_us)
{
    uint64_t passed_us = now_us - pace->at_us;
    if (passed_us > 1000000) passed_us = 1000000;
    pace->at_us = now_us;
    pace->credit_bytes += pace->bytes_per_s * (int64_t)passed_us / 1000000;
    if (pace->credit_bytes > pace->bytes_per_s) pace->credit_bytes = pace->bytes_per_s;
}

static void give_turn(struct pace *pace, struct reader *reader)
{
    if (pace->bytes_per_s > 0) pace->credit_bytes -= PACE_TURN_BYTES;
    if (pace->timed) pace->room_us -= pace->turn_us;
    pace->turns++;
    reader->turn_bytes += PACE_TURN_BYTES;
}

static void stand_in_line(struct pace *pace, struct reader *reader)
{
    if (!pace->first) pace->last = &pace->first;
    reader->waits = true;
    reader->wait_next = NULL;
    reader->wait_link = pace->last;
    *pace->last = reader;
    pace->last = &reader->wait_next;
    pace->waits++;
}

bool pace_ask(struct pace *pace, struct reader *reader, uint64_t now_us)
{
    if (!pace->first) give_credit(pace, now_us);
    if (pace->first || !has_turn(pace)) {
        stand_in_line(pace, reader);
        return false;
    }
    give_turn(pace, reader);
    return true;
}

void pace_leave(struct pace *pace, struct reader *reader)
{
    if (!reader->waits) return;
    reader->waits = false;
    *reader->wait_link = reader->wait_next;
    if (reader->wait_next)
        reader->wait_next->wait_link = reader->wait_link;
    else
        pace->last = reader->wait_link;
    reader->wait_next = NULL;
    reader->wait_link = NULL;
}

bool pace_deal(struct pace *pace, uint64_t now_us)
{
    if (pace->bytes_per_s > 0) give_credit(pace, now_us);
    while (pace->first && (!pace_is_on(pace) || has_turn(pace))) {
        struct reader *reader = pace->first;
        pace_leave(pace, reader);
        if (pace_is_on(pace)) give_turn(pace, reader);
        reader_wake(reader);
    }
    return pace->first != NULL;
}

void pace_return(struct pace *pace, int64_t bytes)
{
    if (pace->bytes_per_s > 0) pace->credit_bytes += bytes;
}

void pace_set_room(struct pace *pace, int64_t room_us)
{
    pace->timed = room_us < INT64_MAX;
    pace->room_us = room_us;
}

void pace_learn(struct pace *pace, uint64_t bytes, uint64_t spent_us)
{
    if (bytes < (uint64_t)PACE_TURN_BYTES) return;
    const int64_t took_us = (int64_t)(spent_us * (uint64_t)PACE_TURN_BYTES / bytes);
    pace->turn_us += (took_us - pace->turn_us) / 4;
    if (pace->turn_us < 1) pace->turn_us = 1;
}
