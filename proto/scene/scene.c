#include "proto/scene/scene.h"

#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/runtime/blob_file.h"
#include "proto/scene/environment.h"
#include "proto/scene/scene_internal.h"

/* Embree reads up to 16 bytes from the last vertex on. */
#define READABLE_BYTES 16u

struct section_kind {
    const char *name;
    uint32_t record_bytes;
    uint64_t limit;
};

/* Optional arrays may run parallel to the positions of several meshes, never beyond them all. */
static const struct section_kind kinds[SCENE_SECTION_COUNT] = {
    [SCENE_INFO] = {"info", sizeof(struct scene_info), 1},
    [SCENE_POSITIONS] = {"positions", 12, LIMIT_VERTICES},
    [SCENE_NORMALS] = {"normals", 12, LIMIT_VERTICES},
    [SCENE_TANGENTS] = {"tangents", 16, LIMIT_VERTICES},
    [SCENE_UVS] = {"uvs", 8, 2ull * LIMIT_VERTICES},
    [SCENE_TRIANGLES] = {"triangles", 12, LIMIT_TRIANGLES},
    [SCENE_MESHES] = {"meshes", sizeof(struct scene_mesh), LIMIT_MESHES},
    [SCENE_INSTANCES] = {"instances", sizeof(struct scene_instance), LIMIT_INSTANCES},
    [SCENE_MATERIALS] = {"materials", sizeof(struct scene_material), LIMIT_MATERIALS},
    [SCENE_TEXTURES] = {"textures", sizeof(struct scene_texture), LIMIT_MATERIALS * 4ull},
    [SCENE_IMAGES] = {"images", sizeof(struct scene_image), LIMIT_IMAGES},
    [SCENE_PIXELS] = {"pixels", 1, LIMIT_BLOB_BYTES},
    [SCENE_LIGHTS] = {"lights", sizeof(struct scene_light), LIMIT_INSTANCES},
    [SCENE_CAMERAS] = {"cameras", sizeof(struct scene_camera), LIMIT_CAMERAS},
    [SCENE_NAMES] = {"names", 1, UINT32_MAX},
    [SCENE_WARNINGS] = {"warnings", 1, LIMIT_WARNINGS * 4096ull},
    [SCENE_COLORS] = {"colors", 16, LIMIT_VERTICES},
    [SCENE_BASE] = {"base", sizeof(struct digest), 1},
    [SCENE_MOVERS] = {"movers", sizeof(struct scene_mover), LIMIT_INSTANCES},
    [SCENE_STEPS] = {"steps", sizeof(struct scene_step), LIMIT_INSTANCES *(uint64_t)SHUTTER_STEPS},
    [SCENE_POSES] = {"poses", sizeof(struct scene_camera), LIMIT_CAMERAS *(uint64_t)SHUTTER_STEPS},
    [SCENE_SKY] = {"sky", 12, SCENE_SKY_TEXELS},
};

/* A stretch of the blob that something occupies. */
struct extent {
    uint64_t start, end;
    const char *name;
};

uint32_t scene_record_bytes(uint32_t section)
{
    return section < SCENE_SECTION_COUNT ? kinds[section].record_bytes : 0;
}

const char *scene_section_name(uint32_t section)
{
    return kinds[section].name;
}

static bool is_environment(const void *blob, size_t size_bytes)
{
    return size_bytes >= sizeof ENVIRONMENT_MAGIC &&
           memcmp(blob, ENVIRONMENT_MAGIC, sizeof ENVIRONMENT_MAGIC) == 0;
}

static int check_header(const struct scene_header *header, size_t size_bytes, struct fault *fault)
{
    if (memcmp(header->magic, SCENE_MAGIC, sizeof header->magic) != 0)
        return fault_set(fault, ERR_MAGIC, "header.magic", "this is no scene blob");
    if (header->version != SCENE_VERSION)
        return fault_set(fault, ERR_VERSION, "header.version",
                         "version %u, while this build reads %u: import the scene again",
                         header->version, SCENE_VERSION);
    if (header->section_count != SCENE_SECTION_COUNT)
        return fault_set(fault, ERR_RANGE, "header.section_count", "%u is not %d",
                         header->section_count, SCENE_SECTION_COUNT);
    if (header->total_bytes > size_bytes)
        return fault_set(fault, ERR_TRUNCATED, "header.total_bytes", "%llu of which %zu are there",
                         (unsigned long long)header->total_bytes, size_bytes);
    if (header->total_bytes < size_bytes)
        return fault_set(fault, ERR_TRAILING, "header.total_bytes", "%llu, but there are %zu",
                         (unsigned long long)header->total_bytes, size_bytes);
    if (header->reserved != 0) return fault_set(fault, ERR_RANGE, "header.reserved", "not 0");
    return 0;
}

