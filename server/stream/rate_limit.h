#pragma once
/* How many bytes of pixels all feeds together are sent a second while pictures are in work, and how
 * much CPU time that may take.
 *
 * Watching must not slow what is watched. Who wants to send takes a turn of RATE_LIMIT_TURN_BYTES;
 * when bytes or time (cpu_budget.h) are spent, readers wait in line, and get their turns in the
 * order in which they came. Each is sent what is newest when its turn comes, so many watchers see
 * fewer states on the way and all of them the last. Bytes that are not used add up to those of one
 * second: a few readers never wait. When no picture is in work there is nothing to slow, and no
 * limit; nor for a handful of readers. */
#include <stdbool.h>
#include <stdint.h>

#define RATE_LIMIT_TURN_BYTES   INT64_C(65536)
#define RATE_LIMIT_EVERY_MS     25u /* turns are dealt so often */
#define RATE_LIMIT_FREE_READERS 8u  /* so few are not limited */

struct reader;

struct rate_limit {
    int64_t bytes_per_s; /* 0: no limit */
    int64_t credit_bytes;
    bool timed;                   /* CPU time is limited */
    int64_t room_us;              /* of CPU time, for turns that are given from now on */
    int64_t turn_us;              /* that a turn takes, as far as is known */
    uint64_t at_us;               /* when credit was last given */
    unsigned pictures;            /* in work: until all that is to be made of them is there */
    unsigned readers;             /* of pixels */
    struct reader *first, **last; /* who waits, by wait_next */
    uint64_t turns, waits;        /* taken; of them those that had to wait */
};

/* Begins with the bytes of a second, and without limit of time. */
void rate_limit_init(struct rate_limit *limit, int64_t bytes_per_s, uint64_t now_us);

bool rate_limit_is_on(const struct rate_limit *limit);

/* One turn, at once or never now: then the reader is in line, and waits. */
bool rate_limit_ask(struct rate_limit *limit, struct reader *reader, uint64_t now_us);

/* Gives turns to those who wait, and wakes them; true when others still do. */
bool rate_limit_deal(struct rate_limit *limit, uint64_t now_us);

/* So much CPU time there is for turns until this is called again; INT64_MAX: no limit. */
void rate_limit_set_room(struct rate_limit *limit, int64_t room_us);

/* Learns from bytes that were sent how long a turn takes. */
void rate_limit_learn(struct rate_limit *limit, uint64_t bytes, uint64_t spent_us);

/* Bytes of a turn that found no use. */
void rate_limit_return(struct rate_limit *limit, int64_t bytes);

/* Takes the reader out of the line, if it is in it. */
void rate_limit_leave(struct rate_limit *limit, struct reader *reader);
