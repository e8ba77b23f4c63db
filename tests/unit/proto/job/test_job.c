/* Job documents: each folder of tests/json is a case. valid/CASE/job.json reads, and so does what
 * is written of it, to the same job (canonical.json, where present, is what must be written).
 * invalid/CASE/job.json is refused as invalid/CASE/expect says: "CODE /pointer". */
#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/job/job.h"
#include "tests/unit/unit.h"

#define VALID      "tests/json/valid"
#define INVALID    "tests/json/invalid"
#define CASES_MAX  1024
#define PATH_BYTES 512

static char *read_file(const char *folder, const char *name, size_t *size_bytes)
{
    char path[PATH_BYTES];
    char *text = malloc(LIMIT_JOB_BYTES + 1);
    assert_non_null(text);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) fail_msg("%s cannot be opened", path);
    *size_bytes = fread(text, 1, LIMIT_JOB_BYTES, file);
    text[*size_bytes] = '\0';
    fclose(file);
    return text;
}

/* Memory of exactly the size, so that a sanitizer sees a read beyond. */
static int read_exact(const char *text, size_t size_bytes, struct job *job, struct fault *fault)
{
    char *exact = malloc(size_bytes + (size_bytes == 0));
    assert_non_null(exact);
    memcpy(exact, text, size_bytes);
    const int error = job_read(exact, size_bytes, job, fault);
    free(exact);
    return error;
}

static void check_same_text(const char *a, const char *b)
{
    assert_true(!a == !b);
    if (a) assert_string_equal(a, b);
}

static void check_same_marks(const struct job_marks *a, const struct job_marks *b)
{
    check_same_text(a->name, b->name);
    check_same_text(a->comment, b->comment);
    check_same_text(a->webhook, b->webhook);
    assert_int_equal(a->label_count, b->label_count);
    for (uint32_t i = 0; i < a->label_count; i++) assert_string_equal(a->labels[i], b->labels[i]);
}

static void check_same_composites(const struct job_composite *a, const struct job_composite *b)
{
    check_same_text(a->catchers, b->catchers);
    check_same_text(a->holdouts, b->holdouts);
    check_same_text(a->rgbd, b->rgbd);
    assert_true(a->on == b->on && a->has_plate == b->has_plate && a->fit == b->fit);
    assert_true(digest_equal(&a->plate, &b->plate));
    assert_true(a->color == b->color && a->mode == b->mode && a->has_ground == b->has_ground);
    assert_true(a->ground_height == b->ground_height);
}

static void check_same(const struct job *a, const struct job *b)
{
    assert_int_equal(a->file_count, b->file_count);
    for (uint32_t i = 0; i < a->file_count; i++) {
        assert_string_equal(a->files[i].path, b->files[i].path);
        assert_true(digest_equal(&a->files[i].asset, &b->files[i].asset));
    }
    check_same_marks(&a->marks, &b->marks);
    check_same_composites(&a->composite, &b->composite);
    struct job x = *a, y = *b;
    x.files = y.files = NULL;
    assert_memory_equal(&x.camera, &y.camera, sizeof x.camera);
    assert_memory_equal(x.lights, y.lights, sizeof x.lights);
    assert_memory_equal(&x.scene, &y.scene, sizeof x.scene);
    assert_true(x.width_px == y.width_px && x.height_px == y.height_px);
    assert_true(x.pixel_type == y.pixel_type && x.pixel_filter == y.pixel_filter &&
                x.scene_lights == y.scene_lights);
    assert_true(x.view == y.view && x.exposure == y.exposure && x.png_bits == y.png_bits);
    assert_true(x.png_alpha == y.png_alpha && x.exr_compression == y.exr_compression);
    assert_true(x.light_count == y.light_count && x.indirect_bounces == y.indirect_bounces);
    assert_true(x.spp == y.spp && x.light_spp == y.light_spp);
    assert_true(x.indirect_spp == y.indirect_spp && x.seed == y.seed && x.mu == y.mu);
    assert_true(x.method == y.method && x.indirect == y.indirect);
    assert_true(x.environment_filter == y.environment_filter);
    assert_true(x.layers == y.layers && x.priority == y.priority);
    assert_memory_equal(x.frames, y.frames, sizeof x.frames);
    assert_true(x.frame_run_count == y.frame_run_count && x.fps == y.fps);
    assert_true(job_moves_equal(&x.moves, &y.moves));
    assert_true(x.start_time_s == y.start_time_s && x.stands == y.stands && x.time_s == y.time_s);
    assert_string_equal(x.animation, y.animation);
    assert_true(x.tile_px == y.tile_px);
    assert_memory_equal(&x.environment, &y.environment, sizeof x.environment);
    assert_true(x.shutter_fraction == y.shutter_fraction && x.shutter_centre == y.shutter_centre);
    assert_true(x.aperture_radius == y.aperture_radius && x.focus_distance == y.focus_distance);
    assert_true(x.blades == y.blades && x.blade_rotation_deg == y.blade_rotation_deg);
    assert_true(x.occlusion_distance == y.occlusion_distance);
}

