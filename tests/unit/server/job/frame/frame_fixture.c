#include "tests/unit/server/job/frame/frame_fixture.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

int bench_set_up(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    *state = b;
    strcpy(b->dir, "/tmp/shearwater-frame-XXXXXX");
    return !mkdtemp(b->dir) || objects_open(&b->objects, b->dir, false) || uv_loop_init(&b->loop) ||
           thread_pool_create(&b->loop, "test", 3, NULL, &b->pool);
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

int bench_tear_down(void **state)
{
    struct bench *b = *state;
    thread_pool_destroy(&b->pool);
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
                   PLANE_BIT(ID) | PLANE_BIT(LENS_SECOND_SET);
    plan->light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    plan->sub_samples = 0;
    plan->indirect_strata_per_axis = 2;
    plan->lens_strata_per_axis = 3;
    plan->lens_filter = LENS_FILTER_SHEARED;
    plan->lens_relight = LENS_RELIGHT_DIFFUSE;
    plan->lens_extra = 9;
}

void begin(struct bench *b, int32_t tile_px)
{
    struct frame_options options = {
        .id = 9,
        .number = 1,
        .layers = LAYER_BEAUTY | LAYER_NORMAL | (b->filter ? LAYER_FILTER_WIDTH : 0) |
                  (b->path_spp ? LAYER_SAMPLES : 0) | (b->beside ? LAYER_OCCLUSION : 0) |
                  (b->path_spp && !b->beside ? LAYER_ERROR : 0),
        .metadata = {.job = "feed", .build = "test", .spp = 9},
        .plan = &b->plan,
        .pool = b->pool,
        .scratch = b->scratch,
        .objects = &b->objects,
        .unwatched = b->unwatched,
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

uint32_t send_tile(struct bench *b, uint64_t worker, const struct fleet_tile *tile, size_t damage)
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
    assert_int_equal(samples_pack(samples, PACKING_QUICK, &w, &dropped), 0);
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

void run(struct bench *b)
{
    uv_run(&b->loop, UV_RUN_DEFAULT);
}

bool lease(struct bench *b, uint64_t worker, uint32_t capabilities, struct fleet_tile *out)
{
    const struct worker_request request = {
        .worker = worker, .capabilities = capabilities, .is_free = true};
    return frame_lease(b->frame, &request, out);
}

void render_in_order(struct bench *b, int32_t tile_px)
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

void clear_counts(struct bench *b)
{
    b->accepted = b->encoded = b->traced = 0;
    b->drawn_px = 0;
}
