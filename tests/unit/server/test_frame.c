/* A frame from leases to stored files, with workers that behave and workers that do not: the files'
 * bytes must not tell the difference. */
#include <ftw.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "proto/count_map.h"
#include "proto/job.h"
#include "server/job/frame.h"
#include "server/reconstruct/scratch.h"
#include "tests/unit/server/filtered_case.h"
#include "tests/unit/server/synthetic_paths.h"

struct bench {
    uv_loop_t loop;
    struct team *team;
    struct objects objects;
    char dir[64];
    struct plan plan;
    uint32_t path_spp; /* 0: the light field */
    uint32_t beside;   /* filter of a light field beside the paths; 0: there is none */
    float target;      /* error; 0: none */
    bool rate;         /* bounce rays come in two sets */
    bool lobes;        /* and rays of glossy lobes */
    bool lens;         /* and its second sets of paths */
    unsigned extended;
    uint32_t filter;              /* of its shadows */
    uint32_t lights;              /* filtered ones and others */
    struct statistics statistics; /* of the last frame that was encoded */
    struct scratch *scratch;      /* of all frames; NULL: each has its own */
    struct frame *frame;
    unsigned accepted, corrupt, drawn, traced, encoded, failed;
    int64_t drawn_px;
    struct digest exr, png;
    struct fault fault;
};

static void on_judged(void *ctx, struct frame *frame, uint64_t worker,
                      const struct message_ack *ack)
{
    struct bench *b = ctx;
    (void)frame, (void)worker;
    if (ack->verdict == VERDICT_ACCEPTED)
        b->accepted++;
    else
        b->corrupt += ack->verdict == VERDICT_CORRUPT;
}

static void on_drawn(void *ctx, struct frame *frame, struct rect rect)
{
    struct bench *b = ctx;
    b->drawn++;
    b->drawn_px += rect_area(rect);
    assert_true(frame_revision(frame) == b->drawn);
}

static void on_extended(void *ctx, struct frame *frame)
{
    struct bench *b = ctx;
    assert_true(frame_tiles_landed(frame) < frame_tiles_total(frame));
    assert_true(frame_tiles_waiting(frame) > 0 && frame_traced_share(frame) < 1.0);
    b->extended++;
}

static void on_traced(void *ctx, struct frame *frame)
{
    struct bench *b = ctx;
    assert_int_equal(frame_tiles_landed(frame), frame_tiles_total(frame));
    assert_true(frame_traced_share(frame) == 1.0);
    b->traced++;
}

static void on_encoded(void *ctx, struct frame *frame, const struct digest *exr,
                       const struct digest *png)
{
    struct bench *b = ctx;
    assert_ptr_equal(frame, b->frame);
    assert_int_equal(frame_state(frame), FRAME_FINISHED);
    b->encoded++;
    b->statistics = *frame_statistics(frame);
    b->exr = *exr;
    b->png = *png;
    frame_drop(&b->frame);
}

static void on_failed(void *ctx, struct frame *frame, const struct fault *fault)
{
    struct bench *b = ctx;
    assert_ptr_equal(frame, b->frame);
    b->failed++;
    b->fault = *fault;
    frame_drop(&b->frame);
}