/* Lights of a job must pass as lights of a plan. */
static void check_lights(const struct job *job)
{
    struct fault fault = {0};
    for (uint32_t k = 0; k < job->light_count; k++)
        if (plan_light_check(&job->lights[k], "light", &fault))
            fail_msg("%s: %s", fault.pointer, fault.detail);
}

static void check_canonical(const char *folder, const char *written)
{
    char path[PATH_BYTES];
    size_t size_bytes;
    snprintf(path, sizeof path, "%s/canonical.json", folder);
    if (access(path, R_OK) != 0) return;
    char *canonical = read_file(folder, "canonical.json", &size_bytes);
    assert_string_equal(canonical, written);
    free(canonical);
}

static char *write_text(const struct job *job)
{
    json_t *document = job_write(job);
    assert_non_null(document);
    char *text = json_dumps(document, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    json_decref(document);
    assert_non_null(text);
    text = realloc(text, strlen(text) + 2);
    assert_non_null(text);
    return strcat(text, "\n");
}

/* Checks that `text` reads, and that what is written of it reads to the same job. */
static void check_valid(const char *text, size_t size_bytes, const char *folder)
{
    static struct job job, again;
    struct fault fault = {0};
    if (read_exact(text, size_bytes, &job, &fault))
        fail_msg("%s at \"%s\": %s", error_name(fault.code), fault.pointer, fault.detail);
    check_lights(&job);
    char *written = write_text(&job);
    if (folder) check_canonical(folder, written);
    json_t *full = job_write(&job);
    char *exact = json_dumps(full, 0);
    assert_int_equal(read_exact(exact, strlen(exact), &again, &fault), 0);
    check_same(&job, &again);
    job_fini(&again);
    assert_int_equal(read_exact(written, strlen(written), &again, &fault), 0);
    char *twice = write_text(&again);
    assert_string_equal(written, twice);
    job_fini(&again);
    job_fini(&job);
    json_decref(full);
    free(twice);
    free(exact);
    free(written);
}

static void document_is_valid(void **state)
{
    size_t size_bytes;
    char *text = read_file(*state, "job.json", &size_bytes);
    check_valid(text, size_bytes, *state);
    free(text);
}

static void check_printable(const char *text)
{
    for (; *text; text++)
        if (*text < 0x20 || *text > 0x7e) fail_msg("byte %d in a fault", *text);
}

static void check_refused(const char *text, size_t size_bytes, const char *expect)
{
    static struct job job;
    struct fault fault = {0};
    char found[PATH_BYTES];
    const int error = read_exact(text, size_bytes, &job, &fault);
    if (!error) fail_msg("it is accepted");
    assert_int_equal(error, fault.code);
    snprintf(found, sizeof found, "%s%s%s", error_name(error), fault.pointer[0] ? " " : "",
             fault.pointer);
    if (strcmp(found, expect) != 0)
        fail_msg("expected \"%s\", found \"%s\": %s", expect, found, fault.detail);
    assert_true(fault.detail[0] != '\0');
    check_printable(fault.pointer);
    check_printable(fault.detail);
}

static void document_is_refused(void **state)
{
    size_t size_bytes, expect_bytes;
    char *text = read_file(*state, "job.json", &size_bytes);
    char *expect = read_file(*state, "expect", &expect_bytes);
    if (expect_bytes > 0) expect[expect_bytes - 1] = '\0'; /* its newline */
    check_refused(text, size_bytes, expect);
    free(expect);
    free(text);
}

/* A fault that could be told needs no place to put it. */
TEST(faults_are_optional)
{
    static struct job job;
    assert_int_equal(read_exact("{\"scene\": {}}", 13, &job, NULL), ERR_MISSING);
    assert_int_equal(read_exact("{", 1, &job, NULL), ERR_SYNTAX);
}

TEST(large_documents_are_refused)
{
    static struct job job;
    struct fault fault = {0};
    char *text = malloc(LIMIT_JOB_BYTES + 1);
    assert_non_null(text);
    memset(text, ' ', LIMIT_JOB_BYTES + 1);
    assert_int_equal(read_exact(text, LIMIT_JOB_BYTES + 1, &job, &fault), ERR_LIMIT);
    assert_int_equal(read_exact(text, LIMIT_JOB_BYTES, &job, &fault), ERR_SYNTAX);
    free(text);
}

TEST(sentences_help)
{
    static const struct {
        const char *folder, *words;
    } cases[] = {
        {"unknown-slip", "did you mean \"lights\"?"},
        {"sampling-slip", "did you mean \"spp\"?"},
        {"light-type-slip", "did you mean \"point\"?"},
        {"layers-unknown", "did you mean \"beauty\"?"},
        {"width-0", "0 is below 1"},
        {"width-16385", "16385 is above 16384"},
        {"width-1e99", "1e+99 is not in 1..16384"},
        {"bounces-65", "65 is above 64"},
        {"environment-both", "give one of the two"},
        {"environment-empty", "(the same from everywhere)"},
        {"environment-file", "submit with the command line"},
        {"lens-no-focus", "has to be focused"},
        {"lens-blades-2", "neither 0 (round) nor from 3 to 32"},
        {"lens-slip", "did you mean \"aperture_radius\"?"},
        {"ambient-occlusion", "give {\"distance\": ...}"},
        {"layers-occlusion", "needs {\"distance\": ...}"},
        {"width-string", "it is a string and must be a whole number"},
        {"json-cut", "line 1"},
        {"depth-65-arrays", "65 deep"},
    };
    static struct job job;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char folder[PATH_BYTES];
        struct fault fault = {0};
        size_t size_bytes;
        snprintf(folder, sizeof folder, INVALID "/%s", cases[i].folder);
        char *text = read_file(folder, "job.json", &size_bytes);
        assert_true(job_read(text, size_bytes, &job, &fault) != 0);
        if (!strstr(fault.detail, cases[i].words)) fail_msg("%s: %s", folder, fault.detail);
        free(text);
    }
}

