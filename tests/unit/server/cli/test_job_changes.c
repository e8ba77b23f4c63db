/* Options of render and submit in a job document: what is replaced, what stays. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/cli/job_changes.h"
#include "tests/unit/unit.h"

/* Applies the changes to a document and compares it with another. */
static void check_change(const struct job_changes *changes, const char *before, const char *after)
{
    struct fault fault = {0};
    json_t *document = json_loads(before, 0, NULL), *expected = json_loads(after, 0, NULL);
    assert_non_null(document);
    assert_non_null(expected);
    assert_int_equal(job_changes_apply(changes, document, &fault), 0);
    if (!json_equal(document, expected)) {
        char *text = json_dumps(document, 0);
        fail_msg("%s became %s, not %s", before, text, after);
    }
    json_decref(document);
    json_decref(expected);
}

TEST(nothing_changes_nothing)
{
    const struct job_changes none = JOB_CHANGES_NONE;
    check_change(&none, "{}", "{}");
    check_change(&none, "{\"sampling\": 3, \"environment\": null}",
                 "{\"sampling\": 3, \"environment\": null}");
}

TEST(numbers_and_words_replace)
{
    const struct job_changes all = {.method = "none",
                                    .indirect = "linear",
                                    .lens = "average",
                                    .bounces = 0,
                                    .spp = 64,
                                    .tile_px = 32};
    check_change(&all, "{\"sampling\": {\"spp\": 9, \"seed\": 5}, \"filter\": {\"mu\": 2}}",
                 "{\"sampling\": {\"spp\": 64, \"seed\": 5, \"tile_px\": 32},"
                 " \"filter\": {\"mu\": 2, \"method\": \"none\", \"indirect\": \"linear\", "
                 "\"lens\": \"average\"},"
                 " \"effects\": {\"indirect_bounces\": 0}}");
    /* The server says better what is wrong. */
    check_change(&all, "{\"sampling\": 3, \"filter\": [], \"effects\": null}",
                 "{\"sampling\": 3, \"filter\": [], \"effects\": null}");
}

TEST(ids_for_compositors_are_layers_more)
{
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.cryptomatte = true;
    check_change(&changes, "{}",
                 "{\"layers\": [\"beauty\", \"CryptoObject\", \"CryptoMaterial\"]}");
    check_change(&changes, "{\"layers\": [\"CryptoMaterial\", \"depth\"]}",
                 "{\"layers\": [\"CryptoMaterial\", \"depth\", \"CryptoObject\"]}");
    check_change(&changes, "{\"layers\": 3}", "{\"layers\": 3}");
    check_change(&changes, "{\"catchers\": [\"floor\"]}",
                 "{\"catchers\": [\"floor\"], \"layers\": [\"beauty\", \"catcher\", "
                 "\"CryptoObject\", \"CryptoMaterial\"]}");
}

TEST(files_and_how_they_are_seen_replace)
{
    struct fault fault = {0};
    struct job_changes changes = JOB_CHANGES_NONE;
    json_t *document = json_object();
    changes.view = "filmic";
    changes.exposure = "-1.5";
    changes.png_bits = 16;
    changes.png_alpha = true;
    changes.compression = "piz";
    check_change(&changes, "{\"image\": {\"width\": 9, \"view\": \"linear\"}}",
                 "{\"image\": {\"width\": 9, \"view\": \"filmic\", \"exposure\": -1.5,"
                 " \"png_bits\": 16, \"png_alpha\": true, \"exr_compression\": \"piz\"}}");
    changes.exposure = "nan";
    assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_RANGE);
    assert_string_equal(fault.detail, "--exposure: \"nan\" is no number");
    json_decref(document);
}

