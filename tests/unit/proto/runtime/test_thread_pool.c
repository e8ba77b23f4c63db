/* The thread pool: order, completion on the loop's thread, CPU time, tools, both ways to end. */
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

#include "proto/error.h"
#include "proto/limits.h"
#include "proto/runtime/thread_pool.h"
#include "tests/unit/unit.h"

#define TASKS 500

struct probe {
    struct pool_task task;
    struct thread_pool *pool;
    int number;
    int ran;
    int done;
};

static pthread_t loop_thread;
static atomic_int runs;
static int completions;
static int order[TASKS];

static void run_probe(struct pool_task *task)
{
    struct probe *p = (struct probe *)task;
    p->ran++;
    atomic_fetch_add(&runs, 1);
}

static void probe_done(struct pool_task *task)
{
    struct probe *p = (struct probe *)task;
    assert_true(pthread_equal(pthread_self(), loop_thread));
    assert_int_equal(p->ran, 1);
    p->done++;
    order[completions++] = p->number;
}

static void start(uv_loop_t *loop, unsigned threads, struct thread_pool **pool)
{
    loop_thread = pthread_self();
    atomic_store(&runs, 0);
    completions = 0;
    assert_int_equal(uv_loop_init(loop), 0);
    assert_int_equal(thread_pool_create(loop, "test", threads, NULL, pool), 0);
}

static void stop(uv_loop_t *loop, struct thread_pool **pool)
{
    thread_pool_destroy(pool);
    assert_null(*pool);
    uv_run(loop, UV_RUN_DEFAULT);
    assert_int_equal(uv_loop_close(loop), 0);
}

TEST(every_task_runs_once_and_is_done_on_the_loop)
{
    static struct probe probes[TASKS];
    uv_loop_t loop;
    struct thread_pool *pool;
    start(&loop, 4, &pool);
    for (int i = 0; i < TASKS; i++) {
        probes[i] = (struct probe){.task = {.run = run_probe, .done = probe_done}, .number = i};
        thread_pool_submit(pool, &probes[i].task);
    }
    assert_int_equal(thread_pool_pending(pool), TASKS);
    uv_run(&loop, UV_RUN_DEFAULT); /* ends by itself when nothing is pending */
    assert_int_equal(thread_pool_pending(pool), 0);
    assert_int_equal(completions, TASKS);
    for (int i = 0; i < TASKS; i++) assert_int_equal(probes[i].done, 1);
    stop(&loop, &pool);
}

TEST(a_pool_of_one_keeps_the_order)
{
    static struct probe probes[TASKS];
    uv_loop_t loop;
    struct thread_pool *pool;
    start(&loop, 1, &pool);
    for (int i = 0; i < TASKS; i++) {
        probes[i] = (struct probe){.task = {.run = run_probe, .done = probe_done}, .number = i};
        thread_pool_submit(pool, &probes[i].task);
    }
    uv_run(&loop, UV_RUN_DEFAULT);
    for (int i = 0; i < TASKS; i++) assert_int_equal(order[i], i);
    stop(&loop, &pool);
}

static void burn(struct pool_task *task)
{
    (void)task;
    struct timespec t;
    do clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    while (t.tv_nsec < 20000000 && t.tv_sec == 0);
}

static void sleep_a_little(struct pool_task *task)
{
    (void)task;
    struct timespec t = {.tv_nsec = 30000000};
    nanosleep(&t, NULL);
}

TEST(cpu_time_counts_work_and_not_waiting)
{
    uv_loop_t loop;
    struct thread_pool *pool;
    struct pool_task busy = {.run = burn}, idle = {.run = sleep_a_little};
    start(&loop, 1, &pool);
    thread_pool_submit(pool, &busy);
    uv_run(&loop, UV_RUN_DEFAULT);
    thread_pool_submit(pool, &idle);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_true(busy.cpu_us >= 15000);
    assert_true(idle.cpu_us < 15000);
    stop(&loop, &pool);
}

/* A done function that submits the next task: destroy must see the chain to its end. */
static void chain_done(struct pool_task *task)
{
    struct probe *p = (struct probe *)task;
    completions++;
    if (++p->number < 5) thread_pool_submit(p->pool, &p->task);
}

TEST(destroy_finishes_what_is_queued)
{
    uv_loop_t loop;
    struct thread_pool *pool;
    start(&loop, 2, &pool);
    struct probe p = {.task = {.run = run_probe, .done = chain_done}, .pool = pool};
    thread_pool_submit(pool, &p.task);
    stop(&loop, &pool);
    assert_int_equal(completions, 5);
    assert_int_equal(atomic_load(&runs), 5);
}