#define ASSET "3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f3f"
#define SCENE "\"scene\": {\"asset\": \"" ASSET "\"}"

/* Reads a job of a scene and further members. */
static int read_with(const char *members, struct job *job)
{
    char text[512];
    snprintf(text, sizeof text, "{" SCENE "%s}", members);
    return job_read(text, strlen(text), job, NULL);
}

#define FOCUSED ", \"focus_distance\": 2, \"blades\": 6}"
TEST(environments_and_lenses_are_read)
{
    static struct job job;
    assert_int_equal(read_with("", &job), 0);
    assert_int_equal(job.environment.kind, ENVIRONMENT_NONE);
    assert_true(job.aperture_radius == 0 && job.occlusion_distance == 0);
    assert_int_equal(read_with(", \"environment\": {\"asset\": \"" ASSET "\"}", &job), 0);
    assert_int_equal(job.environment.kind, ENVIRONMENT_MAP);
    assert_int_equal(job.environment.asset.bytes[31], 0x3f);
    assert_true(job.environment.intensity == 1 && job.environment.rotation_deg == 0);
    assert_int_equal(read_with(", \"environment\": {\"radiance\": [1, 2, 3]}", &job), 0);
    assert_int_equal(job.environment.kind, ENVIRONMENT_CONSTANT);
    assert_true(job.environment.radiance[2] == 3);
    assert_int_equal(read_with(", \"lens\": {\"aperture_radius\": 0.5" FOCUSED, &job), 0);
    assert_true(job.aperture_radius == 0.5f && job.focus_distance == 2 && job.blades == 6);
    /* A closed aperture leaves no lens behind that would make equal pictures differ. */
    assert_int_equal(read_with(", \"lens\": {\"aperture_radius\": 0" FOCUSED, &job), 0);
    assert_true(job.focus_distance == 0 && job.blades == 0);
}

