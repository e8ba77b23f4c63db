#include "worker/trace/light/light.h"

static uint64_t count_skip(const struct light_packet *p, const struct lanes_mask *lanes,
                           enum light_skip skip)
{
    int32_t sum = 0;
    for (int i = 0; i < LANES; i++) sum -= lanes->on[i] & -(p->skip[i] == (int32_t)skip);
    return (uint64_t)sum;
}

void light_count_skips(const struct light_packet *p, const struct lanes_mask *lanes, uint32_t times,
                       struct counters *counters)
{
    uint64_t *value = counters->value;
    value[COUNTER_SKIPPED_BELOW_HORIZON] += times * (count_skip(p, lanes, LIGHT_BELOW_HORIZON) +
                                                     count_skip(p, lanes, LIGHT_BELOW_FACET));
    value[COUNTER_SKIPPED_FACING_AWAY] += times * count_skip(p, lanes, LIGHT_FACING_AWAY);
    value[COUNTER_SKIPPED_OUT_OF_RANGE] += times * count_skip(p, lanes, LIGHT_OUT_OF_RANGE);
    value[COUNTER_SKIPPED_OUT_OF_CONE] += times * count_skip(p, lanes, LIGHT_OUT_OF_CONE);
    value[COUNTER_REJECTED_NOT_FINITE] += times * count_skip(p, lanes, LIGHT_NOT_FINITE);
}
