#include "worker/sample_replay.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#include "proto/pattern_path.h"
#include "worker/stages.h"
#include "worker/trace/lane_kernels.h"

/* As tiles are traced. */
#define MXCSR_FLUSH 0x8040u

struct replay {
    struct queries queries;
    struct light_table lights;
    struct sky sky;
    struct counters counters;
    struct path_scratch path;
};

static int check(const struct plan *plan, const struct environment *environment, int32_t x,
                 int32_t y, uint32_t sample, struct fault *fault)
{
    const uint32_t most = plan->spp_most > plan->paths.spp ? plan->spp_most : plan->paths.spp;
    if (plan->paths.spp == 0)
        return fault_set(fault, ERR_UNSUPPORTED, "",
                         "the plan has no paths: light fields make "
                         "its picture (--method none asks for paths)");
    if (x < 0 || y < 0 || x >= plan->width_px || y >= plan->height_px)
        return fault_set(fault, ERR_RANGE, "pixel", "%d,%d is outside the image of %dx%d", x, y,
                         plan->width_px, plan->height_px);
    if (sample >= most)
        return fault_set(fault, ERR_RANGE, "sample", "%u: the plan has samples 0 to %u", sample,
                         most - 1);
    if (plan->environment.kind == ENVIRONMENT_MAP && !environment)
        return fault_set(fault, ERR_MISSING, "environment", "the plan has a map");
    return 0;
}

static void take(const struct path_rgb *from, size_t slot, float out[3])
{
    out[0] = from->r[slot];
    out[1] = from->g[slot];
    out[2] = from->b[slot];
}

/* As path_sums.c adds samples up, and refuses what is not finite. */
static void sum_up(const struct path_harvest *h, size_t slot, struct path_record *out)
{
    float white[2][3];
    take(&h->emission, slot, out->emission);
    take(&h->direct, slot, out->direct);
    take(&h->indirect, slot, out->indirect);
    take(&h->diffuse_direct, slot, white[0]);
    take(&h->diffuse_indirect, slot, white[1]);
    for (int k = 0; k < 3; k++) {
        const float parts[5] = {out->emission[k], out->direct[k], out->indirect[k], white[0][k],
                                white[1][k]};
        for (int i = 0; i < 5; i++) out->rejected |= !(parts[i] < INFINITY);
        out->radiance[k] = parts[0] + parts[1] + parts[2];
    }
    if (out->rejected) memset(out->radiance, 0, sizeof out->radiance);
}

static void find_position(const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                          float pixel[2])
{
    float u, v;
    path_pair(path_key(plan->pattern.seed, plan->pattern.frame, x, y), sample, PATH_PIXEL, &u, &v);
    pixel[0] = (float)x + path_pixel_offset(plan, u);
    pixel[1] = (float)y + path_pixel_offset(plan, v);
}

static void trace(struct replay *t, const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                  struct path_record *record)
{
    const struct plan_pass pass = plan_scheduled_pass(plan, 0);
    const struct path_context parts = {.queries = &t->queries,
                                       .lights = &t->lights,
                                       .sky = &t->sky,
                                       .plan = plan,
                                       .counters = &t->counters};
    struct stages stages;
    struct block block;
    size_t slot = 0;
    stages_init(&parts, NULL, &pass, &stages);
    stages.paths.record = record;
    block_init(&block, x & -LANES_ACROSS, y & -LANES_ACROSS, plan->width_px, plan->height_px,
               (struct rect){x, y, x + 1, y + 1});
    while (!block.kept.on[slot]) slot++;
    path_trace(&stages.paths, &block, sample, 1, &t->path);
    sum_up(&t->path.harvest, slot, record);
}

int sample_replay(const struct render_scene *scene, const struct environment *environment,
                  const struct plan *plan, int32_t x, int32_t y, uint32_t sample,
                  struct path_record *record, struct fault *fault)
{
    int e = check(plan, environment, x, y, sample, fault);
    if (e) return e;
    struct replay *t = aligned_alloc(LANES_ALIGN, sizeof *t);
    if (!t) return fault_set(fault, ERR_MEMORY, "", "%s", error_text(ERR_MEMORY));
    memset(t, 0, sizeof *t);
    memset(record, 0, sizeof *record);
    queries_init(&t->queries);
    path_scratch_init(&t->path);
    t->queries.scene = scene;
    t->queries.kernels = lane_kernels_for(scene->isa);
    const unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | MXCSR_FLUSH);
    light_table_init(&t->lights, plan, scene->emitters != NULL);
    sky_init(&t->sky, &plan->environment, environment);
    find_position(plan, x, y, sample, record->pixel);
    trace(t, plan, x, y, sample, record);
    _mm_setcsr(mode);
    free(t);
    return 0;
}