static int set_up(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    strcpy(b->dir, "/tmp/shearwater-frame-XXXXXX");
    return !mkdtemp(b->dir) || objects_open(&b->objects, b->dir) || uv_loop_init(&b->loop) ||
           team_create(&b->loop, "test", 3, &b->team);
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

static int tear_down(void **state)
{
    struct bench *b = *state;
    team_destroy(&b->team);
    uv_run(&b->loop, UV_RUN_DEFAULT);
    int error = uv_loop_close(&b->loop);
    nftw(b->dir, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    free(b);
    return error;
}

/* What light fields light is told of by second sets. */
static void lens_plan(struct plan *plan)
{
    plan->camera.aperture_radius = 0.1f;
    plan->camera.focus_distance = 4.0f;
    plan->planes = PLANES_LENS | PLANES_BOUNCE_LIGHT | PLANE_BIT(DEPTH) | PLANE_BIT(NORMAL) |
                   PLANE_BIT(ID) | PLANE_BIT(LENS_MORE);
    plan->light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    plan->sub_samples = 0;
    plan->indirect_strata_per_axis = 2;
    plan->lens_strata_per_axis = 3;
    plan->lens_filter = LENS_FILTER_SHEARED;
    plan->lens_light = LENS_LIGHT_DIFFUSE;
    plan->lens_extra = 9;
}

static void begin(struct bench *b, int32_t tile_px)
{
    struct frame_options options = {
        .id = 9,
        .number = 1,
        .layers = LAYER_BEAUTY | LAYER_NORMAL | (b->filter ? LAYER_FILTER_WIDTH : 0) |
                  (b->path_spp ? LAYER_SAMPLES : 0) | (b->beside ? LAYER_OCCLUSION : 0) |
                  (b->path_spp && !b->beside ? LAYER_ERROR : 0),
        .metadata = {.job = "feed", .build = "test", .spp = 9},
        .plan = &b->plan,
        .team = b->team,
        .scratch = b->scratch,
        .objects = &b->objects,
        .events = {.ctx = b,
                   .judged = on_judged,
                   .drawn = on_drawn,
                   .extended = on_extended,
                   .traced = on_traced,
                   .encoded = on_encoded,
                   .failed = on_failed}};
    b->drawn = 0;
    if (b->rate)
        synthetic_rate_plan(&b->plan, 75, 70, tile_px, b->path_spp);
    else if (b->target > 0.0f)
        synthetic_target_plan(&b->plan, 75, 70, tile_px, b->target);
    else if (b->beside)
        synthetic_beside_plan(&b->plan, 75, 70, tile_px, b->path_spp);
    else if (b->path_spp > 0)
        synthetic_paths_plan(&b->plan, 75, 70, tile_px, b->path_spp);
    else if (b->filter)
        filtered_plan(&b->plan, 203, 131, tile_px, b->filter, b->lights);
    else
        synthetic_plan(&b->plan, 203, 131, tile_px);
    if (!(b->target > 0.0f) && !b->rate) b->plan.indirect_filter = b->beside;
    if (b->lens) lens_plan(&b->plan);
    if (b->lobes) b->plan.planes |= PLANES_GLOSSY_LIGHT | PLANE_BIT(GLOSSY_SPAN);
    assert_int_equal(frame_create(&options, &b->frame), 0);
}

/* Nothing that its workers send has any light. */
static struct samples *empty_pass(const struct plan *plan, const struct fleet_tile *tile)
{
    struct samples_layout layout;
    struct samples *samples;
    assert_int_equal(samples_layout_init(&layout, plan, tile->pass.number, rect_width(tile->rect),
                                         rect_height(tile->rect)),
                     0);
    assert_int_equal(samples_create(&layout, &samples), 0);
    return samples;
}

/* Sends a tile's samples, `damage` bytes of them spoilt; the verdict, or 0 for a later one. */
static uint32_t send_tile(struct bench *b, uint64_t worker, const struct fleet_tile *tile,
                          size_t damage)
{
    struct bytes_writer w;
    static const struct filtered_world shelf = {.shelf_height = 1.5f, .shelf_half = 1.0f};
    struct plan_pass pass = tile->pass;
    if (pass.first + pass.count + pass.strata == 0)
        pass = plan_scheduled_pass(&b->plan, tile->pass.number);
    const bool rounds = b->target > 0.0f || b->rate;
    struct samples *samples = b->lens  ? empty_pass(&b->plan, tile)
                              : rounds ? synthetic_pass_of(&b->plan, tile->index, &pass)
                              : b->path_spp > 0
                                  ? synthetic_pass(&b->plan, tile->index, tile->pass.number)
                              : b->filter ? filtered_tile(&b->plan, &shelf, tile->index)
                                          : synthetic_tile(&b->plan, tile->index);
    uint64_t dropped = 0;
    bytes_writer_init(&w);
    assert_int_equal(samples_pack(samples, &w, &dropped), 0);
    samples_destroy(&samples);
    if (damage > 0) memset(w.data + w.size_bytes / 2, 0x5a, damage);
    struct message_result result = {.frame_id = tile->frame_id,
                                    .index = tile->index,
                                    .generation = tile->generation,
                                    .samples = w.data,
                                    .samples_bytes = (uint32_t)w.size_bytes};
    uint32_t verdict = frame_result(b->frame, worker, &result, &w.data, (uint32_t)w.size_bytes);
    free(w.data);
    return verdict;
}

static void run(struct bench *b)
{
    uv_run(&b->loop, UV_RUN_DEFAULT);
}

static bool lease(struct bench *b, uint64_t worker, uint32_t capabilities, struct fleet_tile *out)
{
    const struct fleet_asker asker = {
        .worker = worker, .capabilities = capabilities, .is_free = true};
    return frame_lease(b->frame, &asker, out);
}

/* Two workers that take turns and do as they should. */
static void render_in_order(struct bench *b, int32_t tile_px)
{
    struct fleet_tile tile;
    begin(b, tile_px);
    uint32_t total = frame_tiles_total(b->frame);
    for (uint64_t worker = 1; lease(b, worker, ~0u, &tile); worker ^= 3)
        assert_int_equal(send_tile(b, worker, &tile, 0), 0);
    run(b);
    assert_int_equal(b->accepted, total);
    assert_int_equal(b->encoded, 1);
    assert_int_equal(b->traced, 1);
    assert_int_equal(b->drawn_px, 203 * 131);
}

static bool is_nobodys(void *ctx, const struct digest *d)
{
    (void)ctx, (void)d;
    return true;
}

static void files_are_held_by_who_is_told_of_them(void **state)
{
    struct bench *b = *state;
    render_in_order(b, 64);
    const struct digest *const files[] = {&b->exr, &b->png};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(objects_remove(&b->objects, files[i], is_nobodys, NULL), ERR_STATE);
        objects_release(&b->objects, files[i]);
        assert_int_equal(objects_remove(&b->objects, files[i], is_nobodys, NULL), 0);
        assert_false(objects_have(&b->objects, files[i], NULL));
    }
}

static void tiles_of_any_size_give_the_same_files(void **state)
{
    struct bench *b = *state;
    render_in_order(b, 32);
    struct digest exr = b->exr, png = b->png;
    static const int32_t sizes[] = {8, 16, 64, 100, 256};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        b->accepted = b->encoded = b->traced = 0;
        b->drawn_px = 0;
        render_in_order(b, sizes[i]);
        assert_true(digest_equal(&exr, &b->exr));
        assert_true(digest_equal(&png, &b->png));
    }
    assert_true(objects_have(&b->objects, &exr, NULL) && objects_have(&b->objects, &png, NULL));
}