TEST(names_replace_and_labels_are_added)
{
    struct fault fault = {0};
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.name = "new";
    changes.comment = "why";
    changes.labels = (struct option_list){{"b,c d", "b"}, 2};
    check_change(&changes, "{\"name\": \"old\", \"labels\": [\"a\", \"b\"]}",
                 "{\"name\": \"new\", \"labels\": [\"a\", \"b\", \"c d\"], \"comment\": \"why\"}");
    changes = (struct job_changes){.bounces = -1, .labels = {{"a,"}, 1}};
    check_change(&changes, "{}", "{\"labels\": [\"a\", \"\"]}"); /* the server refuses the second */
    json_t *document = json_object();
    changes = (struct job_changes){.bounces = -1, .name = "\xff"};
    assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_RANGE);
    json_decref(document);
}

TEST(lists_may_be_given_several_times)
{
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.catchers = (struct option_list){{"floor,wall", "table"}, 2};
    changes.holdouts = (struct option_list){{"lamp", "sun"}, 2};
    check_change(&changes, "{\"catchers\": [\"door\"]}",
                 "{\"catchers\": [\"door\", \"floor\", \"wall\", \"table\"],"
                 " \"holdouts\": [\"lamp\", \"sun\"]}");
}

TEST(sizes_and_cameras_replace)
{
    struct fault fault = {0};
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.size = "640x360";
    changes.camera = "front door";
    changes.no_default_light = true;
    check_change(&changes, "{\"image\": {\"width\": 9, \"pixel_type\": \"half\"}}",
                 "{\"image\": {\"width\": 640, \"height\": 360, \"pixel_type\": \"half\"},"
                 " \"scene\": {\"camera\": \"front door\", \"default_light\": false}}");
    changes = (struct job_changes){.bounces = -1, .camera = "12"};
    check_change(&changes, "{}", "{\"scene\": {\"camera\": 12}}");
    static const char *const wrong[] = {"640", "640x", "x360", "0x360", "640x360x1", "640x99999"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *document = json_object();
        changes = (struct job_changes){.bounces = -1, .size = wrong[i]};
        assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_RANGE);
        json_decref(document);
    }
}

TEST(times_and_frames_replace)
{
    struct fault fault = {0};
    struct job_changes changes = JOB_CHANGES_NONE;
    changes.animation = "walk";
    changes.time = "-1.5";
    changes.frames = "1-10x2";
    changes.fps = "25";
    check_change(&changes, "{\"frames\": {\"first\": 3}, \"scene\": {\"time_s\": null}}",
                 "{\"scene\": {\"animation\": \"walk\", \"time_s\": -1.5},"
                 " \"frames\": \"1-10x2\", \"fps\": 25.0}");
    changes = (struct job_changes){.bounces = -1, .time = "noon"};
    json_t *document = json_object();
    assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_RANGE);
    changes = (struct job_changes){.bounces = -1, .fps = "nan"};
    assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_RANGE);
    json_decref(document);
}

TEST(environments_are_replaced)
{
    char path[] = "/tmp/job_changes_XXXXXX", file[64], after[256];
    struct job_changes changes = JOB_CHANGES_NONE;
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    changes.environment = path;
    snprintf(file, sizeof file, "\"file\": \"%s\"", path);
    snprintf(after, sizeof after, "{\"environment\": {%s}}", file);
    check_change(&changes, "{}", after);
    check_change(&changes, "{\"environment\": null}", after);
    check_change(&changes, "{\"environment\": {\"radiance\": [1, 1, 1]}}", after);
    snprintf(after, sizeof after, "{\"environment\": {%s, \"intensity\": 2, \"rotation_deg\": 30}}",
             file);
    check_change(&changes,
                 "{\"environment\": {\"asset\": \"00\", \"intensity\": 2, \"rotation_deg\": 30}}",
                 after);
    check_change(
        &changes,
        "{\"environment\": {\"file\": \"old.exr\", \"intensity\": 2, \"rotation_deg\": 30}}",
        after);
    unlink(path);
}

TEST(absent_maps_are_named)
{
    struct job_changes changes = JOB_CHANGES_NONE;
    struct fault fault = {0};
    changes.environment = "/nowhere/sky.hdr";
    json_t *document = json_object();
    assert_int_equal(job_changes_apply(&changes, document, &fault), ERR_NOT_FOUND);
    assert_non_null(strstr(fault.detail, "--environment: /nowhere/sky.hdr"));
    json_decref(document);
}
