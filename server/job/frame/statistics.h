#pragma once
/* What a job cost, and what was found of its pictures. statistic.def lists the fields, beside the
 * workers' counters. They are the numbers of --stats. */
#include <jansson.h>
#include <stdint.h>

#include "proto/counter.h"

struct block_statistics;

struct statistics {
    struct counters counters;         /* summed over accepted results */
    struct counters counters_resumed; /* of these, of an earlier run of the coordinator; not kept */
#define STATISTIC(name, group, key, unit, merge, origin, text) uint64_t name;
#include "server/job/frame/statistic.def"
};

/* Keeps only costs: the rest is found again when the picture is drawn again. */
void statistics_forget_picture(struct statistics *s);

/* Adds up fields; peaks and errors are maxima. */
void statistics_add(struct statistics *sum, const struct statistics *more);

/* Adds what a block found of its pixels. */
void statistics_add_block(struct statistics *sum, const struct block_statistics *block);

/* Adds the CPU time of a block's filters. Returns their sum, in microseconds. */
uint64_t statistics_add_filters(struct statistics *sum, const struct block_statistics *block);

/* Writes an object for each group of the table, with cpu_s.total, and rays and skipped as
 * counter.def has them. Returns a new reference; NULL on failed allocation. */
json_t *statistics_json(const struct statistics *s);

/* Reads such an object, as far as its members are there: a job goes on counting after a restart. */
void statistics_read(const json_t *json, struct statistics *out);