static void clear_counts(struct bench *b)
{
    b->accepted = b->encoded = b->traced = 0;
    b->drawn_px = 0;
}

static void filters_do_not_see_tiles(void **state)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 64, 100};
    b->lights = 3; /* two of them rectangles */
    for (b->filter = SHADOW_FILTER_AXIS_ALIGNED; b->filter <= SHADOW_FILTER_SHEARED; b->filter++) {
        clear_counts(b);
        render_in_order(b, 32);
        const struct digest exr = b->exr, png = b->png;
        const struct statistics first = b->statistics;
        assert_true(first.shadow_pixels_filtered > 1000);
        assert_true(first.shadow_pixels_filtered + first.shadow_pixels_alone +
                        first.shadow_pixels_unlit >=
                    2 * 203 * 131);
        assert_true(first.shadow_cpu_us > 0);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            clear_counts(b);
            render_in_order(b, sizes[i]);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(digest_equal(&png, &b->png));
            assert_true(b->statistics.shadow_pixels_filtered == first.shadow_pixels_filtered);
            assert_true(b->statistics.shadow_pixels_alone == first.shadow_pixels_alone);
            assert_true(b->statistics.shadow_pixels_unlit == first.shadow_pixels_unlit);
            assert_true(b->statistics.shadow_blocks_skipped == first.shadow_blocks_skipped);
        }
    }
}

