#pragma once
/* Limits the bytes of pixels that all feeds together send a second while pictures are in work, and
 * the CPU time that this takes, so that viewers do not slow rendering down.
 *
 * A reader takes turns of RATE_LIMIT_TURN_BYTES. When bytes or time (cpu_budget.h) are spent,
 * readers wait in line and get their turns in the order in which they came. Each is sent the newest
 * pixels when its turn comes, so many viewers see fewer states on the way, and all of them see the
 * last. Unused bytes add up to those of one second. There is no limit for a handful of readers, nor
 * when no picture is in work. */
#include <stdbool.h>
#include <stdint.h>

#define RATE_LIMIT_TURN_BYTES   INT64_C(65536)
#define RATE_LIMIT_EVERY_MS     25u /* turns are dealt this often */
#define RATE_LIMIT_FREE_READERS 8u  /* this many are not limited */

struct reader;

struct rate_limit {
    int64_t bytes_per_s; /* 0: no limit */
    int64_t credit_bytes;
    bool timed;                   /* CPU time is limited */
    int64_t room_us;              /* CPU time for turns that are given from now on */
    int64_t turn_us;              /* what a turn takes, as far as is known */
    uint64_t at_us;               /* when credit was last given */
    unsigned pictures;            /* whose work is not done */
    unsigned readers;             /* of pixels */
    struct reader *first, **last; /* readers that wait, by wait_next */
    uint64_t turns, waits;        /* taken; those of them that had to wait */
};

/* Begins with the bytes of a second, and without a limit of time. */
void rate_limit_init(struct rate_limit *limit, int64_t bytes_per_s, uint64_t now_us);

bool rate_limit_is_on(const struct rate_limit *limit);

/* Takes one turn. False: there is none now, and the reader waits in line. */
bool rate_limit_ask(struct rate_limit *limit, struct reader *reader, uint64_t now_us);

/* Gives turns to waiting readers, and wakes them. Returns true when others still wait. */
bool rate_limit_deal(struct rate_limit *limit, uint64_t now_us);

/* Sets the CPU time for turns until the next call; INT64_MAX: no limit. */
void rate_limit_set_room(struct rate_limit *limit, int64_t room_us);

/* Learns from sent bytes how long a turn takes. */
void rate_limit_learn(struct rate_limit *limit, uint64_t bytes, uint64_t spent_us);

/* Gives back bytes of a turn that were not used. */
void rate_limit_return(struct rate_limit *limit, int64_t bytes);

/* Takes the reader out of the line, if it stands in it. */
void rate_limit_leave(struct rate_limit *limit, struct reader *reader);
