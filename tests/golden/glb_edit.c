/* glb_edit IN.glb PATCH.json OUT.glb: a GLB with its materials changed.
 *
 * PATCH.json holds members of materials by their names, {"Smooth": {"extras": {...}}}, which take
 * the place of what was there. A name that no material has is an error: a test that changes nothing
 * would show nothing. The layout of a GLB: glTF 2.0, section 4.4. */
#include <jansson.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAGIC = 0x46546c67, VERSION = 2, CHUNK_JSON = 0x4e4f534a, HEADER = 12, CHUNK_HEADER = 8 };

struct glb {
    uint8_t *bytes; /* owned */
    size_t size;
    json_t *document;     /* owned */
    size_t rest_at, rest; /* the chunks behind the first */
};

static uint32_t u32_at(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static int complain(const char *path, const char *what)
{
    fprintf(stderr, "glb_edit: %s: %s\n", path, what);
    return -1;
}

static int read_file(const char *path, struct glb *g)
{
    FILE *f = fopen(path, "rb");
    if (!f) return complain(path, "cannot be opened");
    int rc = fseek(f, 0, SEEK_END);
    long size = ftell(f);
    rewind(f);
    if (rc == 0 && size > HEADER + CHUNK_HEADER) g->bytes = malloc((size_t)size);
    if (g->bytes) g->size = fread(g->bytes, 1, (size_t)size, f);
    fclose(f);
    return g->bytes && g->size == (size_t)size ? 0 : complain(path, "cannot be read");
}

static int read_glb(const char *path, struct glb *g)
{
    json_error_t error;
    if (read_file(path, g)) return -1;
    const uint8_t *b = g->bytes;
    size_t length = u32_at(b + HEADER);
    if (u32_at(b) != MAGIC || u32_at(b + 4) != VERSION || u32_at(b + 8) != g->size ||
        u32_at(b + HEADER + 4) != CHUNK_JSON || length > g->size - HEADER - CHUNK_HEADER)
        return complain(path, "is no GLB of version 2");
    g->rest_at = HEADER + CHUNK_HEADER + length;
    g->rest = g->size - g->rest_at;
    g->document = json_loadb((const char *)b + HEADER + CHUNK_HEADER, length, 0, &error);
    return g->document ? 0 : complain(path, error.text);
}

static json_t *find_material(const json_t *document, const char *name)
{
    size_t i;
    json_t *material;
    json_array_foreach (json_object_get(document, "materials"), i, material) {
        const char *its = json_string_value(json_object_get(material, "name"));
        if (its && !strcmp(its, name)) return material;
    }
    return NULL;
}

static int apply(const char *path, json_t *document)
{
    json_error_t error;
    const char *name;
    json_t *members, *patch = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    int rc = json_object_size(patch) > 0 ? 0 : complain(path, patch ? "is empty" : error.text);
    json_object_foreach (patch, name, members) {
        json_t *material = find_material(document, name);
        if (!material || json_object_update(material, members))
            rc = complain(name, "no such material, or no object of members for it");
    }
    json_decref(patch);
    return rc;
}

static void put_u32(uint32_t v, FILE *f)
{
    const uint8_t bytes[4] = {(uint8_t)v, (uint8_t)(v >> 8), (uint8_t)(v >> 16),
                              (uint8_t)(v >> 24)};
    fwrite(bytes, 1, sizeof bytes, f);
}

static int write_glb(const char *path, const struct glb *g)
{
    char *text = json_dumps(g->document, JSON_COMPACT | JSON_REAL_PRECISION(17));
    FILE *f = fopen(path, "wb");
    if (!f || !text) {
        if (f) fclose(f);
        free(text);
        return complain(path, "cannot be written");
    }
    size_t length = strlen(text), padded = (length + 3) / 4 * 4;
    put_u32(MAGIC, f);
    put_u32(VERSION, f);
    put_u32((uint32_t)(HEADER + CHUNK_HEADER + padded + g->rest), f);
    put_u32((uint32_t)padded, f);
    put_u32(CHUNK_JSON, f);
    fprintf(f, "%s%*s", text, (int)(padded - length), "");
    fwrite(g->bytes + g->rest_at, 1, g->rest, f);
    free(text);
    int failed = ferror(f);
    return fclose(f) == 0 && !failed ? 0 : complain(path, "cannot be written");
}

int main(int argc, char **argv)
{
    struct glb g = {0};
    if (argc != 4) {
        fprintf(stderr, "usage: glb_edit IN.glb PATCH.json OUT.glb\n");
        return 2;
    }
    int rc = read_glb(argv[1], &g);
    if (!rc) rc = apply(argv[2], g.document);
    if (!rc) rc = write_glb(argv[3], &g);
    json_decref(g.document);
    free(g.bytes);
    return rc ? 1 : 0;
}