/* Where no filter runs, none is counted. */
static void unfiltered_frames_count_nothing(void **state)
{
    struct bench *b = *state;
    render_in_order(b, 32);
    assert_true(b->statistics.reconstruct_cpu_us > 0);
    assert_true(b->statistics.shadow_cpu_us == 0);
    assert_true(b->statistics.shadow_pixels_filtered + b->statistics.shadow_pixels_alone +
                    b->statistics.shadow_pixels_unlit + b->statistics.shadow_blocks_skipped ==
                0);
}

/* Only a tile that nobody else has, and that has not landed, waits again. */
static void a_return_tells_whether_the_tile_waits(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile, copy;
    begin(b, 32);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_true(frame_copy(b->frame, 2, ~0u, &tile, &copy));
    assert_false(frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK)); /* the copy is under way */
    assert_true(frame_returned(b->frame, 2, &copy, FLEET_GIVEN_BACK));
    assert_false(frame_returned(b->frame, 2, &copy, FLEET_GIVEN_BACK));
    assert_true(lease(b, 1, ~0u, &tile));
    assert_true(frame_copy(b->frame, 2, ~0u, &tile, &copy));
    assert_int_equal(send_tile(b, 2, &copy, 0), 0);
    assert_false(frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK)); /* the copy was first */
    frame_drop(&b->frame);
}

static void bad_workers_change_nothing(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile, late = {0};
    render_in_order(b, 32);
    struct digest exr = b->exr;
    b->accepted = 0;
    begin(b, 32);
    uint32_t total = frame_tiles_total(b->frame);
    unsigned turn = 0;
    while (b->frame) {
        while (b->frame && lease(b, 1 + turn % 3, ~0u, &tile)) {
            uint64_t worker = 1 + turn % 3;
            switch (turn++ % 7) {
            case 0: /* dies, and its result comes late: after another has the tile, or before */
                frame_returned(b->frame, worker, &tile, FLEET_GIVEN_BACK);
                if (turn % 2) {
                    late = tile;
                    assert_true(lease(b, worker + 1, ~0u, &tile));
                    assert_int_equal(tile.index, late.index);
                    assert_int_equal(send_tile(b, worker, &late, 0), VERDICT_STALE);
                    assert_int_equal(send_tile(b, worker + 1, &tile, 0), 0);
                } else {
                    assert_int_equal(send_tile(b, worker + 9, &tile, 0), 0);
                }
                break;
            case 1: /* sends rubbish */
                assert_int_equal(send_tile(b, worker, &tile, 64), 0);
                break;
            case 2: /* cannot */
                frame_faulted(b->frame, worker,
                              &(struct message_tile_fault){.frame_id = 9,
                                                           .index = tile.index,
                                                           .generation = tile.generation,
                                                           .code = ERR_MEMORY});
                break;
            case 3: /* somebody else sends first, then twice */
                assert_int_equal(send_tile(b, worker + 1, &tile, 0), VERDICT_FOREIGN);
                assert_int_equal(send_tile(b, worker, &tile, 0), 0);
                assert_int_equal(send_tile(b, worker, &tile, 0), VERDICT_DUPLICATE);
                break;
            default:
                assert_int_equal(send_tile(b, worker, &tile, 0), 0);
            }
        }
        run(b);
    }
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->accepted, total);
    assert_true(b->corrupt > 0 && late.frame_id == 9);
    assert_true(digest_equal(&exr, &b->exr));
}

