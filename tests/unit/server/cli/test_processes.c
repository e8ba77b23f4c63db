/* Local workers: started again when they die, left alone when they were refused, stopped in the
 * end. The workers are shell scripts. */
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/fleet/processes.h"
#include "tests/unit/unit.h"

struct world {
    uv_loop_t loop;
    struct processes *processes;
    uint64_t respawned;
    char program[64], note[80];
    bool closed;
};

/* $1.. are the worker's options; NOTE stands for a file that belongs to the test. */
static void open_world(struct world *w, const char *script, unsigned count)
{
    static int worlds;
    struct fault fault = {0};
    memset(w, 0, sizeof *w);
    snprintf(w->program, sizeof w->program, "/tmp/shearwater-test-proc-%ld-%d", (long)getpid(),
             ++worlds);
    snprintf(w->note, sizeof w->note, "%s.note", w->program);
    FILE *file = fopen(w->program, "w");
    fprintf(file, "#!/bin/sh\nNOTE=%s\n%s\n", w->note, script);
    fclose(file);
    chmod(w->program, 0700);
    uv_loop_init(&w->loop);
    const struct processes_options options = {.program = w->program,
                                              .socket_path = "/nowhere/s",
                                              .cache_dir = "/nowhere/cache",
                                              .count = count,
                                              .threads = 3};
    if (processes_create(&w->loop, &options, &w->respawned, &w->processes, &fault) != 0)
        fail_msg("%s: %s", fault.pointer, fault.detail);
}

static void run_for(struct world *w, unsigned ms)
{
    uint64_t end = uv_hrtime() + ms * 1000000ull;
    while (uv_hrtime() < end) {
        uv_run(&w->loop, UV_RUN_NOWAIT);
        usleep(2000);
    }
}

static void on_closed(void *ctx)
{
    struct world *w = ctx;
    w->closed = true;
}

static double close_world(struct world *w)
{
    uint64_t before = uv_hrtime();
    processes_close(w->processes, on_closed, w);
    while (!w->closed) uv_run(&w->loop, UV_RUN_ONCE);
    double seconds = (double)(uv_hrtime() - before) * 1e-9;
    assert_int_equal(uv_loop_close(&w->loop), 0);
    unlink(w->program);
    unlink(w->note);
    return seconds;
}

/* The note that a worker has written. */
static void read_note(struct world *w, char *text, size_t capacity)
{
    size_t n = 0;
    for (int i = 0; i < 200 && n == 0; i++) {
        FILE *file = fopen(w->note, "r");
        if (file) {
            n = fread(text, 1, capacity - 1, file);
            fclose(file);
        }
        run_for(w, 10);
    }
    text[n] = '\0';
}

TEST(workers_are_told_what_they_need)
{
    struct world w;
    char text[512];
    open_world(&w, "echo \"$@\" > $NOTE.new; mv $NOTE.new $NOTE; exec sleep 60", 1);
    read_note(&w, text, sizeof text);
    assert_string_equal(text, "--connect unix:/nowhere/s --threads 3 --name local-1 "
                              "--exit-with-parent --nice 10 --log-format text "
                              "--cache /nowhere/cache\n");
    assert_true(close_world(&w) < 2.0);
    assert_int_equal(w.respawned, 0);
}

TEST(the_dead_are_replaced_ever_later)
{
    struct world w;
    open_world(&w, "exit 1", 1);
    run_for(&w, 1200); /* after 200, 400, ... ms */
    assert_in_range(w.respawned, 1, 2);
    close_world(&w);
    open_world(&w, "[ -e $NOTE ] && exec sleep 60; touch $NOTE; kill -9 $$", 1);
    run_for(&w, 800);
    assert_int_equal(w.respawned, 1);
    close_world(&w);
}

TEST(the_refused_stay_down)
{
    struct world w;
    open_world(&w, "exit 3", 2);
    run_for(&w, 700);
    assert_int_equal(w.respawned, 0);
    close_world(&w);
}

TEST(the_stubborn_are_killed)
{
    struct world w;
    char text[64];
    open_world(&w, "trap '' TERM; echo $$ > $NOTE; while :; do sleep 0.2; done", 1);
    read_note(&w, text, sizeof text);
    pid_t pid = (pid_t)strtol(text, NULL, 10);
    assert_true(pid > 1);
    double seconds = close_world(&w);
    assert_true(seconds > 4.5 && seconds < 8.0);
    assert_int_equal(kill(pid, 0), -1);
    assert_int_equal(errno, ESRCH);
}

TEST(a_missing_program_is_named)
{
    uv_loop_t loop;
    uint64_t respawned = 0;
    struct fault fault = {0};
    struct processes *p = NULL;
    const struct processes_options options = {
        .program = "/nowhere/worker", .socket_path = "/s", .count = 1, .threads = 1};
    uv_loop_init(&loop);
    assert_int_equal(processes_create(&loop, &options, &respawned, &p, &fault), ERR_NOT_FOUND);
    assert_string_equal(fault.pointer, "/nowhere/worker");
    assert_int_equal(uv_loop_close(&loop), 0);
}
