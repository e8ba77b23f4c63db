#include "server/job/pace.h"

#include <math.h>

#define NOTE_EVERY_US 200000.0
#define MEMORY_MIN_US 5e6 /* within which all time counts alike */
#define MEMORY_SHARE  (1.0 / 3.0)

void pace_start(struct pace *p, uint64_t now_us, double cost_us)
{
    *p = (struct pace){.started_us = now_us, .noted_us = now_us, .noted_cost_us = cost_us};
}

void pace_note(struct pace *p, uint64_t now_us, double cost_us)
{
    const double step_us = (double)(now_us - p->noted_us), spent_us = cost_us - p->noted_cost_us;
    if (p->started_us == 0 || step_us < NOTE_EVERY_US || spent_us <= 0.0) return;
    const double all_us = (double)(now_us - p->started_us);
    const double memory_us = fmax(MEMORY_MIN_US, MEMORY_SHARE * all_us);
    /* At first a plain mean over all steps, then one that forgets. */
    const double weight = fmax(step_us / all_us, 1.0 - exp(-step_us / memory_us));
    p->rate += weight * (spent_us / step_us - p->rate);
    p->noted_us = now_us;
    p->noted_cost_us = cost_us;
}

double pace_frame_left_us(double own_left_us, double done_us, double share, double mean_us)
{
    const double trust = mean_us > 0.0 ? fmin(1.0, 10.0 * share) : 1.0;
    return trust * own_left_us + (1.0 - trust) * fmax(0.0, mean_us - done_us);
}

double pace_time_s(const struct pace *p, double left_us)
{
    return p->rate > 0.0 ? left_us / p->rate * 1e-6 : -1.0;
}
