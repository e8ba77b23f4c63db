#pragma once
/* What a job cost: rays, skips, CPU time by stage, bytes. The numbers of --stats. */
#include <jansson.h>
#include <stdint.h>

#include "proto/counter.h"

struct statistics {
    struct counters counters;         /* summed over accepted results */
    struct counters counters_resumed; /* of these, of an earlier run of the coordinator; not kept */
    uint64_t import_cpu_us;
    uint64_t decode_cpu_us;      /* unpacking and checking samples */
    uint64_t reconstruct_cpu_us; /* without those below */
    uint64_t shadow_cpu_us;      /* filtering shadows */
    uint64_t indirect_cpu_us;    /* filtering indirect light and occlusion */
    uint64_t glossy_cpu_us;      /* filtering glossy lobes */
    uint64_t lens_cpu_us;        /* filtering lens samples */
    uint64_t lens_light_cpu_us;  /* lighting them by light fields */
    uint64_t encode_cpu_us;      /* EXR and PNG */
    uint64_t coordinate_cpu_us;  /* the loop's thread while the job was in work: all else */
    uint64_t wall_us;            /* from import to the last file */
    /* Wall time of frames: from when tiles can be given out until the files are stored; and from
     * the arrival of the last tile until all is drawn, and stored. */
    uint64_t frames_wall_us, drawn_late_us, stored_late_us;
    uint64_t bytes_received;                           /* samples as they came over the wire */
    uint64_t tiles_done, tiles_reissued, tiles_copied; /* each pass of a tile counts */
    uint64_t tiles_resumed;                            /* of those done: read from disk */
    uint64_t results_dropped;                          /* duplicate, stale, foreign */
    uint64_t results_corrupt;
    uint64_t sub_samples_lone, sub_samples_unmatched, pixels_background;
    /* By light, of shadow_statistics: what a filter did with pixels and blocks. */
    uint64_t shadow_pixels_filtered, shadow_pixels_alone, shadow_pixels_unlit;
    uint64_t shadow_blocks_skipped;
    /* Of indirect_statistics. */
    uint64_t indirect_pixels_filtered, indirect_pixels_skipped, indirect_blocks_skipped;
    /* Of glossy_statistics. */
    uint64_t glossy_pixels_filtered, glossy_pixels_skipped, glossy_blocks_skipped;
    /* Of lens_statistics. */
    uint64_t lens_pixels_filtered, lens_pixels_skipped, lens_blocks_skipped;
    uint64_t lens_samples_lit, lens_samples_own; /* of lens_light_statistics */
    uint64_t lens_second_paths;                  /* of second sets */
    /* Of frames with a target: rounds and samples of all of them; the largest estimated error that
     * was reached, and root of what a sample had to gain, both over mean luminance, in millionths.
     */
    uint64_t target_rounds, target_paths, target_bounces;
    uint64_t target_error, target_threshold;
    uint64_t adaptive_first_rays,
        adaptive_second_rays; /* bounce rays asked for, of adaptive rates */
    uint64_t server_peak_rss_bytes, worker_peak_rss_bytes;
};

/* Leaves only what work cost: what was found of the picture is found again when it is drawn again.
 */
void statistics_forget_picture(struct statistics *s);

/* Sums; peaks are maxima. */
void statistics_add(struct statistics *sum, const struct statistics *more);

/* {cpu_s {import, build, trace, pack, decode, reconstruct, shadow, indirect, glossy, lens,
 * lens_light, encode, coordinate, total}, wall_s, frames {wall_s, drawn_late_s, stored_late_s},
 * rays {...}, skipped {...}, tiles {done,
 * reissued, copied, resumed}, results {dropped, corrupt}, pixels {...}, shadow {pixels_filtered,
 * pixels_alone, pixels_unlit, blocks_skipped}, indirect {pixels_filtered, pixels_skipped,
 * blocks_skipped}, glossy {the same}, lens {the same, samples_lit, samples_own, second_paths},
 * target {rounds, paths, bounces, error, threshold}, adaptive {first_rays, second_rays},
 * bytes_received, peak_rss_bytes {server, worker}}. New reference; NULL on failed allocation. */
json_t *statistics_json(const struct statistics *s);

/* The other way, as far as the members are there: a job goes on counting after a restart. */
void statistics_read(const json_t *json, struct statistics *out);
