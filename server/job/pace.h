#pragma once
/* How fast a job's CPU time is spent, from which its time left follows. A mean over the latest
 * third of its time forgets workers that have left, and the slow start. */
#include <stdbool.h>
#include <stdint.h>

struct pace {
    uint64_t started_us, noted_us; /* clock; started 0: not running */
    double noted_cost_us;          /* all CPU time at noted_us */
    double rate;                   /* CPU us a us; 0: not known yet */
};

/* Starts it; cost_us is the CPU time that had been spent before. */
void pace_start(struct pace *p, uint64_t now_us, double cost_us);

/* Notes the CPU time that has been spent by now. */
void pace_note(struct pace *p, uint64_t now_us, double cost_us);

/* Returns the CPU time that a frame still takes: at first as much as those before it, once a tenth
 * of it (share) is here what its own samples say. mean_us: of a frame before; 0: there is none. */
double pace_frame_left_us(double own_left_us, double done_us, double share, double mean_us);

/* Leaves out the time since the latest note, in which workers had nothing to do. */
void pace_rest(struct pace *p, uint64_t now_us);

/* Returns how long work of some CPU time will take, in seconds, counted down between results;
 * negative: not known yet. */
double pace_time_s(const struct pace *p, uint64_t now_us, double left_us);
