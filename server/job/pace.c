#include "server/job/pace.h"

#include <math.h>

#define NOTE_EVERY_US 200000.0
#define MEMORY_MIN_US 5e6 /* within which all time counts alike */
#define MEMORY_SHARE  (1.0 / 3.0)
#define PASSED_SHARE  0.5 /* what is left at least after some time without a result */

void pace_start(struct pace *p, uint64_t now_us, double cost_us)
{
    *p = (struct pace){.started_us = now_us, .noted_us = now_us, .noted_cost_us = cost_us};
}

void pace_note(struct pace *p, uint64_t now_us, double cost_us)
{
    const double step_us = (double)(now_us - p->noted_us), spent_us = cost_us - p->noted_cost_us;
    if (p->started_us == 0 || step_us < NOTE_EVERY_US || spent_us <= 0.0) return;
    /* What went before the first result is no pace: workers were reading the scene. */
    if (p->rate == 0.0) p->started_us = now_us - (uint64_t)fmin(step_us, spent_us);
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

void pace_rest(struct pace *p, uint64_t now_us)
{
    if (p->started_us == 0) return;
    p->started_us += now_us - p->noted_us;
    p->noted_us = now_us;
}

double pace_time_s(const struct pace *p, uint64_t now_us, double left_us)
{
    const double left_s = p->rate > 0.0 ? left_us / p->rate * 1e-6 : -1.0;
    const double since_s = (double)(now_us - p->noted_us) * 1e-6;
    return fmax(left_s - since_s, PASSED_SHARE * left_s);
}
