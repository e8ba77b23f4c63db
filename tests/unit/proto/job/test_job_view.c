/* Moves of a live job: what is taken, what is refused and where. */
#include <string.h>

#include "proto/job/job.h"
#include "tests/unit/unit.h"

static struct job with_lens(void)
{
    return (struct job){.camera = {.kind = JOB_CAMERA_INDEX, .index = 3},
                        .aperture_radius = 0.5f,
                        .focus_distance = 2.0f,
                        .blades = 5,
                        .blade_rotation_deg = 10.0f};
}

static int move(const char *text, struct job *job, struct fault *fault)
{
    *job = with_lens();
    return job_view_read(text, strlen(text), job, fault);
}

TEST(a_camera_moves_and_the_lens_stays)
{
    struct job job;
    struct fault fault;
    assert_int_equal(
        move("{\"camera\": {\"eye\": [1, 2, 3], \"target\": [0, 0, 0]}}", &job, &fault), 0);
    assert_int_equal(job.camera.kind, JOB_CAMERA_LOOK_AT);
    assert_true(job.camera.eye[1] == 2.0f && job.camera.yfov_deg == 45.0f);
    assert_true(job.aperture_radius == 0.5f && job.blades == 5);
}

TEST(a_lens_is_replaced_as_a_whole)
{
    struct job job;
    struct fault fault;
    assert_int_equal(
        move("{\"lens\": {\"aperture_radius\": 0.1, \"focus_distance\": 4}}", &job, &fault), 0);
    assert_true(job.focus_distance == 4.0f && job.blades == 0 && job.blade_rotation_deg == 0.0f);
    assert_int_equal(job.camera.kind, JOB_CAMERA_INDEX);
    assert_int_equal(move("{\"lens\": null}", &job, &fault), 0);
    assert_true(job.aperture_radius == 0.0f && job.focus_distance == 0.0f);
}

TEST(null_is_the_scenes_own_camera)
{
    struct job job;
    struct fault fault;
    assert_int_equal(move("{\"camera\": null}", &job, &fault), 0);
    assert_int_equal(job.camera.kind, JOB_CAMERA_DEFAULT);
}

#define LOOK(eye, target, rest) "{\"camera\": {\"eye\": " eye ", \"target\": " target rest "}}"

TEST(hostile_moves_are_refused_at_their_place)
{
    static const struct {
        const char *text, *pointer;
    } cases[] = {
        {"", ""},
        {"{", ""},
        {"[]", ""},
        {"{}", ""},
        {"{\"priority\": 1}", "/priority"},
        {"{\"camera\": true}", "/camera"},
        {"{\"camera\": {}}", "/camera/eye"},
        {LOOK("[0, 0, 0]", "[0, 0, 0]", ""), "/camera/target"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"yfov_deg\": 0"), "/camera/yfov_deg"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"yfov_deg\": 180"), "/camera/yfov_deg"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"yfov_deg\": -45"), "/camera/yfov_deg"},
        {LOOK("[0, 0, 0]", "[0, 3, 0]", ""), "/camera/up"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"up\": [0, 0, -2]"), "/camera/up"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"up\": [0, 0, 0]"), "/camera/up"},
        {LOOK("[NaN, 0, 0]", "[0, 0, 1]", ""), ""},
        {LOOK("[1e999, 0, 0]", "[0, 0, 1]", ""), ""},
        {LOOK("[1e300, 0, 0]", "[0, 0, 1]", ""), "/camera/eye/0"},
        {LOOK("[0, 0]", "[0, 0, 1]", ""), "/camera/eye"},
        {LOOK("[0, 0, 0]", "[0, 0, 1]", ", \"roll\": 1"), "/camera/roll"},
        {"{\"lens\": {\"aperture_radius\": 1}}", "/lens/focus_distance"},
        {"{\"lens\": {\"aperture_radius\": -1}}", "/lens/aperture_radius"},
        {"{\"lens\": {\"aperture_radius\": 1, \"focus_distance\": 0}}", "/lens/focus_distance"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct job job;
        struct fault fault = {0};
        assert_true(move(cases[i].text, &job, &fault) < 0);
        assert_string_equal(fault.pointer, cases[i].pointer);
        assert_true(fault.detail[0] != '\0');
    }
}
