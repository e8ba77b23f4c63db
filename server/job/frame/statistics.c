#include "server/job/frame/statistics.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

static uint64_t most(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

void statistics_add(struct statistics *sum, const struct statistics *more)
{
    counters_add(&sum->counters, &more->counters);
    counters_add(&sum->counters_resumed, &more->counters_resumed);
    sum->import_cpu_us += more->import_cpu_us;
    sum->decode_cpu_us += more->decode_cpu_us;
    sum->reconstruct_cpu_us += more->reconstruct_cpu_us;
    sum->shadow_cpu_us += more->shadow_cpu_us;
    sum->indirect_cpu_us += more->indirect_cpu_us;
    sum->glossy_cpu_us += more->glossy_cpu_us;
    sum->lens_cpu_us += more->lens_cpu_us;
    sum->lens_light_cpu_us += more->lens_light_cpu_us;
    sum->encode_cpu_us += more->encode_cpu_us;
    sum->coordinate_cpu_us += more->coordinate_cpu_us;
    sum->wall_us += more->wall_us;
    sum->frames_wall_us += more->frames_wall_us;
    sum->drawn_late_us += more->drawn_late_us;
    sum->stored_late_us += more->stored_late_us;
    sum->bytes_received += more->bytes_received;
    sum->tiles_done += more->tiles_done;
    sum->tiles_reissued += more->tiles_reissued;
    sum->tiles_copied += more->tiles_copied;
    sum->tiles_resumed += more->tiles_resumed;
    sum->results_dropped += more->results_dropped;
    sum->results_corrupt += more->results_corrupt;
    sum->sub_samples_lone += more->sub_samples_lone;
    sum->sub_samples_unmatched += more->sub_samples_unmatched;
    sum->pixels_background += more->pixels_background;
    sum->shadow_pixels_filtered += more->shadow_pixels_filtered;
    sum->shadow_pixels_alone += more->shadow_pixels_alone;
    sum->shadow_pixels_unlit += more->shadow_pixels_unlit;
    sum->shadow_blocks_skipped += more->shadow_blocks_skipped;
    sum->indirect_pixels_filtered += more->indirect_pixels_filtered;
    sum->indirect_pixels_skipped += more->indirect_pixels_skipped;
    sum->indirect_blocks_skipped += more->indirect_blocks_skipped;
    sum->glossy_pixels_filtered += more->glossy_pixels_filtered;
    sum->glossy_pixels_skipped += more->glossy_pixels_skipped;
    sum->glossy_blocks_skipped += more->glossy_blocks_skipped;
    sum->lens_pixels_filtered += more->lens_pixels_filtered;
    sum->lens_pixels_skipped += more->lens_pixels_skipped;
    sum->lens_blocks_skipped += more->lens_blocks_skipped;
    sum->lens_samples_lit += more->lens_samples_lit;
    sum->lens_samples_own += more->lens_samples_own;
    sum->target_rounds += more->target_rounds;
    sum->target_paths += more->target_paths;
    sum->target_bounces += more->target_bounces;
    sum->lens_second_paths += more->lens_second_paths;
    sum->adaptive_first_rays += more->adaptive_first_rays;
    sum->adaptive_second_rays += more->adaptive_second_rays;
    sum->target_error = most(sum->target_error, more->target_error);
    sum->target_threshold = most(sum->target_threshold, more->target_threshold);
    sum->server_peak_rss_bytes = most(sum->server_peak_rss_bytes, more->server_peak_rss_bytes);
    sum->worker_peak_rss_bytes = most(sum->worker_peak_rss_bytes, more->worker_peak_rss_bytes);
}

void statistics_forget_picture(struct statistics *s)
{
    *s = (struct statistics){.counters = s->counters,
                             .counters_resumed = s->counters_resumed,
                             .import_cpu_us = s->import_cpu_us,
                             .decode_cpu_us = s->decode_cpu_us,
                             .reconstruct_cpu_us = s->reconstruct_cpu_us,
                             .shadow_cpu_us = s->shadow_cpu_us,
                             .indirect_cpu_us = s->indirect_cpu_us,
                             .glossy_cpu_us = s->glossy_cpu_us,
                             .lens_cpu_us = s->lens_cpu_us,
                             .lens_light_cpu_us = s->lens_light_cpu_us,
                             .encode_cpu_us = s->encode_cpu_us,
                             .coordinate_cpu_us = s->coordinate_cpu_us,
                             .wall_us = s->wall_us,
                             .bytes_received = s->bytes_received,
                             .tiles_done = s->tiles_done,
                             .tiles_reissued = s->tiles_reissued,
                             .tiles_copied = s->tiles_copied,
                             .tiles_resumed = s->tiles_resumed,
                             .results_dropped = s->results_dropped,
                             .results_corrupt = s->results_corrupt,
                             .server_peak_rss_bytes = s->server_peak_rss_bytes,
                             .worker_peak_rss_bytes = s->worker_peak_rss_bytes};
}

/* Where each number lies in the JSON: one table for both ways. */
struct line {
    const char *group, *key; /* group NULL: at the top */
    size_t offset;
    bool millionths; /* here, of a second or of one */
};
#define COUNTED(name)                                                                              \
    offsetof(struct statistics, counters.value) + sizeof(uint64_t) * COUNTER_##name
#define FIELD(name) offsetof(struct statistics, name)

static const struct line lines[] = {
    {"cpu_s", "import", FIELD(import_cpu_us), true},
    {"cpu_s", "build", COUNTED(BUILD_CPU_US), true},
    {"cpu_s", "trace", COUNTED(TRACE_CPU_US), true},
    {"cpu_s", "pack", COUNTED(PACK_CPU_US), true},
    {"cpu_s", "decode", FIELD(decode_cpu_us), true},
    {"cpu_s", "reconstruct", FIELD(reconstruct_cpu_us), true},
    {"cpu_s", "shadow", FIELD(shadow_cpu_us), true},
    {"cpu_s", "indirect", FIELD(indirect_cpu_us), true},
    {"cpu_s", "glossy", FIELD(glossy_cpu_us), true},
    {"cpu_s", "lens", FIELD(lens_cpu_us), true},
    {"cpu_s", "lens_light", FIELD(lens_light_cpu_us), true},
    {"cpu_s", "encode", FIELD(encode_cpu_us), true},
    {"cpu_s", "coordinate", FIELD(coordinate_cpu_us), true},
    {NULL, "wall_s", FIELD(wall_us), true},
    {"frames", "wall_s", FIELD(frames_wall_us), true},
    {"frames", "drawn_late_s", FIELD(drawn_late_us), true},
    {"frames", "stored_late_s", FIELD(stored_late_us), true},
    {"tiles", "done", FIELD(tiles_done), false},
    {"tiles", "reissued", FIELD(tiles_reissued), false},
    {"tiles", "copied", FIELD(tiles_copied), false},
    {"tiles", "resumed", FIELD(tiles_resumed), false},
    {"results", "dropped", FIELD(results_dropped), false},
    {"results", "corrupt", FIELD(results_corrupt), false},
    {"pixels", "background", FIELD(pixels_background), false},
    {"pixels", "sub_samples_lone", FIELD(sub_samples_lone), false},
    {"pixels", "sub_samples_unmatched", FIELD(sub_samples_unmatched), false},
    {"shadow", "pixels_filtered", FIELD(shadow_pixels_filtered), false},
    {"shadow", "pixels_alone", FIELD(shadow_pixels_alone), false},
    {"shadow", "pixels_unlit", FIELD(shadow_pixels_unlit), false},
    {"shadow", "blocks_skipped", FIELD(shadow_blocks_skipped), false},
    {"indirect", "pixels_filtered", FIELD(indirect_pixels_filtered), false},
    {"indirect", "pixels_skipped", FIELD(indirect_pixels_skipped), false},
    {"indirect", "blocks_skipped", FIELD(indirect_blocks_skipped), false},
    {"glossy", "pixels_filtered", FIELD(glossy_pixels_filtered), false},
    {"glossy", "pixels_skipped", FIELD(glossy_pixels_skipped), false},
    {"glossy", "blocks_skipped", FIELD(glossy_blocks_skipped), false},
    {"lens", "pixels_filtered", FIELD(lens_pixels_filtered), false},
    {"lens", "pixels_skipped", FIELD(lens_pixels_skipped), false},
    {"lens", "blocks_skipped", FIELD(lens_blocks_skipped), false},
    {"lens", "samples_lit", FIELD(lens_samples_lit), false},
    {"lens", "samples_own", FIELD(lens_samples_own), false},
    {"lens", "second_paths", FIELD(lens_second_paths), false},
    {"target", "rounds", FIELD(target_rounds), false},
    {"target", "paths", FIELD(target_paths), false},
    {"target", "bounces", FIELD(target_bounces), false},
    {"target", "error", FIELD(target_error), true},
    {"target", "threshold", FIELD(target_threshold), true},
    {"adaptive", "first_rays", FIELD(adaptive_first_rays), false},
    {"adaptive", "second_rays", FIELD(adaptive_second_rays), false},
    {NULL, "bytes_received", FIELD(bytes_received), false},
    {"peak_rss_bytes", "server", FIELD(server_peak_rss_bytes), false},
    {"peak_rss_bytes", "worker", FIELD(worker_peak_rss_bytes), false},
};
#define LINE_COUNT (sizeof lines / sizeof lines[0])

static uint64_t get(const struct statistics *s, const struct line *line)
{
    uint64_t value;
    memcpy(&value, (const char *)s + line->offset, sizeof value);
    return value;
}

static json_t *group_of(json_t *root, const char *name)
{
    json_t *group = json_object_get(root, name);
    if (group) return group;
    json_object_set_new(root, name, json_object());
    return json_object_get(root, name);
}

/* Counters of the groups rays and skipped stand under their own keys; times are lines above. */
static bool is_listed(enum counter_id id)
{
    return strcmp(counter_group(id), "time") != 0;
}

json_t *statistics_json(const struct statistics *s)
{
    json_t *root = json_object();
    uint64_t total_us = 0;
    for (size_t i = 0; i < LINE_COUNT; i++) {
        const struct line *line = &lines[i];
        uint64_t value = get(s, line);
        json_t *into = line->group ? group_of(root, line->group) : root;
        json_object_set_new(into, line->key,
                            line->millionths ? json_real((double)value * 1e-6)
                                             : json_integer((json_int_t)value));
        if (line->group && !strcmp(line->group, "cpu_s")) total_us += value;
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
    for (size_t i = 0; i < LINE_COUNT; i++) {
        const struct line *line = &lines[i];
        const json_t *from = line->group ? json_object_get(json, line->group) : json;
        uint64_t value = number_of(json_object_get(from, line->key), line->millionths ? 1e6 : 1);
        memcpy((char *)out + line->offset, &value, sizeof value);
    }
    for (unsigned i = 0; i < COUNTER_COUNT; i++) {
        const json_t *group = json_object_get(json, counter_group((enum counter_id)i));
        if (is_listed((enum counter_id)i))
            out->counters.value[i] =
                number_of(json_object_get(group, counter_key((enum counter_id)i)), 1);
    }
}
