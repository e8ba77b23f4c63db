#include "proto/counter.h"

#include <assert.h>
#include <stddef.h>

struct counter_row {
    const char *group, *key, *text;
};

static const struct counter_row rows[COUNTER_COUNT] = {
#define COUNTER(name, group, key, text) {#group, #key, text},
#include "proto/counter.def"
#undef COUNTER
};

void counters_add(struct counters *sum, const struct counters *more)
{
    for (size_t i = 0; i < COUNTER_COUNT; i++)
        if (__builtin_add_overflow(sum->value[i], more->value[i], &sum->value[i]))
            sum->value[i] = UINT64_MAX;
}

static const struct counter_row *row_of(enum counter_id id)
{
    assert((unsigned)id < COUNTER_COUNT);
    return &rows[id];
}

const char *counter_group(enum counter_id id)
{
    return row_of(id)->group;
}

const char *counter_key(enum counter_id id)
{
    return row_of(id)->key;
}

const char *counter_text(enum counter_id id)
{
    return row_of(id)->text;
}
