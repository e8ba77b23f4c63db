#pragma once
/* Decides when removals that had to wait are tried again (asset_removal_pass). The first try comes
 * a second after something may have begun to wait, later ones less and less often. A round may be
 * cut into passes. Each pass is followed by a rest of twenty times its length, because others want
 * the store, too.
 *
 * It runs on the loop's thread and does not keep the loop alive. */
#include <stdbool.h>
#include <uv.h>

#include "server/store/asset_removal.h"

/* Has a pass made; removal_timer_over follows, perhaps before it returns. */
typedef void (*removal_timer_due)(void *ctx);

struct removal_timer {
    uv_timer_t handle; /* its data is the caller's */
    uint64_t wait_ms;
    bool in_round, is_wanted; /* one is in work; another one is due after it */
    removal_timer_due due;
    void *ctx;
};

/* Initialises the timer. Its owner closes the handle. */
void removal_timer_init(struct removal_timer *t, uv_loop_t *loop, removal_timer_due due, void *ctx);
void removal_timer_soon(struct removal_timer *t);
void removal_timer_over(struct removal_timer *t, const struct removal_pass *pass);
