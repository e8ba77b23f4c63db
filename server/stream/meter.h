#pragma once
/* Whose the CPU time of the loop's thread is.
 *
 * A clock stands between those who take turns on the thread: what passes from one meter_switch to
 * the next is the first one's. Sockets' work is in it: what the kernel does for a send, it does on
 * the sender's time. */
#include <stdint.h>

enum meter_kind {
    METER_NOBODY, /* not counted */
    METER_OTHER,  /* requests that are no streams */
    METER_EVENTS,
    METER_PIXELS,
};
#define METER_KINDS 4

struct meter {
    enum meter_kind kind;
    uint64_t at_ns; /* of the thread's CPU clock, when it became that */
    uint64_t spent_ns[METER_KINDS];
};

/* From here on the time is that kind's; returned is whose it was. Cheap where that is the same. */
enum meter_kind meter_switch(struct meter *meter, enum meter_kind kind);

/* Up to now. */
uint64_t meter_us(struct meter *meter, enum meter_kind kind);
