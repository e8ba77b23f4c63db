/* Which frames a job has, by their order and by their numbers, and what time each shows. */
#include "proto/job/job.h"
#include "tests/unit/unit.h"

static struct job frames_of(const char *document)
{
    struct job job;
    json_t *json = json_loads(document, 0, NULL);
    assert_non_null(json);
    assert_int_equal(job_frames_of(json, &job), 0);
    json_decref(json);
    return job;
}

static void check(const char *document, const int32_t *numbers, uint32_t count)
{
    const struct job job = frames_of(document);
    assert_int_equal(job_frame_count(&job), count);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t index;
        assert_int_equal(job_frame_number(&job, i), numbers[i]);
        assert_true(job_frame_find(&job, numbers[i], &index));
        assert_int_equal(index, i);
    }
}

TEST(frames_have_an_order)
{
    check("{}", (int32_t[]){1}, 1);
    check("{\"frames\": {\"first\": 3}}", (int32_t[]){3}, 1);
    check("{\"frames\": {\"first\": 0, \"last\": 2}}", (int32_t[]){0, 1, 2}, 3);
    check("{\"frames\": \"1-3,20-25x2,40\"}", (int32_t[]){1, 2, 3, 20, 22, 24, 40}, 7);
}

TEST(frames_between_are_not_there)
{
    const struct job job = frames_of("{\"frames\": \"1-3,20-25x2,40\"}");
    uint32_t index;
    for (int32_t number = -1; number < 50; number++) {
        const bool there = (number >= 1 && number <= 3) || number == 20 || number == 22 ||
                           number == 24 || number == 40;
        assert_int_equal(job_frame_find(&job, number, &index), there);
    }
}

TEST(frames_follow_each_other_without_gaps)
{
    static const struct {
        const char *frames;
        bool follow;
    } cases[] = {{"1-3", true},    {"1-2,3", true},    {"1,2", true},   {"1-2,5-6", true},
                 {"7", false},     {"1-5x2", false},   {"1,3", false},  {"1-3,20", false},
                 {"1-3,5", false}, {"1,2-6x2", false}, {"7-8x2", false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char document[64];
        snprintf(document, sizeof document, "{\"frames\": \"%s\"}", cases[i].frames);
        const struct job job = frames_of(document);
        if (job_frames_follow(&job) != cases[i].follow) fail_msg("%s", cases[i].frames);
    }
}

TEST(a_frame_has_its_time_whatever_others_there_are)
{
    struct job job = {.fps = 24, .start_time_s = 10, .time_s = 3};
    assert_true(job_frame_time_s(&job, 1) == 10);
    assert_true(job_frame_time_s(&job, 25) == 11);
    assert_true(job_frame_time_s(&job, 0) == 10 - 1.0 / 24);
    job.stands = true;
    assert_true(job_frame_time_s(&job, 25) == 3);
}

TEST(what_is_no_list_is_refused)
{
    struct job job;
    json_t *json = json_loads("{\"frames\": \"1-\"}", 0, NULL);
    assert_int_equal(job_frames_of(json, &job), ERR_SYNTAX);
    json_decref(json);
}

TEST(copies_have_files_of_their_own)
{
    struct job_file file = {.path = "a.bin"};
    const struct job job = {.file_count = 1, .files = &file, .spp = 7};
    struct job copy;
    assert_int_equal(job_copy(&job, &copy), 0);
    assert_true(copy.spp == 7 && copy.file_count == 1 && copy.files[0].path != file.path);
    assert_string_equal(copy.files[0].path, "a.bin");
    job_fini(&copy);
}