static int refuse_section(uint32_t section, const char *field, int code, uint64_t value,
                          const char *why, struct fault *fault)
{
    char pointer[LIMIT_POINTER_BYTES];
    snprintf(pointer, sizeof pointer, "sections[%s].%s", kinds[section].name, field);
    return fault_set(fault, code, pointer, "%llu %s", (unsigned long long)value, why);
}

static int check_entry(const struct scene_section_entry *e, uint32_t section, size_t size_bytes,
                       struct fault *fault)
{
    const struct section_kind *kind = &kinds[section];
    if (e->record_bytes != kind->record_bytes)
        return refuse_section(section, "record_bytes", ERR_MISMATCH, e->record_bytes,
                              "is not this build's", fault);
    if (e->reserved != 0)
        return refuse_section(section, "reserved", ERR_RANGE, e->reserved, "is not 0", fault);
    if (e->count > kind->limit)
        return refuse_section(section, "count", ERR_LIMIT, e->count, "is above the limit", fault);
    if (e->offset % SCENE_ALIGN_BYTES != 0)
        return refuse_section(section, "offset", ERR_RANGE, e->offset, "is not aligned", fault);
    if (e->count == 0) return 0;
    /* Limits keep the product far below 2^64. */
    const uint64_t need_bytes = e->count * e->record_bytes + READABLE_BYTES;
    if (need_bytes > size_bytes || e->offset > size_bytes - need_bytes)
        return refuse_section(section, "offset", ERR_TRUNCATED, e->offset,
                              "puts the section past the end", fault);
    return 0;
}

static int extent_order(const void *a, const void *b)
{
    const struct extent *x = a, *y = b;
    return (x->start > y->start) - (x->start < y->start);
}

static int check_overlaps(const struct scene_section_entry *table, struct fault *fault)
{
    struct extent extents[SCENE_SECTION_COUNT + 1];
    size_t count = 0;
    const uint64_t head_bytes = sizeof(struct scene_header) + SCENE_SECTION_COUNT * sizeof *table;
    extents[count++] = (struct extent){0, head_bytes, "header"};
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) {
        if (table[s].count == 0) continue;
        const uint64_t end = table[s].offset + table[s].count * table[s].record_bytes;
        extents[count++] = (struct extent){table[s].offset, end, kinds[s].name};
    }
    qsort(extents, count, sizeof extents[0], extent_order);
    for (size_t i = 1; i < count; i++)
        if (extents[i].start < extents[i - 1].end)
            return fault_set(fault, ERR_CORRUPT, "sections", "%s and %s overlap",
                             extents[i - 1].name, extents[i].name);
    return 0;
}

static int check_table(const struct scene_section_entry *table, size_t size_bytes,
                       struct fault *fault)
{
    for (uint32_t s = 0; s < SCENE_SECTION_COUNT; s++) {
        const int error = check_entry(&table[s], s, size_bytes, fault);
        if (error) return error;
    }
    return check_overlaps(table, fault);
}

static void view_sections(struct scene *s, const struct scene_section_entry *table)
{
    const void *at[SCENE_SECTION_COUNT];
    for (uint32_t i = 0; i < SCENE_SECTION_COUNT; i++) {
        s->count[i] = table[i].count;
        at[i] = s->blob + (table[i].count ? table[i].offset : 0);
    }
    s->info = at[SCENE_INFO];
    s->positions = at[SCENE_POSITIONS];
    s->normals = at[SCENE_NORMALS];
    s->tangents = at[SCENE_TANGENTS];
    s->colors = at[SCENE_COLORS];
    s->uvs = at[SCENE_UVS];
    s->triangles = at[SCENE_TRIANGLES];
    s->meshes = at[SCENE_MESHES];
    s->instances = at[SCENE_INSTANCES];
    s->materials = at[SCENE_MATERIALS];
    s->textures = at[SCENE_TEXTURES];
    s->images = at[SCENE_IMAGES];
    s->pixels = at[SCENE_PIXELS];
    s->lights = at[SCENE_LIGHTS];
    s->cameras = at[SCENE_CAMERAS];
    s->movers = at[SCENE_MOVERS];
    s->steps = at[SCENE_STEPS];
    s->poses = at[SCENE_POSES];
    s->sky = at[SCENE_SKY];
    s->names = at[SCENE_NAMES];
    s->warnings = at[SCENE_WARNINGS];
}

int scene_open(const void *blob, size_t size_bytes, struct scene *out, struct fault *fault)
{
    return scene_open_on(blob, size_bytes, NULL, out, fault);
}

