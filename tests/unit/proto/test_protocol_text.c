/* PROTOCOL.md names every message, counter and verdict with its number, and the limits as they are.
 * The working directory is the repository. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/link/message.h"
#include "proto/link/wire_frame.h"
#include "proto/plan.h"
#include "proto/samples.h"
#include "proto/scene/scene.h"
#include "tests/unit/unit.h"

#define PATH "proto/PROTOCOL.md"

static char page[262144];

static int read_page(void **state)
{
    (void)state;
    FILE *file = fopen(PATH, "rb");
    if (file == NULL) return -1;
    size_t size_bytes = fread(page, 1, sizeof page - 1, file);
    fclose(file);
    page[size_bytes] = '\0';
    return size_bytes > 0 && size_bytes < sizeof page - 1 ? 0 : -1;
}

ALL_TESTS(read_page, NULL);

static void expect(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void expect(const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (strstr(page, text) == NULL) fail_msg("%s does not say: %s", PATH, text);
}

TEST(names_every_message)
{
#define MESSAGE(name, number, type, sender, text)                                                  \
    expect("\n| %d | " #name " | " #sender " | %s |\n", number, text);                             \
    expect("\n**" #name "** (%d)", number);
#include "proto/link/message.def"
#undef MESSAGE
}

TEST(names_every_counter)
{
#define COUNTER(name, group, key, text)                                                            \
    expect("\n| %d | " #name " | %s (`" #group "." #key "`) |\n", COUNTER_##name, text);
#include "proto/counter.def"
#undef COUNTER
}

TEST(names_verdicts)
{
    expect("\n| %d | ACCEPTED |", VERDICT_ACCEPTED);
    expect("\n| %d | DUPLICATE |", VERDICT_DUPLICATE);
    expect("\n| %d | STALE |", VERDICT_STALE);
    expect("\n| %d | FOREIGN |", VERDICT_FOREIGN);
    expect("\n| %d | CORRUPT |", VERDICT_CORRUPT);
}

/* How many rows the table with this head has. */
static uint32_t rows_below(const char *head)
{
    const char *line = strstr(page, head);
    assert_non_null(line);
    uint32_t lines = 0;
    for (; *line == '|'; line = strchr(line, '\n') + 1) lines++;
    return lines - 2; /* the head, and what rules it off */
}

