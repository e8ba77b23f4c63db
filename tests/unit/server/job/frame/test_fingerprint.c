/* What tells one job from another, its fingerprint and the names and bytes of its files; and kinds
 * of files by their first bytes. */
#include "server/job/frame/fingerprint.h"
#include "server/job/prepare/import_folder.h"
#include "server/job/prepare/imports.h"
#include "tests/unit/server/job/plan/plan_stage.h"
#include "tests/unit/unit.h"

EACH_TEST(stage_set_up, stage_tear_down);

TEST(fingerprints_leave_out_how)
{
    struct stage *s = *state;
    char a[FINGERPRINT_BYTES], b[FINGERPRINT_BYTES];
    assert_int_equal(fingerprint_of(&s->job, a), 0);
    s->job.priority = 7;
    s->job.tile_px = 64;
    s->job.view = VIEW_FILMIC;
    s->job.exposure = 2;
    s->job.png_bits = 16;
    s->job.png_alpha = true;
    s->job.exr_compression = EXR_CODEC_PIZ;
    char name[] = "a name", comment[] = "a comment", label[] = "a label";
    s->job.marks = (struct job_marks){name, comment, {label}, 1, label};
    assert_int_equal(fingerprint_of(&s->job, b), 0);
    assert_string_equal(a, b);
    s->job.marks = (struct job_marks){0};
    const struct job job = s->job;
#define OTHER(change)                                                                              \
    do {                                                                                           \
        s->job = job;                                                                              \
        change;                                                                                    \
        assert_int_equal(fingerprint_of(&s->job, b), 0);                                           \
        assert_string_not_equal(a, b);                                                             \
    } while (0)
    OTHER(s->job.seed++);
    OTHER(s->job.environment.kind = ENVIRONMENT_CONSTANT);
    OTHER((s->job.environment.kind = ENVIRONMENT_MAP, s->job.environment.asset.bytes[9] = 1));
    OTHER(s->job.aperture_radius = 1);
    OTHER(s->job.occlusion_distance = 1);
    OTHER(s->job.indirect_bounces = 2);
    OTHER(s->job.layers |= LAYER_ERROR);
#undef OTHER
    s->job = job;
}

TEST(sources_depend_on_names_not_order)
{
    struct stage *s = *state;
    struct job_file files[2] = {{(char *)"a.bin", {{1}}}, {(char *)"b.png", {{2}}}};
    struct job_file swapped[2] = {files[1], files[0]};
    struct job_file renamed[2] = {files[0], {(char *)"c.png", {{2}}}};
    struct digest first, second, third;
    struct job job = s->job;
    job.file_count = 2;
    job.files = files;
    assert_int_equal(imports_source(&job, &first), 0);
    job.files = swapped;
    assert_int_equal(imports_source(&job, &second), 0);
    job.files = renamed;
    assert_int_equal(imports_source(&job, &third), 0);
    assert_true(digest_equal(&first, &second));
    assert_false(digest_equal(&first, &third));
}

TEST(sniffs_kinds)
{
    assert_string_equal(import_folder_sniff("glTF\2\0\0\0", 8), ".glb");
    assert_string_equal(import_folder_sniff("\xef\xbb\xbf {\"asset\"", 12), ".gltf");
    assert_string_equal(import_folder_sniff("# Blender\nv 0 0 0\n", 18), ".obj");
    assert_string_equal(import_folder_sniff("#?RADIANCE\n", 11), ".hdr");
    assert_string_equal(import_folder_sniff("\x76\x2f\x31\x01\2\0", 6), ".exr");
    assert_null(import_folder_sniff("# bin\0ary", 9));
    assert_null(import_folder_sniff("\x89PNG\r\n", 6));
    assert_null(import_folder_sniff("  ", 2));
    assert_null(import_folder_sniff("", 0));
}
