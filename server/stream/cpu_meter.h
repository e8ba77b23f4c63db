#pragma once
/* Accounts for the CPU time of the loop's thread.
 *
 * The time from one cpu_meter_switch to the next counts for the first one's kind. The kernel's work
 * on sockets is included: a send runs on the sender's time. */
#include <stdint.h>

enum cpu_meter_kind {
    CPU_METER_NONE,  /* not counted */
    CPU_METER_OTHER, /* requests other than streams */
    CPU_METER_EVENTS,
    CPU_METER_PIXELS,
};
#define CPU_METER_KINDS 4

struct cpu_meter {
    enum cpu_meter_kind kind;
    uint64_t at_ns; /* the thread's CPU clock at the last switch */
    uint64_t spent_ns[CPU_METER_KINDS];
};

/* Counts the time from here on for this kind, and returns the kind before. Cheap when both are the
 * same. */
enum cpu_meter_kind cpu_meter_switch(struct cpu_meter *meter, enum cpu_meter_kind kind);

/* Returns the time spent on a kind up to now. */
uint64_t cpu_meter_us(struct cpu_meter *meter, enum cpu_meter_kind kind);
