#pragma once
/* A frame that is made on a pool of threads, with its tiles' samples from formulas, and what is
 * told of it; the folder that its files go to. */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/job/job.h"
#include "server/job/frame/frame.h"
#include "tests/unit/server/reconstruct/filtered_case.h"
#include "tests/unit/server/reconstruct/synthetic_paths.h"
#include "tests/unit/unit.h"

struct bench {
    uv_loop_t loop;
    struct thread_pool *pool;
    struct objects objects;
    char dir[64];
    struct plan plan;
    uint32_t path_spp; /* 0: the light field */
    uint32_t beside;   /* filter of a light field beside the paths; 0: there is none */
    float target;      /* error; 0: none */
    bool rate;         /* bounce rays come in two sets */
    bool lobes;        /* and rays of glossy lobes */
    bool lens;         /* and its second sets of paths */
    bool unwatched;
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

int bench_set_up(void **state);

int bench_tear_down(void **state);

void begin(struct bench *b, int32_t tile_px);

/* Sends a tile's samples, `damage` bytes of them spoilt; the verdict, or 0 for a later one. */
uint32_t send_tile(struct bench *b, uint64_t worker, const struct fleet_tile *tile, size_t damage);

void run(struct bench *b);

bool lease(struct bench *b, uint64_t worker, uint32_t capabilities, struct fleet_tile *out);

/* Two workers that take turns and do as they should. */
void render_in_order(struct bench *b, int32_t tile_px);

void clear_counts(struct bench *b);
