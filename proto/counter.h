#pragma once
/* What is counted while a frame is made: one table, counter.def. */
#include <stdint.h>

enum counter_id {
#define COUNTER(name, group, key, text) COUNTER_##name,
#include "proto/counter.def"
#undef COUNTER
    COUNTER_COUNT
};

struct counters {
    uint64_t value[COUNTER_COUNT];
};

/* Adds `more` to `sum`, which saturates. */
void counters_add(struct counters *sum, const struct counters *more);
const char *counter_group(enum counter_id id); /* "rays", "skipped", "time" */
const char *counter_key(enum counter_id id);
const char *counter_text(enum counter_id id);