/* Workers that hold many tiles and send them in any order, while the loop runs now and then. */
static void render_paths(struct bench *b, int32_t tile_px, uint32_t spp)
{
    struct fleet_tile held[24];
    unsigned holding = 0;
    uint32_t seed = 11;
    double share = 0;
    b->accepted = b->encoded = b->traced = 0;
    b->path_spp = spp;
    begin(b, tile_px);
    const uint32_t passes = plan_pass_count(&b->plan), total = frame_tiles_total(b->frame);
    while (b->frame) {
        while (b->frame && holding < 24 && lease(b, 1, ~0u, &held[holding])) {
            assert_true(held[holding].pass.number < passes);
            holding++;
        }
        if (holding > 0) {
            seed = seed * 1664525u + 1013904223u;
            const unsigned at = (seed >> 8) % holding;
            assert_int_equal(send_tile(b, 1, &held[at], 0), 0);
            held[at] = held[--holding];
        }
        uv_run(&b->loop, holding == 0 || seed >> 30 == 0 ? UV_RUN_DEFAULT : UV_RUN_NOWAIT);
        if (!b->frame) break;
        assert_true(frame_traced_share(b->frame) >= share && frame_traced_share(b->frame) <= 1.0);
        share = frame_traced_share(b->frame);
        assert_true(share < 1.0 || frame_tiles_landed(b->frame) == total);
    }
    assert_int_equal(b->accepted, total);
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->encoded, 1);
    assert_int_equal(b->traced, 1);
    const unsigned blocks = b->beside ? 1 : 4; /* of 75 x 70 pixels */
    assert_in_range(b->drawn, blocks, blocks * passes);
}

static void passes_give_the_same_files_in_any_order(void **state)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 16, 40, 64, 256};
    render_paths(b, 32, 300);
    struct digest exr = b->exr, png = b->png;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        render_paths(b, sizes[i], 300);
        assert_true(digest_equal(&exr, &b->exr));
        assert_true(digest_equal(&png, &b->png));
    }
    render_paths(b, 32, 7); /* a single pass */
    render_paths(b, 32, 17);
}

/* A light field is there with the first pass and is filtered anew with each; it counts once. */
static void light_fields_beside_paths_do_not_see_tiles(void **state)
{
    struct bench *b = *state;
    static const int32_t sizes[] = {8, 40, 256};
    for (b->beside = INDIRECT_FILTER_CONSTANT; b->beside <= INDIRECT_FILTER_BLEND; b->beside++) {
        render_paths(b, 32, 100);
        const struct digest exr = b->exr;
        const struct statistics first = b->statistics;
        assert_true(first.indirect_pixels_filtered > 4000);
        assert_true(first.indirect_pixels_filtered + first.indirect_pixels_skipped == 75 * 70);
        assert_true(first.indirect_cpu_us > 0 && first.shadow_cpu_us == 0);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            render_paths(b, sizes[i], 100);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(b->statistics.indirect_pixels_filtered == first.indirect_pixels_filtered);
        }
    }
}

/* Bounce rays belong to the first pass. */
static void the_share_counts_bounce_rays(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 32;
    b->beside = INDIRECT_FILTER_CONSTANT;
    begin(b, 256);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    run(b);
    assert_true(frame_traced_share(b->frame) == 25.0 / 41.0);
    frame_drop(&b->frame);
    run(b);
}

/* Samples of the lens belong to the first pass, and second sets are to come. */
static void the_share_counts_lens_samples(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->lens = true;
    begin(b, 256);
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    while (b->accepted == 0) uv_run(&b->loop, UV_RUN_ONCE);
    /* 4 bounce rays and 9 samples of the lens, and 9 more in the mean */
    assert_true(frame_traced_share(b->frame) == 13.0 / 22.0);
    frame_drop(&b->frame);
    run(b);
}

