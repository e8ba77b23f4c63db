#include "server/store/removal_timer.h"

#include <assert.h>

#define FIRST_MS 1000
#define MOST_MS  16000
#define CUT_MS   400 /* at least, between passes of one round */
#define RESTS    20  /* times as long as a pass */

static void on_due(uv_timer_t *handle);

static void start(struct removal_timer *t, uint64_t ms)
{
    if (uv_is_closing((uv_handle_t *)&t->handle)) return;
    uv_timer_start(&t->handle, on_due, ms, 0);
}

static void on_due(uv_timer_t *handle)
{
    struct removal_timer *t = (struct removal_timer *)handle; /* its first member */
    if (!t->in_round) t->is_wanted = false;
    t->in_round = true;
    t->due(t->ctx);
}

void removal_timer_init(struct removal_timer *t, uv_loop_t *loop, removal_timer_due due, void *ctx)
{
    *t = (struct removal_timer){.wait_ms = FIRST_MS, .due = due, .ctx = ctx};
    int error = uv_timer_init(loop, &t->handle);
    assert(error == 0); /* neither allocates nor asks the kernel */
    (void)error;
    uv_unref((uv_handle_t *)&t->handle);
}

void removal_timer_soon(struct removal_timer *t)
{
    t->wait_ms = FIRST_MS;
    t->is_wanted = true;
    if (t->in_round) return;
    if (!uv_is_active((uv_handle_t *)&t->handle) || uv_timer_get_due_in(&t->handle) > FIRST_MS)
        start(t, FIRST_MS);
}

void removal_timer_over(struct removal_timer *t, const struct removal_pass *pass)
{
    const uint64_t rest_ms = pass->took_us * RESTS / 1000;
    t->in_round = pass->is_cut;
    if (pass->is_cut) {
        start(t, rest_ms > CUT_MS ? rest_ms : CUT_MS);
    } else if (pass->left > 0 || t->is_wanted) {
        start(t, rest_ms > t->wait_ms ? rest_ms : t->wait_ms);
        t->wait_ms = t->wait_ms < MOST_MS / 2 ? 2 * t->wait_ms : MOST_MS;
    }
}
