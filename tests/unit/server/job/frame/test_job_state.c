/* The legal steps of jobs and frames, and the death of an illegal one. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/job/frame/state.h"
#include "server/job/job_id.h"
#include "tests/unit/unit.h"

TEST(names_go_both_ways)
{
    for (unsigned i = 0; i < JOB_STATE_COUNT; i++) {
        enum job_state back;
        assert_true(job_state_from_name(job_state_name((enum job_state)i), &back));
        assert_int_equal(back, i);
    }
    for (unsigned i = 0; i < FRAME_STATE_COUNT; i++) {
        enum frame_state back;
        assert_true(frame_state_from_name(frame_state_name((enum frame_state)i), &back));
        assert_int_equal(back, i);
    }
    enum job_state none;
    assert_false(job_state_from_name("paused", &none));
}

TEST(steps_are_those_of_the_table)
{
    static const char *const legal[JOB_STATE_COUNT] = {
        [JOB_QUEUED] = "importing failed cancelled",
        [JOB_IMPORTING] = "queued running failed cancelled",
        [JOB_RUNNING] = "queued resting finished failed cancelled",
        [JOB_RESTING] = "queued running finished failed cancelled",
        [JOB_FINISHED] = "",
        [JOB_FAILED] = "",
        [JOB_CANCELLED] = "",
    };
    for (unsigned from = 0; from < JOB_STATE_COUNT; from++) {
        for (unsigned to = 0; to < JOB_STATE_COUNT; to++) {
            bool expected = strstr(legal[from], job_state_name((enum job_state)to)) != NULL;
            assert_int_equal(job_state_may((enum job_state)from, (enum job_state)to), expected);
        }
        assert_int_equal(job_state_is_final((enum job_state)from), from >= JOB_FINISHED);
    }
    assert_true(frame_state_may(FRAME_RENDERING, FRAME_QUEUED));
    assert_false(frame_state_may(FRAME_FINISHED, FRAME_QUEUED));
    assert_false(frame_state_may(FRAME_QUEUED, FRAME_ENCODING));
}

TEST(an_illegal_step_dies)
{
    int status;
    pid_t child = fork();
    if (child == 0) {
        enum job_state s = JOB_FINISHED;
        fclose(stderr);
        signal(SIGABRT, SIG_DFL);
        job_state_go(&s, JOB_RUNNING);
        _exit(0);
    }
    waitpid(child, &status, 0);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

TEST(ids_sort_by_time)
{
    struct job_id_source source = {0};
    char last[JOB_ID_BYTES] = "", id[JOB_ID_BYTES];
    static const uint64_t times[] = {
        1000, 1000,          1000,          1001,          999,
        5,    1700000000000, 1700000000000, 1699999999999, (1ull << 48) - 1};
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        assert_int_equal(job_id_next(&source, times[i], id), 0);
        assert_true(job_id_is_valid(id));
        assert_true(strcmp(last, id) < 0);
        memcpy(last, id, sizeof last);
    }
    assert_false(job_id_is_valid("short"));
    assert_false(job_id_is_valid("01M7YYD0NA0FFWACW3MMCPWBCQ"));
    assert_false(job_id_is_valid("01m7yyd0na0ffwacw3mmcpwbc/"));
}

/* ... also after a restart under a clock that was set back. */
TEST(ids_follow_those_of_an_earlier_process)
{
    struct job_id_source before = {0};
    char last[JOB_ID_BYTES], id[JOB_ID_BYTES];
    for (int i = 0; i < 100; i++) {
        struct job_id_source after = {0};
        assert_int_equal(job_id_next(&before, 1800000000000 + (uint64_t)(i % 3), last), 0);
        job_id_follow(&after, last);
        assert_int_equal(after.last_ms, before.last_ms);
        assert_memory_equal(after.random, before.random, sizeof after.random);
        assert_int_equal(job_id_next(&after, 1700000000000, id), 0);
        assert_true(strcmp(last, id) < 0);
        assert_int_equal(strncmp(last, id, 10), 0);
    }
}

/* A millisecond's random part that is all ones carries into the time. */
TEST(ids_grow_over_a_full_random_part)
{
    struct job_id_source source = {.last_ms = 77};
    char before[JOB_ID_BYTES], after[JOB_ID_BYTES];
    memset(source.random, 0xff, sizeof source.random);
    source.random[9] = 0xfe;
    assert_int_equal(job_id_next(&source, 77, before), 0);
    assert_int_equal(job_id_next(&source, 77, after), 0);
    assert_true(strcmp(before, after) < 0);
}
