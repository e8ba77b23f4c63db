#pragma once
/* Internals of the tile tracer, for tile.c and tile_block.c alone. */
#include "worker/tile/lobe_view.h"
#include "worker/tile/mattes.h"
#include "worker/tile/stages.h"
#include "worker/tile/tile.h"
#include "worker/trace/field/edge_pixels.h"
#include "worker/trace/field/glossy.h"
#include "worker/trace/field/indirect.h"
#include "worker/trace/field/lens.h"
#include "worker/trace/field/lens_second_set.h"
#include "worker/trace/field/lone.h"
#include "worker/trace/field/mixed.h"
#include "worker/trace/field/shadow.h"
#include "worker/trace/hit/geometry.h"
#include "worker/trace/hit/primary.h"
#include "worker/trace/path/centre_gbuffer.h"
#include "worker/trace/path/path.h"
#include "worker/trace/path/path_sums.h"

struct tile_tracer {
    struct queries queries;
    struct light_table lights;
    struct path_vertex centre;
    struct path_vertex beside; /* at a sub-sample */
    struct lanes3 emission;    /* sum over centre and sub-samples */
    struct shading_point point;
    struct lanes_mask bouncing; /* lanes with bounce rays */
    struct block block;
    struct geometry_planes planes;          /* of the tile */
    struct primary_packet row[PRIMARY_ROW]; /* of this block and its neighbours in the row */
    struct RTCRayHit16 *seen;               /* of the block's centres */
    struct RTCRayHit16 camera;              /* of sub-samples */
    struct shadow_scratch shadow;
    struct indirect_scratch indirect;
    struct glossy_scratch glossy;
    struct half_field half;
    struct sky sky;
    struct photograph photograph;
    struct path_scratch path;
    struct path_sums sums;
    struct block edges;             /* pixels at edges that wait for their paths */
    struct lanes_mask beside_lamps; /* of these */
    struct lobe_view lobes;         /* of the tile, where stages skip paths */
    bool objects_only;              /* those are of virtual objects, and blocks beside them black */
    bool shows[PRIMARY_ROW];        /* which blocks of the row do not lie there */
    struct lens_scratch lens;
    struct centre_gbuffer centres;
    struct lens_second_set more;
    struct lone_scratch lone;
    struct mixed_scratch mixed;
    struct matte_scratch mattes;
};

/* Returns whether the block at (x, y) may show anything. */
bool tile_shows(const struct tile_tracer *tracer, int32_t x, int32_t y);

/* Returns whether the stages trace rays through the centres of all pixels. */
bool tile_sees_centres(const struct stages *stages);

/* Returns whether paths take most of the tile's time: its rows count as done with them. */
static inline bool tile_is_of_paths(const struct stages *stages)
{
    return stages->count > 0 && !stages->bounces && !stages->lights;
}

/* Counts the rows of the blocks at y as done. */
void tile_count_rows(const struct tile_job *job, int32_t y);

/* Traces the pass's paths of a tile, when its centres are there. `stop` may be NULL. ERR_MEMORY,
 * ERR_STATE when stopped. */
int tile_trace_paths(struct tile_tracer *tracer, const struct stages *stages,
                     const struct tile_job *job, struct samples *samples);

/* Traces the stages of tracer->block, but paths, into `samples`. `camera` holds the hits of its
 * centre rays if tile_sees_centres. */
void tile_trace_block(struct tile_tracer *tracer, const struct stages *stages,
                      const struct plan *plan, struct primary_packet *camera,
                      struct samples *samples, struct counters *counters);