TEST(a_pool_without_work_lets_the_loop_end)
{
    uv_loop_t loop;
    struct thread_pool *pool;
    start(&loop, 2, &pool);
    uv_run(&loop, UV_RUN_DEFAULT);
    stop(&loop, &pool);
}

/* -- tasks of a pool whose only thread is held up -- */

struct gate {
    struct pool_task task;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool entered, open;
};

static void pass_gate(struct pool_task *task)
{
    struct gate *g = (struct gate *)task;
    pthread_mutex_lock(&g->mutex);
    g->entered = true;
    pthread_cond_broadcast(&g->changed);
    while (!g->open) pthread_cond_wait(&g->changed, &g->mutex);
    pthread_mutex_unlock(&g->mutex);
}

/* Returns when the pool's thread stands at the gate. */
static void hold_up(struct thread_pool *pool, struct gate *g)
{
    *g = (struct gate){.task = {.run = pass_gate},
                       .mutex = PTHREAD_MUTEX_INITIALIZER,
                       .changed = PTHREAD_COND_INITIALIZER};
    thread_pool_submit(pool, &g->task);
    pthread_mutex_lock(&g->mutex);
    while (!g->entered) pthread_cond_wait(&g->changed, &g->mutex);
    pthread_mutex_unlock(&g->mutex);
}

static void let_through(struct gate *g)
{
    pthread_mutex_lock(&g->mutex);
    g->open = true;
    pthread_cond_broadcast(&g->changed);
    pthread_mutex_unlock(&g->mutex);
}

static void submit_probes(struct thread_pool *pool, struct probe *probes, int count)
{
    for (int i = 0; i < count; i++) {
        probes[i] = (struct probe){.task = {.run = run_probe, .done = probe_done}, .number = i};
        thread_pool_submit(pool, &probes[i].task);
    }
}

TEST(what_is_submitted_first_runs_next)
{
    struct probe probes[3], urgent = {.task = {.run = run_probe, .done = probe_done}, .number = 9};
    uv_loop_t loop;
    struct thread_pool *pool;
    struct gate gate;
    start(&loop, 1, &pool);
    hold_up(pool, &gate);
    submit_probes(pool, probes, 3);
    thread_pool_submit_first(pool, &urgent.task);
    let_through(&gate);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(completions, 4);
    assert_memory_equal(order, ((int[]){9, 0, 1, 2}), 4 * sizeof order[0]);
    stop(&loop, &pool);
}

/* From the front, the middle and the end of the queue; what is left still runs, and what comes
 * after. */
TEST(a_task_that_has_not_begun_is_taken_back)
{
    struct probe probes[5], later = {.task = {.run = run_probe, .done = probe_done}, .number = 5};
    uv_loop_t loop;
    struct thread_pool *pool;
    struct gate gate;
    start(&loop, 1, &pool);
    hold_up(pool, &gate);
    submit_probes(pool, probes, 5);
    assert_false(thread_pool_withdraw(pool, &gate.task));
    assert_int_equal(thread_pool_pending(pool), 6);
    assert_true(thread_pool_withdraw(pool, &probes[0].task));
    assert_true(thread_pool_withdraw(pool, &probes[2].task));
    assert_true(thread_pool_withdraw(pool, &probes[4].task));
    assert_false(thread_pool_withdraw(pool, &probes[4].task));
    assert_int_equal(thread_pool_pending(pool), 3);
    thread_pool_submit(pool, &later.task);
    let_through(&gate);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(thread_pool_pending(pool), 0);
    assert_int_equal(completions, 3);
    assert_memory_equal(order, ((int[]){1, 3, 5}), 3 * sizeof order[0]);
    stop(&loop, &pool);
}

TEST(the_last_task_taken_back_lets_the_loop_end)
{
    struct probe probe;
    uv_loop_t loop;
    struct thread_pool *pool;
    struct gate gate;
    start(&loop, 1, &pool);
    hold_up(pool, &gate);
    submit_probes(pool, &probe, 1);
    let_through(&gate);
    /* Begun or not: then it is done. */
    const bool taken = thread_pool_withdraw(pool, &probe.task);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(thread_pool_pending(pool), 0);
    assert_int_equal(completions, taken ? 0 : 1);
    stop(&loop, &pool);
}

