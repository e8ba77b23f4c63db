#include "tests/property/picture_frame.h"

#include <stdlib.h>
#include <string.h>

#include "proto/count_map.h"
#include "server/job/frame/frame.h"
#include "worker/scene/environment.h"
#include "worker/tile/tile.h"

enum { POOL_THREADS = 2 };

struct session {
    const struct plan *plan;
    struct render_scene *scene;
    struct environment *environment; /* NULL: no map */
    struct tile_tracer *tracer;
    struct frame *frame;
    bool completed;
};

static _Noreturn void die(const char *what, int error)
{
    fprintf(stderr, "picture: %s (%d)\n", what, error);
    abort();
}

/* -- what the frame tells -- */

static void on_judged(void *ctx, struct frame *frame, uint64_t worker,
                      const struct message_ack *ack)
{
    (void)ctx, (void)worker;
    /* Samples that are not finite among others. */
    if (ack->verdict != VERDICT_ACCEPTED)
        die(frame_refusal(frame)->detail, frame_refusal(frame)->code);
}

static void on_drawn(void *ctx, struct frame *frame, struct rect rect)
{
    (void)ctx, (void)frame, (void)rect;
}

static void on_moved(void *ctx, struct frame *frame)
{
    (void)ctx, (void)frame;
}

static void on_completed(void *ctx, struct frame *frame)
{
    struct session *s = ctx;
    (void)frame;
    s->completed = true;
}

static void on_failed(void *ctx, struct frame *frame, const struct fault *fault)
{
    (void)ctx, (void)frame;
    die(fault->detail, fault->code);
}

/* -- the worker -- */

/* What a lease asks for, its strata maps unpacked as a worker does; these are the caller's. */
static struct plan_pass pass_of(const struct plan *plan, const struct fleet_tile *tile,
                                uint8_t **strata_maps)
{
    struct plan_pass pass = tile->pass;
    const uint32_t maps = plan_strata_maps(plan);
    const int32_t width = rect_width(tile->rect), height = rect_height(tile->rect);
    const size_t area = (size_t)rect_area(tile->rect);
    *strata_maps = NULL;
    if (pass.first + pass.count + pass.strata == 0) return plan_scheduled_pass(plan, pass.number);
    if (!tile->counts) return pass;
    *strata_maps = malloc(maps * area);
    if (!*strata_maps) abort();
    const int error =
        count_map_unpack(tile->counts, tile->counts_bytes, maps, width, height, *strata_maps);
    if (error) die("second sets do not unpack", error);
    pass.strata_map = *strata_maps;
    pass.lobes = maps > 1 ? *strata_maps + area : NULL;
    return pass;
}

static void trace(struct session *s, const struct fleet_tile *tile)
{
    struct message_result result = {
        .frame_id = tile->frame_id, .index = tile->index, .generation = tile->generation};
    struct samples *samples;
    struct bytes_writer w;
    uint8_t *strata_maps;
    const struct plan_pass pass = pass_of(s->plan, tile, &strata_maps);
    int error = plan_pass_check(s->plan, &pass);
    if (!error && pass.strata_map)
        error = plan_strata_map_check(&pass, (size_t)rect_area(tile->rect));
    if (error) die("a pass that no worker takes", error);
    error = tile_trace_pass(s->tracer,
                            &(struct tile_job){.scene = s->scene,
                                               .environment = s->environment,
                                               .plan = s->plan,
                                               .pass = &pass,
                                               .rect = tile->rect,
                                               .counters = &result.counters},
                            &samples);
    if (error) die("a tile cannot be traced", error);
    bytes_writer_init(&w);
    error = samples_pack(samples, PACKING_SMALL, &w, NULL);
    if (error) die("samples cannot be packed", error);
    samples_destroy(&samples);
    free(strata_maps);
    result.samples = w.data;
    result.samples_bytes = (uint32_t)w.size_bytes;
    const uint32_t verdict = frame_result(s->frame, 1, &result, &w.data, (uint32_t)w.size_bytes);
    if (verdict != 0) die("a result is refused at once", (int)verdict);
}

/* All that can be had now. */
static uint32_t lease(struct session *s, struct fleet_tile *tiles, uint32_t most)
{
    const struct worker_request request = {.worker = 1, .capabilities = ~0u, .is_free = true};
    uint32_t count = 0;
    while (count < most && frame_lease(s->frame, &request, &tiles[count])) count++;
    return count;
}

static void work(struct session *s, uv_loop_t *loop, bool backwards)
{
    const uint32_t most = frame_tile_count(s->frame);
    struct fleet_tile *tiles = calloc(most, sizeof *tiles);
    if (!tiles) abort();
    while (!s->completed) {
        const uint32_t count = lease(s, tiles, most);
        for (uint32_t i = 0; i < count; i++) trace(s, &tiles[backwards ? count - 1 - i : i]);
        uv_run(loop, UV_RUN_DEFAULT); /* until the pool has nothing left to do */
        if (count == 0 && !s->completed) die("the frame waits for nothing", ERR_STATE);
    }
    free(tiles);
}

/* -- the frame -- */

static void create(struct session *s, struct thread_pool *pool,
                   const struct picture_frame_options *options)
{
    char block[16];
    const struct frame_options frame = {.id = 1,
                                        .number = 1,
                                        .layers = options->layers,
                                        .plan = s->plan,
                                        .pool = pool,
                                        .kept = true, /* nobody wants its files */
                                        .events = {.ctx = s,
                                                   .judged = on_judged,
                                                   .drawn = on_drawn,
                                                   .extended = on_moved,
                                                   .traced = on_moved,
                                                   .completed = on_completed,
                                                   .failed = on_failed}};
    snprintf(block, sizeof block, "%d", options->block_px);
    setenv("SHEARWATER_BLOCK_PX", block, 1);
    const int error = frame_create(&frame, &s->frame);
    if (error) die("no frame", error);
}

static struct image *copy_of(const struct image *image, uint32_t layers)
{
    struct image *copy;
    const int error = image_create(layers, image->width_px, image->height_px, &copy);
    if (error) die("no image", error);
    memcpy(copy->data, image->data,
           (size_t)image->channel_count * (size_t)image->width_px * (size_t)image->height_px *
               sizeof *image->data);
    return copy;
}

void picture_frame_render(const struct plan *plan, const struct scene *scene,
                          const struct environment_blob *map,
                          const struct picture_frame_options *options, struct image **image,
                          struct statistics *statistics)
{
    struct session s = {.plan = plan};
    struct fault fault = {0};
    struct thread_pool *pool;
    uv_loop_t loop;
    int error = render_scene_create(scene, 1, NULL, &s.scene, &fault);
    if (error) die(fault.detail, error);
    if (map->header && environment_create(map, &s.environment)) die("no map", ERR_MEMORY);
    if (tile_tracer_create(&s.tracer)) die("no memory for a tracer", ERR_MEMORY);
    if (uv_loop_init(&loop)) die("no loop", ERR_MEMORY);
    error = thread_pool_create(&loop, "property", POOL_THREADS, NULL, &pool);
    if (error) die("no pool", error);
    create(&s, pool, options);
    work(&s, &loop, options->backwards);
    *image = copy_of(frame_image(s.frame), options->layers);
    *statistics = *frame_statistics(s.frame);
    frame_drop(&s.frame);
    thread_pool_destroy(&pool);
    uv_run(&loop, UV_RUN_DEFAULT);
    uv_loop_close(&loop);
    tile_tracer_destroy(&s.tracer);
    environment_destroy(&s.environment);
    render_scene_destroy(&s.scene);
}
