/* The thread team: order, completion on the loop's thread, CPU time, shutdown. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

#include "server/team/team.h"

#define TASKS 500

struct probe {
    struct team_task task;
    struct team *team;
    int number;
    int ran;
    int done;
};

static pthread_t loop_thread;
static atomic_int runs;
static int completions;
static int order[TASKS];

static void run_probe(struct team_task *task)
{
    struct probe *p = (struct probe *)task;
    p->ran++;
    atomic_fetch_add(&runs, 1);
}

static void probe_done(struct team_task *task)
{
    struct probe *p = (struct probe *)task;
    assert_true(pthread_equal(pthread_self(), loop_thread));
    assert_int_equal(p->ran, 1);
    p->done++;
    order[completions++] = p->number;
}

static void start(uv_loop_t *loop, unsigned threads, struct team **team)
{
    loop_thread = pthread_self();
    atomic_store(&runs, 0);
    completions = 0;
    assert_int_equal(uv_loop_init(loop), 0);
    assert_int_equal(team_create(loop, "test", threads, team), 0);
}

static void stop(uv_loop_t *loop, struct team **team)
{
    team_destroy(team);
    assert_null(*team);
    uv_run(loop, UV_RUN_DEFAULT);
    assert_int_equal(uv_loop_close(loop), 0);
}

static void every_task_runs_once_and_is_done_on_the_loop(void **state)
{
    (void)state;
    static struct probe probes[TASKS];
    uv_loop_t loop;
    struct team *team;
    start(&loop, 4, &team);
    for (int i = 0; i < TASKS; i++) {
        probes[i] = (struct probe){.task = {.run = run_probe, .done = probe_done}, .number = i};
        team_submit(team, &probes[i].task);
    }
    assert_int_equal(team_pending(team), TASKS);
    uv_run(&loop, UV_RUN_DEFAULT); /* ends by itself when nothing is pending */
    assert_int_equal(team_pending(team), 0);
    assert_int_equal(completions, TASKS);
    for (int i = 0; i < TASKS; i++) assert_int_equal(probes[i].done, 1);
    stop(&loop, &team);
}

static void a_team_of_one_keeps_the_order(void **state)
{
    (void)state;
    static struct probe probes[TASKS];
    uv_loop_t loop;
    struct team *team;
    start(&loop, 1, &team);
    for (int i = 0; i < TASKS; i++) {
        probes[i] = (struct probe){.task = {.run = run_probe, .done = probe_done}, .number = i};
        team_submit(team, &probes[i].task);
    }
    uv_run(&loop, UV_RUN_DEFAULT);
    for (int i = 0; i < TASKS; i++) assert_int_equal(order[i], i);
    stop(&loop, &team);
}

static void burn(struct team_task *task)
{
    (void)task;
    struct timespec t;
    do clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    while (t.tv_nsec < 20000000 && t.tv_sec == 0);
}

static void sleep_a_little(struct team_task *task)
{
    (void)task;
    struct timespec t = {.tv_nsec = 30000000};
    nanosleep(&t, NULL);
}

static void cpu_time_counts_work_and_not_waiting(void **state)
{
    (void)state;
    uv_loop_t loop;
    struct team *team;
    struct team_task busy = {.run = burn}, idle = {.run = sleep_a_little};
    start(&loop, 1, &team);
    team_submit(team, &busy);
    uv_run(&loop, UV_RUN_DEFAULT);
    team_submit(team, &idle);
    uv_run(&loop, UV_RUN_DEFAULT);
    assert_true(busy.cpu_us >= 15000);
    assert_true(idle.cpu_us < 15000);
    stop(&loop, &team);
}

/* A done function that submits the next task: destroy must see the chain to its end. */
static void chain_done(struct team_task *task)
{
    struct probe *p = (struct probe *)task;
    completions++;
    if (++p->number < 5) team_submit(p->team, &p->task);
}

static void destroy_finishes_what_is_queued(void **state)
{
    (void)state;
    uv_loop_t loop;
    struct team *team;
    start(&loop, 2, &team);
    struct probe p = {.task = {.run = run_probe, .done = chain_done}, .team = team};
    team_submit(team, &p.task);
    stop(&loop, &team);
    assert_int_equal(completions, 5);
    assert_int_equal(atomic_load(&runs), 5);
}

static void a_team_without_work_lets_the_loop_end(void **state)
{
    (void)state;
    uv_loop_t loop;
    struct team *team;
    start(&loop, 2, &team);
    uv_run(&loop, UV_RUN_DEFAULT);
    stop(&loop, &team);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_task_runs_once_and_is_done_on_the_loop),
        cmocka_unit_test(a_team_of_one_keeps_the_order),
        cmocka_unit_test(cpu_time_counts_work_and_not_waiting),
        cmocka_unit_test(destroy_finishes_what_is_queued),
        cmocka_unit_test(a_team_without_work_lets_the_loop_end),
    };
    return cmocka_run_group_tests_name("team", tests, NULL, NULL);
}