int scene_open_on(const void *blob, size_t size_bytes, const struct scene *base, struct scene *out,
                  struct fault *fault)
{
    const struct scene_header *header = blob;
    const size_t head_bytes =
        sizeof *header + SCENE_SECTION_COUNT * sizeof(struct scene_section_entry);
    *out = (struct scene){0};
    if ((uintptr_t)blob % SCENE_ALIGN_BYTES != 0)
        return fault_set(fault, ERR_RANGE, "", "the blob does not lie on a 64-byte boundary");
    if (is_environment(blob, size_bytes))
        return fault_set(fault, ERR_MAGIC, "header.magic",
                         "this is an environment map, not a scene");
    if (size_bytes < head_bytes)
        return fault_set(fault, ERR_TRUNCATED, "header", "%zu bytes are no scene blob", size_bytes);
    if (size_bytes > LIMIT_BLOB_BYTES)
        return fault_set(fault, ERR_LIMIT, "", "%zu bytes are above the limit of %llu", size_bytes,
                         LIMIT_BLOB_BYTES);
    int error = check_header(header, size_bytes, fault);
    if (error) return error;
    const struct scene_section_entry *table = (const void *)(header + 1);
    error = check_table(table, size_bytes, fault);
    if (error) return error;
    struct scene s = {.blob = blob, .blob_bytes = size_bytes};
    view_sections(&s, table);
    if (s.count[SCENE_BASE] > 0 && !base)
        return fault_set(fault, ERR_MISSING, "base", "the blob that it stands on is not there");
    if (s.count[SCENE_BASE] > 0) s.base = base;
    error = scene_check(&s, fault);
    if (error) return error;
    *out = s;
    return 0;
}

int scene_map(const char *path, struct scene *out, struct fault *fault)
{
    return scene_map_on(path, NULL, out, fault);
}

int scene_map_on(const char *path, const struct scene *base, struct scene *out, struct fault *fault)
{
    const void *blob;
    size_t size_bytes;
    *out = (struct scene){0};
    int error = blob_file_map(path, &blob, &size_bytes, fault);
    if (error) return error;
    error = scene_open_on(blob, size_bytes, base, out, fault);
    if (error) blob_file_unmap(blob, size_bytes);
    return error;
}

void scene_unmap(struct scene *s)
{
    blob_file_unmap(s->blob, s->blob_bytes);
    *s = (struct scene){0};
}

/* What a blob that has not been checked begins with. */
struct blob_head {
    struct scene_header header;
    struct scene_section_entry table[SCENE_SECTION_COUNT];
};

/* Returns an open file, and 0 in the table's counts for what is no scene; -1 for one that cannot be
 * read. */
static int open_head(const char *path, struct blob_head *head)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    *head = (struct blob_head){0};
    const ssize_t n = fd >= 0 ? pread(fd, head, sizeof *head, 0) : -1;
    if (n != (ssize_t)sizeof *head ||
        memcmp(head->header.magic, SCENE_MAGIC, sizeof head->header.magic) != 0)
        *head = (struct blob_head){0};
    if (n >= 0 || fd < 0) return fd;
    close(fd);
    return -1;
}

/* Reads the first bytes of a section, from a record on. False: they are not all there. */
static bool read_part(int fd, const struct scene_section_entry *section, uint64_t from,
                      size_t size_bytes, void *out)
{
    return section->count > 0 && section->offset < LIMIT_BLOB_BYTES &&
           pread(fd, out, size_bytes, (off_t)(section->offset + from)) == (ssize_t)size_bytes;
}

int scene_find_base(const char *path, struct digest *out)
{
    struct blob_head head;
    const int fd = open_head(path, &head);
    *out = (struct digest){0};
    if (fd < 0) return ERR_IO;
    if (head.table[SCENE_BASE].count != 1 ||
        !read_part(fd, &head.table[SCENE_BASE], 0, sizeof *out, out))
        *out = (struct digest){0};
    close(fd);
    return 0;
}

int scene_find_plate(const char *path, char out[LIMIT_NAME_BYTES])
{
    struct blob_head head;
    struct scene_info info;
    const int fd = open_head(path, &head);
    out[0] = '\0';
    if (fd < 0) return ERR_IO;
    const struct scene_section_entry *names = &head.table[SCENE_NAMES];
    if (read_part(fd, &head.table[SCENE_INFO], 0, sizeof info, &info) && info.plate > 0 &&
        info.plate < names->count) {
        const uint64_t left = names->count - info.plate;
        const size_t most = left < LIMIT_NAME_BYTES ? (size_t)left : LIMIT_NAME_BYTES;
        if (!read_part(fd, names, info.plate, most, out)) out[0] = '\0';
        out[most - 1] = '\0';
    }
    close(fd);
    return 0;
}

const char *scene_name(const struct scene *s, uint32_t name)
{
    return s->names + name;
}