/* Passes differ in length: the share counts samples. */
static void the_share_counts_samples(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 64;
    begin(b, 256);
    assert_int_equal(frame_tiles_total(b->frame), 3);
    for (uint32_t pass = 0; pass < 2; pass++) {
        assert_true(frame_traced_share(b->frame) == 0.25 * pass);
        assert_true(lease(b, 1, ~0u, &tile));
        assert_int_equal(tile.pass.number, pass);
        assert_int_equal(tile.generation, pass + 1);
        assert_int_equal(frame_tiles_waiting(b->frame), 0);
        assert_int_equal(send_tile(b, 1, &tile, 0), 0);
        assert_int_equal(send_tile(b, 1, &tile, 0), VERDICT_DUPLICATE);
        run(b);
        assert_int_equal(frame_tiles_waiting(b->frame), 1);
        assert_int_equal(send_tile(b, 1, &tile, 0), VERDICT_DUPLICATE);
    }
    assert_int_equal(frame_tiles_landed(b->frame), 2);
    assert_true(frame_traced_share(b->frame) == 0.5);
    assert_int_equal(b->encoded, 0);
    /* A result of another pass does not fit: it has planes that this one has not. */
    assert_true(lease(b, 1, ~0u, &tile));
    tile.pass.number = 0;
    assert_int_equal(send_tile(b, 1, &tile, 0), 0);
    run(b);
    assert_int_equal(b->corrupt, 1);
    frame_drop(&b->frame);
}

/* Workers that take turns, some of which fail, until the frame has its files. */
static void render_target(struct bench *b, bool badly, int32_t tile_px)
{
    struct fleet_tile held[16];
    unsigned holding = 0;
    uint32_t seed = 5;
    double share = 0.0;
    clear_counts(b);
    b->extended = 0;
    begin(b, tile_px);
    while (b->frame) {
        while (b->frame && holding < 16 && lease(b, 1, ~0u, &held[holding])) holding++;
        if (holding > 0) {
            seed = seed * 1664525u + 1013904223u;
            const unsigned at = badly ? (seed >> 8) % holding : 0;
            const struct fleet_tile tile = held[at];
            held[at] = held[--holding];
            if (badly && seed >> 29 == 1)
                frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK);
            else
                assert_int_equal(send_tile(b, 1, &tile, 0), 0);
        }
        uv_run(&b->loop, holding == 0 || !badly ? UV_RUN_DEFAULT : UV_RUN_NOWAIT);
        if (!b->frame) break;
        assert_true(frame_traced_share(b->frame) >= share && frame_traced_share(b->frame) < 1.0);
        share = frame_traced_share(b->frame);
    }
    assert_int_equal(b->failed, 0);
    assert_int_equal(b->encoded, 1);
    assert_int_equal(b->traced, 1);
}

static void targets_take_rounds(void **state)
{
    struct bench *b = *state;
    b->path_spp = 9;
    b->target = 0.05f;
    render_target(b, false, 16);
    const struct digest exr = b->exr;
    const struct statistics first = b->statistics;
    assert_true(b->extended > 0 && first.target_rounds == b->extended + 1);
    assert_true(first.target_error <= 50000 && first.target_error > 30000);
    assert_true(first.target_paths > 9 * 75 * 70 && first.target_threshold > 0);
    assert_true(first.indirect_pixels_filtered > 0);
    assert_true(first.indirect_pixels_filtered + first.indirect_pixels_skipped <= 4 * 75 * 70);
    render_target(b, true, 16);
    assert_true(digest_equal(&exr, &b->exr));
    assert_true(b->statistics.target_paths == first.target_paths);
    assert_true(b->statistics.target_error == first.target_error);
    b->target = 1000.0f; /* met at once */
    render_target(b, false, 16);
    assert_int_equal(b->extended, 0);
    assert_true(b->statistics.target_rounds == 1 && b->statistics.target_paths == 9 * 75 * 70);
}

