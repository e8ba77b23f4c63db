#pragma once
/* Whose the CPU time of the loop's thread is.
 *
 * A clock stands between those who take turns on the thread: what passes from one cpu_meter_switch
 * to the next is the first one's. Sockets' work is in it: what the kernel does for a send, it does
 * on the sender's time. */
#include <stdint.h>

enum cpu_meter_kind {
    CPU_METER_NONE,  /* not counted */
    CPU_METER_OTHER, /* requests that are no streams */
    CPU_METER_EVENTS,
    CPU_METER_PIXELS,
};
#define CPU_METER_KINDS 4

struct cpu_meter {
    enum cpu_meter_kind kind;
    uint64_t at_ns; /* of the thread's CPU clock, when it became that */
    uint64_t spent_ns[CPU_METER_KINDS];
};

/* From here on the time is that kind's; returned is whose it was. Cheap where that is the same. */
enum cpu_meter_kind cpu_meter_switch(struct cpu_meter *meter, enum cpu_meter_kind kind);

/* Up to now. */
uint64_t cpu_meter_us(struct cpu_meter *meter, enum cpu_meter_kind kind);
