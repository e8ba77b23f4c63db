#include "server/job/frame/statistics.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "server/reconstruct/compose/block_statistics.h"

static uint64_t merged_sum(uint64_t a, uint64_t b)
{
    return a + b;
}

static uint64_t merged_max(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

void statistics_add(struct statistics *sum, const struct statistics *more)
{
    counters_add(&sum->counters, &more->counters);
    counters_add(&sum->counters_resumed, &more->counters_resumed);
#define STATISTIC(name, group, key, unit, merge, origin, text)                                     \
    sum->name = merged_##merge(sum->name, more->name);
#include "server/job/frame/statistic.def"
}

#define KEPT_cost           true
#define KEPT_filter(member) true
#define KEPT_picture        false
#define KEPT_block(member)  false

void statistics_forget_picture(struct statistics *s)
{
#define STATISTIC(name, group, key, unit, merge, origin, text)                                     \
    if (!KEPT_##origin) s->name = 0;
#include "server/job/frame/statistic.def"
}

#define FOUND_cost           0
#define FOUND_filter(member) 0
#define FOUND_picture        0
#define FOUND_block(member)  block->member

void statistics_add_block(struct statistics *sum, const struct block_statistics *block)
{
#define STATISTIC(name, group, key, unit, merge, origin, text) sum->name += FOUND_##origin;
#include "server/job/frame/statistic.def"
}

#define FILTER_cost           0
#define FILTER_filter(member) block->member
#define FILTER_picture        0
#define FILTER_block(member)  0

uint64_t statistics_add_filters(struct statistics *sum, const struct block_statistics *block)
{
    uint64_t all_us = 0;
#define STATISTIC(name, group, key, unit, merge, origin, text)                                     \
    sum->name += FILTER_##origin;                                                                  \
    all_us += FILTER_##origin;
#include "server/job/frame/statistic.def"
    return all_us;
}

/* Where each number lies in the JSON. */
struct row {
    const char *group, *key; /* group "": at the top */
    size_t offset;
    bool millionths; /* here, of a second or of one */
};
#define MILLIONTHS_seconds  true
#define MILLIONTHS_fraction true
#define MILLIONTHS_count    false
#define MILLIONTHS_bytes    false

static const struct row rows[] = {
#define STATISTIC(name, group, key, unit, merge, origin, text)                                     \
    {group, key, offsetof(struct statistics, name), MILLIONTHS_##unit},
#define COUNTED(counter, group, key, text)                                                         \
    {group, key, offsetof(struct statistics, counters.value[COUNTER_##counter]), true},
#include "server/job/frame/statistic.def"
};
#define ROW_COUNT (sizeof rows / sizeof rows[0])

static uint64_t get(const struct statistics *s, const struct row *row)
{
    uint64_t value;
    memcpy(&value, (const char *)s + row->offset, sizeof value);
    return value;
}

static json_t *group_of(json_t *root, const char *name)
{
    if (!*name) return root;
    json_t *group = json_object_get(root, name);
    if (group) return group;
    json_object_set_new(root, name, json_object());
    return json_object_get(root, name);
}

/* Counters of the groups rays and skipped stand under their own keys; times are rows above. */
static bool is_listed(enum counter_id id)
{
    return strcmp(counter_group(id), "time") != 0;
}

json_t *statistics_json(const struct statistics *s)
{
    json_t *root = json_object();
    uint64_t total_us = 0;
    for (size_t i = 0; i < ROW_COUNT; i++) {
        const struct row *row = &rows[i];
        uint64_t value = get(s, row);
        json_t *into = group_of(root, row->group);
        json_object_set_new(into, row->key,
                            row->millionths ? json_real((double)value * 1e-6)
                                            : json_integer((json_int_t)value));
        if (!strcmp(row->group, "cpu_s")) total_us += value;
    }
    json_object_set_new(group_of(root, "cpu_s"), "total", json_real((double)total_us * 1e-6));
    for (unsigned i = 0; i < COUNTER_COUNT; i++)
        if (is_listed((enum counter_id)i))
            json_object_set_new(group_of(root, counter_group((enum counter_id)i)),
                                counter_key((enum counter_id)i),
                                json_integer((json_int_t)s->counters.value[i]));
    return root;
}

static uint64_t number_of(const json_t *json, double scale)
{
    double value = json_number_value(json) * scale;
    return value > 0 && value < 9e15 ? (uint64_t)llround(value) : 0;
}

void statistics_read(const json_t *json, struct statistics *out)
{
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < ROW_COUNT; i++) {
        const struct row *row = &rows[i];
        const json_t *from = *row->group ? json_object_get(json, row->group) : json;
        uint64_t value = number_of(json_object_get(from, row->key), row->millionths ? 1e6 : 1);
        memcpy((char *)out + row->offset, &value, sizeof value);
    }
    for (unsigned i = 0; i < COUNTER_COUNT; i++) {
        const json_t *group = json_object_get(json, counter_group((enum counter_id)i));
        if (is_listed((enum counter_id)i))
            out->counters.value[i] =
                number_of(json_object_get(group, counter_key((enum counter_id)i)), 1);
    }
}