/* Second sets of bounce rays: the files do not show who traced them, when, or in what tiles. */
static void second_sets_give_the_same_files(void **state)
{
    struct bench *b = *state;
    b->rate = true;
    for (b->path_spp = 0; b->path_spp <= 40; b->path_spp += 40) {
        render_target(b, false, 16);
        const struct digest exr = b->exr;
        const struct statistics first = b->statistics;
        assert_int_equal(b->extended, 1);
        assert_true(first.adaptive_first_rays > 16 * 4000 && first.adaptive_first_rays < 16 * 5250);
        assert_true(first.adaptive_second_rays > 0 &&
                    first.adaptive_second_rays <= 81 * first.adaptive_first_rays / 16);
        assert_true(first.indirect_pixels_filtered > 0);
        static const int32_t sizes[] = {16, 8, 33, 256};
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            render_target(b, true, sizes[i]);
            assert_true(digest_equal(&exr, &b->exr));
            assert_true(b->statistics.adaptive_second_rays == first.adaptive_second_rays);
            assert_true(b->statistics.adaptive_first_rays == first.adaptive_first_rays);
            assert_true(b->statistics.indirect_pixels_filtered == first.indirect_pixels_filtered);
        }
    }
    b->rate = false;
}

/* Leases of the second set carry what the tile's pixels get, as often as they are given. */
static void check_second_lease(struct bench *b, uint32_t maps)
{
    struct fleet_tile tile, again;
    uint8_t sides[2 * 32 * 32];
    assert_true(lease(b, 1, ~0u, &tile));
    assert_int_equal(plan_pass_check(&b->plan, &tile.pass), 0);
    const int32_t width = rect_width(tile.rect), height = rect_height(tile.rect);
    const size_t area = (size_t)width * (size_t)height;
    assert_int_equal(count_map_unpack(tile.counts, tile.counts_bytes, maps, width, height, sides),
                     0);
    assert_memory_equal(sides, tile.pass.sides, area);
    if (maps > 1)
        assert_memory_equal(sides + area, tile.pass.lobes, area);
    else
        assert_null(tile.pass.lobes);
    assert_int_equal(plan_sides_check(&tile.pass, area), 0);
    frame_returned(b->frame, 1, &tile, FLEET_GIVEN_BACK);
    assert_true(lease(b, 2, ~0u, &again));
    assert_true(again.index == tile.index && again.generation == tile.generation + 1);
    assert_memory_equal(again.counts, tile.counts, tile.counts_bytes);
}

static void leases_carry_second_sets(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    for (uint32_t maps = 1; maps <= 2; maps++) {
        b->rate = true;
        b->lobes = maps > 1;
        b->path_spp = 0;
        b->extended = 0;
        begin(b, 32);
        while (b->extended == 0) {
            while (lease(b, 1, ~0u, &tile)) {
                assert_true(tile.counts == NULL && tile.pass.sides == NULL);
                send_tile(b, 1, &tile, 0);
            }
            uv_run(&b->loop, UV_RUN_ONCE);
        }
        check_second_lease(b, maps);
        frame_drop(&b->frame);
        run(b);
    }
    b->rate = b->lobes = false;
}

/* Dropped while it decides, or in a later round. */
static void a_target_may_be_dropped(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->path_spp = 9;
    b->target = 0.05f;
    for (unsigned rounds = 0; rounds < 2; rounds++) {
        b->extended = 0;
        begin(b, 32);
        while (b->extended < rounds || frame_tiles_waiting(b->frame) > 0) {
            while (lease(b, 1, ~0u, &tile)) send_tile(b, 1, &tile, 0);
            uv_run(&b->loop, UV_RUN_ONCE);
            if (b->extended == rounds && frame_tiles_waiting(b->frame) == 0) break;
        }
        frame_drop(&b->frame);
        run(b);
    }
    assert_int_equal(b->failed, 0);
}