/* Writes a document that holds `count` items between `head` and `tail`, each under a key of its
 * own where `keyed`, and returns its length. */
static size_t repeat_item(char *text, const char *head, bool keyed, const char *item, int count,
                          const char *tail)
{
    char *end = text + sprintf(text, "%s", head);
    for (int i = 0; i < count; i++) {
        if (i > 0) *end++ = ',';
        if (keyed) end += sprintf(end, "\"t/%03d.png\": ", i);
        end += sprintf(end, "%s", item);
    }
    return (size_t)(end - text) + (size_t)sprintf(end, "%s", tail);
}

TEST(lists_have_limits)
{
    static const struct {
        const char *head, *item, *tail, *expect;
        int count_max, keyed;
    } lists[] = {
        {"{" SCENE ", \"lights\": [",
         "{\"type\": \"point\", \"position\": [1, 2, 3], \"intensity\": [10, 10, 10]}", "]}",
         "LIMIT /lights", 64, 0},
        {"{\"scene\": {\"asset\": \"" ASSET "\", \"files\": {", "\"" ASSET "\"", "}}}",
         "LIMIT /scene/files", LIMIT_SCENE_FILES, 1},
    };
    char *text = malloc(LIMIT_JOB_BYTES);
    assert_non_null(text);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        for (int over = 0; over < 2; over++) {
            const size_t size_bytes =
                repeat_item(text, lists[i].head, lists[i].keyed, lists[i].item,
                            lists[i].count_max + over, lists[i].tail);
            if (over) check_refused(text, size_bytes, lists[i].expect);
            if (!over) check_valid(text, size_bytes, NULL);
        }
    free(text);
}

TEST(paths_stay_inside)
{
    static const char *const good[] = {"a", "a/b", "..a", "...", "a b", ".a", "\xc3\xa4"};
    static const char *const bad[] = {"",     "/",    "/a",  "a/",   "..",   ".",
                                      "a//b", "a/..", "./a", "a\\b", "a\nb", "a/./b"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        assert_true(relative_path_is_inside(good[i]));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_false(relative_path_is_inside(bad[i]));
}

static int is_visible(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

/* Adds a test for each folder, and returns how many there are. */
static int add_folders(const char *parent, CMUnitTestFunction function)
{
    static char folders[CASES_MAX][PATH_BYTES];
    static struct unit_test tests[CASES_MAX];
    static int count;
    struct dirent **entries;
    const int found = scandir(parent, &entries, is_visible, alphasort);
    for (int i = 0; i < found; i++) {
        if (count < CASES_MAX) {
            char *folder = folders[count];
            snprintf(folder, PATH_BYTES, "%s/%s", parent, entries[i]->d_name);
            tests[count] =
                (struct unit_test){{folder, function, NULL, NULL, folder}, INT_MAX, NULL};
            unit_add(&tests[count++]);
        }
        free(entries[i]);
    }
    if (found >= 0) free(entries);
    return found;
}

int main(void)
{
    const int valid = add_folders(VALID, document_is_valid);
    const int invalid = add_folders(INVALID, document_is_refused);
    if (valid < 15 || invalid < 60 || valid + invalid > CASES_MAX) {
        fprintf(stderr, "tests/json is not whole; run from the root of the sources\n");
        return 1;
    }
    return unit_run("job");
}