TEST(tells_of_every_plane)
{
    static const char *const types[] = {"f32", "u32", "f16", "u16", "u8"};
    static const char *const pers[] = {"", " a sub-sample", " a stratum", " a lens sample",
                                       " for 8 strata"};
#define PLANE(number, name, key, type, components, per, values, merge, arrays, unit, text)         \
    expect("\n| %d | " #name " | %s | %d%s | " unit " | " text " |\n", number,                     \
           types[SAMPLES_##type], components, pers[SAMPLES_PER_##per]);
#define LIGHT_PLANE(number, name, key, type, components, per, values, arrays, unit, text)          \
    expect("\n| %d | " #name " | %s | %d%s | " unit " | " text " |\n", number,                     \
           types[SAMPLES_##type], components, pers[SAMPLES_PER_##per]);
#include "proto/plane.def"
    expect("\n| %d | MIXED |", PLANE_MIXED);
    expect("\n| %d | LONE |", PLANE_LONE);
    assert_int_equal(rows_below("| number | plane |"), PLANE_ID_COUNT + 2); /* and the lists */
    assert_int_equal(rows_below("| number | light plane |"), LIGHT_PLANE_COUNT);
}

/* The table of section 4 has the plan's fields in their order, and nothing else. */
TEST(names_fields_of_plans)
{
    static const char *const rows[] = {
#define FIELD(type, name, check, from, to)  "\n| " #type " | " #name " |",
#define CAMERA(type, name, check, from, to) "\n| " #type " | camera." #name " |",
#define LIGHT(type, name, check, from, to)  "\n| " #type " | light." #name " |",
#define POSE(type, name, check, from, to)   "\n| " #type " | pose." #name " |",
#include "proto/plan.def"
    };
    const size_t count = sizeof rows / sizeof *rows;
    const char *at = strstr(page, "\n## 4. ");
    if (at) at = strstr(at, "\n|---|---|---|\n");
    assert_non_null(at);
    at = strchr(at + 1, '\n');
    for (size_t i = 0; i < count; i++) {
        if (strncmp(at, rows[i], strlen(rows[i])) != 0)
            fail_msg("%s says %.40s, not %s", PATH, at + 1, rows[i] + 1);
        at = strchr(at + 1, '\n');
        assert_non_null(at);
    }
    assert_memory_equal(at, "\n\n", 2);
}

TEST(sizes_are_true)
{
    struct plan *plan = calloc(1, sizeof *plan);
    struct bytes_writer w;
    assert_non_null(plan);
    bytes_writer_init(&w);
    plan_encode(&w, plan);
    size_t without_bytes = w.size_bytes;
    plan->light_count = 1;
    plan_encode(&w, plan);
    const size_t light_bytes = w.size_bytes - 2 * without_bytes, before = w.size_bytes;
    plan->pose_count = SHUTTER_STEPS;
    plan_encode(&w, plan);
    expect("%zu bytes, %zu a light and %zu a pose;", without_bytes, light_bytes,
           (w.size_bytes - before - without_bytes - light_bytes) / SHUTTER_STEPS);
    bytes_writer_fini(&w);
    free(plan);
    expect("Header, %zu bytes", sizeof(struct scene_header));
    expect("sections, %zu bytes each", sizeof(struct scene_section_entry));
    expect("| 0 | info | %u bytes", scene_record_bytes(SCENE_INFO));
    expect("| 6 | meshes | %u bytes", scene_record_bytes(SCENE_MESHES));
    expect("| 7 | instances | %u bytes", scene_record_bytes(SCENE_INSTANCES));
    expect("| 8 | materials | %u bytes", scene_record_bytes(SCENE_MATERIALS));
    expect("| 9 | textures | %u bytes", scene_record_bytes(SCENE_TEXTURES));
    expect("| 10 | images | %u bytes", scene_record_bytes(SCENE_IMAGES));
    expect("| 18 | movers | %u bytes", scene_record_bytes(SCENE_MOVERS));
    expect("| 19 | steps | %u bytes, %u a mover", scene_record_bytes(SCENE_STEPS), SHUTTER_STEPS);
    expect("| 20 | poses | %u bytes, %u a camera", scene_record_bytes(SCENE_POSES), SHUTTER_STEPS);
    expect("| 12 | lights | %u bytes", scene_record_bytes(SCENE_LIGHTS));
    expect("| 13 | cameras | %u bytes", scene_record_bytes(SCENE_CAMERAS));
    expect("`u32` count of sections (%d)", SCENE_SECTION_COUNT);
}

/* Numbers that the page repeats in prose. */
TEST(limits_are_true)
{
    expect("| u32 | protocol_version | %u |", PROTOCOL_VERSION);
    expect("| u32 | threads | 1…%d |", LIMIT_THREADS);
    expect("| %u | … | payload |", WIRE_FRAME_HEADER_BYTES);
    assert_int_equal(LIMIT_HELLO_BYTES, 4096);
    expect("4,096 bytes (`LIMIT_HELLO_BYTES`)");
    assert_int_equal(LIMIT_FRAME_BYTES, 134217728);
    expect("134,217,728 (`LIMIT_FRAME_BYTES`)");
    expect("%d (`LIMIT_TILES_IN_HAND`)", LIMIT_TILES_IN_HAND);
    assert_int_equal(LIMIT_BLOB_PART_BYTES, 1u << 20);
    expect("1 MiB (`LIMIT_BLOB_PART_BYTES`)");
    assert_true(LIMIT_BLOB_BYTES == 8ull << 30);
    assert_int_equal(LIMIT_NAME_BYTES, 256);
    assert_int_equal(LIMIT_DETAIL_BYTES, 512);
    expect("sides at most %d px", LIMIT_TILE_SIDE_PX);
    expect("at most %d, then for each light", LIMIT_LIGHTS);
    expect("anti-aliasing rays a pixel, 0…%d", LIMIT_SUB_SAMPLES);
    expect("| u32 | bounces | 0…%d |", LIMIT_INDIRECT_BOUNCES);
    assert_int_equal(LIMIT_SPP, 65536);
    expect("0…65,536");
    expect("| u32 | pass | below %d |", LIMIT_PASSES);
    expect("0, or 3…%d |", LIMIT_LENS_BLADES);
}