static void a_hopeless_tile_fails_the_frame(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 64);
    for (uint64_t worker = 1; worker <= 3; worker++) {
        assert_non_null(b->frame);
        assert_true(lease(b, worker, ~0u, &tile));
        struct message_tile_fault fault = {.frame_id = 9,
                                           .index = tile.index,
                                           .generation = tile.generation,
                                           .code = ERR_CORRUPT,
                                           .text = "the blob has no such mesh"};
        frame_faulted(b->frame, worker, &fault);
    }
    assert_int_equal(b->failed, 1);
    assert_null(b->frame);
    assert_int_equal(b->fault.code, ERR_CORRUPT);
    assert_non_null(strstr(b->fault.detail, "no such mesh"));
}

/* Dropped with work on the team: nothing more is told, nothing leaks. */
static void a_dropped_frame_is_silent(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 32);
    for (int i = 0; i < 12 && lease(b, 1, ~0u, &tile); i++) send_tile(b, 1, &tile, 0);
    frame_drop(&b->frame);
    run(b);
    assert_int_equal(b->accepted + b->drawn + b->encoded + b->failed, 0);
}

/* What one frame leaves in memory is not seen by the next, also where one was dropped in the midst
 * of its work, and memory may go at any time. */
static void frames_share_memory(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    b->lights = 3;
    b->filter = SHADOW_FILTER_SHEARED;
    render_in_order(b, 64);
    const struct digest exr = b->exr;
    assert_int_equal(scratch_create(&b->scratch), 0);
    for (int round = 0; round < 3; round++) {
        b->lens = round == 1; /* other arrays than the frame that is compared */
        begin(b, 64);
        for (int i = 0; i < 9 && lease(b, 1, ~0u, &tile); i++) send_tile(b, 1, &tile, 0);
        frame_drop(&b->frame);
        scratch_trim(b->scratch, round == 2 ? 0 : (size_t)1 << 20);
        b->lens = false;
        clear_counts(b);
        render_in_order(b, 64);
        assert_true(digest_equal(&exr, &b->exr));
    }
    scratch_destroy(&b->scratch);
}

static void capabilities_are_asked_for(void **state)
{
    struct bench *b = *state;
    struct fleet_tile tile;
    begin(b, 32);
    frame_drop(&b->frame);
    b->plan.capabilities = CAPABILITY_DIRECT | CAPABILITY_INDIRECT;
    struct frame_options options = {
        .id = 9, .layers = LAYER_BEAUTY, .plan = &b->plan, .team = b->team, .objects = &b->objects};
    assert_int_equal(frame_create(&options, &b->frame), 0);
    assert_false(lease(b, 1, CAPABILITY_DIRECT, &tile));
    assert_true(lease(b, 1, CAPABILITY_DIRECT | CAPABILITY_INDIRECT, &tile));
    frame_drop(&b->frame);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
        TEST(files_are_held_by_who_is_told_of_them),
        TEST(tiles_of_any_size_give_the_same_files),
        TEST(filters_do_not_see_tiles),
        TEST(unfiltered_frames_count_nothing),
        TEST(a_return_tells_whether_the_tile_waits),
        TEST(bad_workers_change_nothing),
        TEST(passes_give_the_same_files_in_any_order),
        TEST(the_share_counts_lens_samples),
        TEST(the_share_counts_samples),
        TEST(light_fields_beside_paths_do_not_see_tiles),
        TEST(the_share_counts_bounce_rays),
        TEST(targets_take_rounds),
        TEST(a_target_may_be_dropped),
        TEST(second_sets_give_the_same_files),
        TEST(leases_carry_second_sets),
        TEST(a_hopeless_tile_fails_the_frame),
        TEST(a_dropped_frame_is_silent),
        TEST(frames_share_memory),
        TEST(capabilities_are_asked_for),
    };
    return cmocka_run_group_tests_name("frame", tests, NULL, NULL);
}
