/* Statistics: what stays of them, what is added up, and that openapi.yaml tells of every one. The
 * working directory is the repository. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/counter.h"
#include "server/job/frame/statistics.h"
#include "server/reconstruct/compose/block_statistics.h"
#include "tests/unit/unit.h"

#define PATH "proto/openapi.yaml"

static void fill(void *numbers, size_t size_bytes, uint64_t first)
{
    uint64_t *words = numbers;
    for (size_t i = 0; i < size_bytes / sizeof *words; i++) words[i] = first + 17 * i;
}

TEST(survive_json)
{
    struct statistics in, out;
    fill(&in, sizeof in, 1000);
    memset(&in.counters_resumed, 0,
           sizeof in.counters_resumed); /* about this run alone: not kept */
    json_t *json = statistics_json(&in);
    assert_non_null(json);
    assert_true(json_is_real(json_object_get(json_object_get(json, "cpu_s"), "total")));
    assert_int_equal(json_integer_value(json_object_get(json_object_get(json, "rays"), "shadow")),
                     in.counters.value[COUNTER_RAYS_SHADOW]);
    statistics_read(json, &out);
    assert_memory_equal(&in, &out, sizeof in);
    json_decref(json);
    statistics_read(NULL, &out);
    assert_int_equal(out.tiles_done, 0);
}

TEST(add_up_but_for_peaks)
{
    struct statistics sum, more;
    fill(&sum, sizeof sum, 1000);
    fill(&more, sizeof more, 3);
    const struct statistics before = sum;
    statistics_add(&sum, &more);
    assert_int_equal(sum.counters.value[COUNTER_PATHS],
                     before.counters.value[COUNTER_PATHS] + more.counters.value[COUNTER_PATHS]);
    assert_int_equal(sum.decode_cpu_us, before.decode_cpu_us + more.decode_cpu_us);
    assert_int_equal(sum.lens_samples_own, before.lens_samples_own + more.lens_samples_own);
    assert_int_equal(sum.target_error, before.target_error);
    assert_int_equal(sum.target_threshold, before.target_threshold);
    assert_int_equal(sum.server_peak_rss_bytes, before.server_peak_rss_bytes);
    more.worker_peak_rss_bytes = before.worker_peak_rss_bytes + 1;
    statistics_add(&sum, &more);
    assert_int_equal(sum.worker_peak_rss_bytes, more.worker_peak_rss_bytes);
}

TEST(of_a_picture_that_is_dropped_the_cost_stays)
{
    struct statistics s;
    fill(&s, sizeof s, 1000);
    const struct statistics before = s;
    statistics_forget_picture(&s);
    assert_memory_equal(&s.counters, &before.counters, sizeof s.counters);
    assert_memory_equal(&s.counters_resumed, &before.counters_resumed, sizeof s.counters);
    assert_int_equal(s.lens_relight_cpu_us, before.lens_relight_cpu_us);
    assert_int_equal(s.tiles_done, before.tiles_done);
    assert_int_equal(s.bytes_received, before.bytes_received);
    assert_int_equal(s.worker_peak_rss_bytes, before.worker_peak_rss_bytes);
    assert_int_equal(s.frames_wall_us, 0);
    assert_int_equal(s.pixels_background, 0);
    assert_int_equal(s.shadow_blocks_skipped, 0);
    assert_int_equal(s.target_error, 0);
    assert_int_equal(s.adaptive_second_rays, 0);
}

TEST(take_up_blocks)
{
    struct block_statistics block;
    struct statistics s = {.lens_samples_lit = 5, .glossy_cpu_us = 7};
    fill(&block, sizeof block, 1000);
    statistics_add_block(&s, &block);
    assert_int_equal(s.pixels_background, block.pixels_background);
    assert_int_equal(s.shadow_pixels_alone, block.shadow.pixels_alone);
    assert_int_equal(s.indirect_blocks_skipped, block.indirect.blocks_skipped);
    assert_int_equal(s.lens_samples_lit, 5 + block.lens_relight.samples_lit);
    assert_int_equal(s.glossy_cpu_us, 7);
    assert_int_equal(statistics_add_filters(&s, &block),
                     block.shadow_cpu_us + block.indirect_cpu_us + block.glossy_cpu_us +
                         block.lens_cpu_us + block.lens_relight_cpu_us + block.residual_cpu_us);
    assert_int_equal(s.residual_pixels_filtered, block.residual.pixels);
    assert_int_equal(s.glossy_cpu_us, 7 + block.glossy_cpu_us);
    assert_int_equal(s.shadow_pixels_alone, block.shadow.pixels_alone);
    assert_int_equal(s.tiles_done, 0);
}

/* The lines of openapi.yaml's schema Statistics. */
static char *read_schema(void)
{
    FILE *file = fopen(PATH, "rb");
    char *page = calloc(1, 262144);
    assert_non_null(file);
    assert_non_null(page);
    const size_t size_bytes = fread(page, 1, 262143, file);
    fclose(file);
    assert_in_range(size_bytes, 1, 262142);
    char *schema = strstr(page, "\n    Statistics:\n");
    assert_non_null(schema);
    char *end = strstr(schema + 1, "\n    Region:\n");
    assert_non_null(end);
    memmove(page, schema, (size_t)(end - schema));
    page[end - schema] = '\0';
    return page;
}

/* The line of group.key is there; its start is cut out of the schema, so that what is left in the
 * end is of no number. */
static void expect(char *schema, const char *group, const char *key, const char *type,
                   const char *text)
{
    char line[512];
    char *from = schema;
    if (*group) {
        snprintf(line, sizeof line, "\n        %s:\n", group);
        from = strstr(schema, line);
        if (!from) fail_msg("%s has no statistics.%s", PATH, group);
        from += strlen(line) - 1;
    }
    snprintf(line, sizeof line, "\n%s%s: {type: %s, minimum: 0, description: \"%s\"}",
             *group ? "            " : "        ", key, type, text);
    char *found = strstr(from, line), *next = strstr(from, ":\n          type: object");
    if (!found || (next && *group && found > next))
        fail_msg("%s, statistics.%s does not say:%s", PATH, group, line);
    memset(found + 1, '#', strlen(line) - 1);
}

#define TYPE_seconds  "number"
#define TYPE_fraction "number"
#define TYPE_count    "integer"
#define TYPE_bytes    "integer"

TEST(are_those_of_the_contract)
{
    char *schema = read_schema();
#define STATISTIC(name, group, key, unit, merge, origin, text)                                     \
    expect(schema, group, key, TYPE_##unit, text);
#define COUNTED(counter, group, key, text) expect(schema, group, key, "number", text);
#include "server/job/frame/statistic.def"
    expect(schema, "cpu_s", "total", "number", "sum of all stages");
    for (unsigned i = 0; i < COUNTER_COUNT; i++)
        if (strcmp(counter_group(i), "time") != 0)
            expect(schema, counter_group(i), counter_key(i), "integer", counter_text(i));
    const char *unknown = strstr(schema, ": {");
    if (unknown) fail_msg("%s tells of what the server does not: %.60s", PATH, unknown - 20);
    free(schema);
}