/* -- tools -- */

struct bench {
    int created, destroyed, most;
    int tools[4];
};

static int create_tool(void *ctx, void **tool)
{
    struct bench *b = ctx;
    if (b->created == b->most) return ERR_UNSUPPORTED;
    *tool = &b->tools[b->created++];
    return 0;
}

static void destroy_tool(void *ctx, void **tool)
{
    struct bench *b = ctx;
    b->destroyed++;
    *tool = NULL;
}

/* Only its own thread writes to a tool. */
static void use_tool(struct pool_task *task)
{
    ++*(int *)task->tool;
}

TEST(each_thread_has_a_tool_of_its_own)
{
    static struct pool_task tasks[TASKS];
    struct bench b = {.most = 4};
    uv_loop_t loop;
    struct thread_pool *pool;
    assert_int_equal(uv_loop_init(&loop), 0);
    assert_int_equal(thread_pool_create(&loop, "test", 4,
                                        &(struct pool_tools){create_tool, destroy_tool, &b}, &pool),
                     0);
    assert_int_equal(b.created, 4);
    for (int i = 0; i < TASKS; i++) {
        tasks[i] = (struct pool_task){.run = use_tool};
        thread_pool_submit(pool, &tasks[i]);
    }
    stop(&loop, &pool);
    assert_int_equal(b.destroyed, 4);
    assert_int_equal(b.tools[0] + b.tools[1] + b.tools[2] + b.tools[3], TASKS);
}

TEST(a_pool_without_all_its_tools_is_none)
{
    struct bench b = {.most = 2};
    uv_loop_t loop;
    struct thread_pool *pool;
    assert_int_equal(uv_loop_init(&loop), 0);
    assert_int_equal(thread_pool_create(&loop, "test", 4,
                                        &(struct pool_tools){create_tool, destroy_tool, &b}, &pool),
                     ERR_UNSUPPORTED);
    assert_null(pool);
    assert_int_equal(b.created, 2);
    assert_int_equal(b.destroyed, 2);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(uv_loop_close(&loop), 0);
}

TEST(too_many_threads_are_refused)
{
    uv_loop_t loop;
    struct thread_pool *pool;
    assert_int_equal(uv_loop_init(&loop), 0);
    assert_int_equal(thread_pool_create(&loop, "test", LIMIT_THREADS + 1, NULL, &pool), ERR_LIMIT);
    assert_null(pool);
    assert_int_equal(uv_loop_close(&loop), 0);
}

/* -- signals, and the end without what is queued -- */

static atomic_int blocked;

static void look_at_mask(struct pool_task *task)
{
    sigset_t mask;
    (void)task;
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    atomic_store(&blocked, sigismember(&mask, SIGTERM) + 2 * sigismember(&mask, SIGCHLD));
}

TEST(signals_are_the_loops)
{
    sigset_t mask;
    uv_loop_t loop;
    struct thread_pool *pool;
    struct pool_task task = {.run = look_at_mask};
    atomic_store(&blocked, 0);
    start(&loop, 1, &pool);
    thread_pool_submit(pool, &task);
    stop(&loop, &pool);
    assert_int_equal(atomic_load(&blocked), 3);
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    assert_int_equal(sigismember(&mask, SIGTERM), 0);
}

static void count_closed(void *ctx)
{
    ++*(int *)ctx;
}

static void run_slowly(struct pool_task *task)
{
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    run_probe(task);
}

/* All of the queue would take a second: closing waits for the task that runs and no other. */
TEST(close_drops_what_is_queued)
{
    static struct probe probes[TASKS];
    uv_loop_t loop;
    struct thread_pool *pool;
    struct gate gate;
    int closed = 0;
    start(&loop, 1, &pool);
    hold_up(pool, &gate);
    for (int i = 0; i < TASKS; i++) {
        probes[i] = (struct probe){.task = {.run = run_slowly, .done = probe_done}};
        thread_pool_submit(pool, &probes[i].task);
    }
    let_through(&gate);
    thread_pool_close(&pool, count_closed, &closed);
    assert_null(pool);
    const int ran = atomic_load(&runs);
    assert_true(ran < TASKS);
    assert_int_equal(closed, 0);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_int_equal(closed, 1);
    assert_int_equal(completions, 0);
    assert_int_equal(atomic_load(&runs), ran);
    assert_int_equal(uv_loop_close(&loop), 0);
}
