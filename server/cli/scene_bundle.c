#include "server/cli/scene_bundle.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/job/job.h"
#include "proto/json.h"
#include "proto/scene/mtl_map.h"
#include "server/cli/sequence_files.h"

/* Where a sequence's files are among those of a scene. */
#define RGBD_PREFIX "rgbd/"

#define SCENE_TEXT_LIMIT_BYTES (256u << 20)

/* What is being uploaded: the folder of the main file and the names found so far. */
struct bundle {
    struct client *client;
    char folder[2048];  /* with a slash at the end, or empty */
    const char *prefix; /* of the names in `files` */
    json_t *files;      /* relative name -> digest, the document's "files" */
    char material[64];  /* the last that an MTL began; "": none */
    struct fault *fault;
};

static void folder_of(const char *path, char *out, size_t capacity)
{
    const char *slash = strrchr(path, '/');
    size_t n = slash ? (size_t)(slash - path) + 1 : 0;
    if (n >= capacity) n = 0;
    memcpy(out, path, n);
    out[n] = '\0';
}

/* Reads the first bytes of a file, terminated; all of it when it is no larger than `most`. The
 * caller frees it. */
static char *read_start(FILE *f, const char *path, size_t most, size_t *size_bytes,
                        struct fault *fault)
{
    char *text = malloc(most + 1);
    if (!text) {
        fault_set(fault, ERR_MEMORY, "/scene/file", "%s: memory is exhausted", path);
        return NULL;
    }
    rewind(f);
    *size_bytes = fread(text, 1, most, f);
    text[*size_bytes] = '\0';
    return text;
}

/* Reads the text that may name other files: the JSON chunk of a .glb, or the whole file. */
static char *read_text(const char *path, size_t *size_bytes, struct fault *fault)
{
    uint8_t head[20] = {0};
    uint32_t json_bytes;
    char *text = NULL;
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END) != 0) {
        fault_set(fault, ERR_NOT_FOUND, "/scene/file", "%s: %s", path, strerror(errno));
        if (f) fclose(f);
        return NULL;
    }
    long size = ftell(f);
    rewind(f);
    bool glb = fread(head, 1, sizeof head, f) == sizeof head && memcmp(head, "glTF", 4) == 0;
    memcpy(&json_bytes, head + 12, sizeof json_bytes);
    if (glb && json_bytes < size) size = (long)sizeof head + (long)json_bytes;
    if (size < 0 || (unsigned long)size > SCENE_TEXT_LIMIT_BYTES)
        fault_set(fault, ERR_LIMIT, "/scene/file", "%s: too large for a text file", path);
    else
        text = read_start(f, path, (size_t)size, size_bytes, fault);
    fclose(f);
    return text;
}

/* Makes a name the one under which the importer will look, without "." parts. */
static void tidy(const char *name, char *out, size_t capacity)
{
    size_t n = 0;
    while (*name && n + 1 < capacity) {
        bool starts = n == 0 || out[n - 1] == '/';
        if (starts && name[0] == '.' && name[1] == '/')
            name += 2;
        else
            out[n++] = *name++;
    }
    out[n] = '\0';
}

/* Uploads one referred file. A name that is listed already is not uploaded again. */
static int add_file(struct bundle *b, const char *given)
{
    char path[4096], hex[DIGEST_HEX_BYTES], name[LIMIT_PATH_BYTES + 1];
    char listed[LIMIT_PATH_BYTES + 16];
    struct digest digest;
    tidy(given, name, sizeof name);
    snprintf(listed, sizeof listed, "%s%s", b->prefix, name);
    if (json_object_get(b->files, listed)) return 0;
    if (!relative_path_is_inside(name))
        return fault_set(b->fault, ERR_RANGE, "/scene/file",
                         "the scene refers to \"%.200s\", which is not inside its folder", given);
    snprintf(path, sizeof path, "%s%s", b->folder, name);
    int error = client_put_asset(b->client, path, &digest, b->fault);
    if (error) return error;
    digest_to_hex(&digest, hex);
    return json_object_set_new(b->files, listed, json_string(hex)) == 0 ? 0 : ERR_MEMORY;
}

/* %41 -> A in place; glTF URIs are percent-encoded. */
static void percent_decode(char *text)
{
    char *out = text;
    for (const char *in = text; *in; in++) {
        char hex[3] = {in[0] == '%' ? in[1] : '\0', in[0] == '%' && in[1] ? in[2] : '\0', '\0'};
        char *end = hex;
        long value = hex[0] ? strtol(hex, &end, 16) : 0;
        if (end == hex + 2 && value > 0) {
            *out++ = (char)value;
            in += 2;
        } else {
            *out++ = *in;
        }
    }
    *out = '\0';
}

/* Adds the file that an object's `uri` names. */
static int add_uri(struct bundle *b, const json_t *of)
{
    const char *uri = json_string_value(json_object_get(of, "uri"));
    if (!uri || strncmp(uri, "data:", 5) == 0) return 0;
    char *name = strdup(uri);
    if (!name) return ERR_MEMORY;
    percent_decode(name);
    const int error = add_file(b, name);
    free(name);
    return error;
}

static int add_uris(struct bundle *b, const json_t *array)
{
    size_t i;
    json_t *item;
    int error = 0;
    json_array_foreach (array, i, item) {
        error = add_uri(b, item);
        if (error) break;
    }
    return error;
}

/* Adds measured materials' files. */
static int add_measured(struct bundle *b, const json_t *materials)
{
    size_t i;
    json_t *item;
    int error = 0;
    json_array_foreach (materials, i, item) {
        const json_t *extras = json_object_get(item, "extras");
        error = add_uri(b, json_object_get(extras, "shearwater"));
        if (error) break;
    }
    return error;
}

static int add_gltf(struct bundle *b, const char *json, size_t size_bytes)
{
    /* What is wrong with the JSON is the importer's to say: it names the place better. */
    json_t *gltf;
    if (json_read_foreign(json, size_bytes, &gltf) == ERR_MEMORY) return ERR_MEMORY;
    int error = add_uris(b, json_object_get(gltf, "buffers"));
    if (!error) error = add_uris(b, json_object_get(gltf, "images"));
    if (!error) error = add_measured(b, json_object_get(gltf, "materials"));
    json_decref(gltf);
    return error;
}

/* The JSON chunk of a .glb, if it is whole. */
static int add_glb(struct bundle *b, const char *data, size_t size_bytes)
{
    uint32_t length;
    if (size_bytes < 20) return 0;
    memcpy(&length, data + 12, sizeof length);
    return length <= size_bytes - 20 ? add_gltf(b, data + 20, length) : 0;
}

/* Calls `add` for every line of two words or more. */
static int each_line(struct bundle *b, char *text,
                     int (*add)(struct bundle *b, const char *keyword, char *rest))
{
    char *save_line = NULL;
    int error = 0;
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) text += 3;
    for (char *line = strtok_r(text, "\r\n", &save_line); line && !error;
         line = strtok_r(NULL, "\r\n", &save_line)) {
        char *save = NULL, *keyword = strtok_r(line, " \t", &save);
        if (keyword && save) error = add(b, keyword, save);
    }
    return error;
}

/* The maps that the importer reads: others may be missing. */
static bool is_map(const char *keyword)
{
    return strcasecmp(keyword, "map_Kd") == 0 || strcasecmp(keyword, "map_Ke") == 0 ||
           strcasecmp(keyword, "map_emissive") == 0;
}

/* Uploads a map; of one that is missing, tells whose it is. */
static int add_map(struct bundle *b, const char *keyword, char *rest)
{
    struct mtl_map map;
    char detail[LIMIT_DETAIL_BYTES];
    mtl_map_read(rest, &map);
    const int error = map.name[0] ? add_file(b, mtl_name_beside(map.name)) : 0;
    if (error != ERR_NOT_FOUND) return error;
    snprintf(detail, sizeof detail, "%s", b->fault->detail);
    return fault_set(b->fault, error, b->fault->pointer, "%.20s of the material \"%s\": %.350s",
                     keyword, b->material, detail);
}

static int add_mtl_line(struct bundle *b, const char *keyword, char *rest)
{
    if (strcmp(keyword, "newmtl") == 0)
        snprintf(b->material, sizeof b->material, "%s", mtl_name_clean(rest));
    return is_map(keyword) ? add_map(b, keyword, rest) : 0;
}

static bool is_there(const struct bundle *b, const char *name)
{
    char path[4096];
    struct stat is;
    snprintf(path, sizeof path, "%s%s", b->folder, name);
    return stat(path, &is) == 0 && S_ISREG(is.st_mode);
}

/* Of one that is missing the importer will warn. */
static int add_mtl(struct bundle *b, const char *given)
{
    const char *name = mtl_name_beside(given);
    char path[4096];
    size_t size_bytes;
    if (!is_there(b, name)) return 0;
    int error = add_file(b, name);
    if (error) return error;
    snprintf(path, sizeof path, "%s%s", b->folder, name);
    char *text = read_text(path, &size_bytes, b->fault);
    if (!text) return b->fault->code;
    b->material[0] = '\0';
    error = each_line(b, text, add_mtl_line);
    free(text);
    return error;
}

/* A name with spaces, or where no file is called so, several names. */
static int add_libraries(struct bundle *b, const char *keyword, char *rest)
{
    char *save = NULL, *name = mtl_name_clean(rest);
    int error = 0;
    if (strcmp(keyword, "mtllib") != 0 || !name[0]) return 0;
    if (is_there(b, mtl_name_beside(name))) return add_mtl(b, name);
    for (char *one = strtok_r(name, " \t", &save); one && !error;
         one = strtok_r(NULL, " \t", &save))
        error = add_mtl(b, one);
    return error;
}

static int add_references(struct bundle *b, const char *path)
{
    size_t size_bytes;
    char *text = read_text(path, &size_bytes, b->fault);
    if (!text) return b->fault->code;
    int error;
    if (size_bytes >= 4 && memcmp(text, "glTF", 4) == 0)
        error = add_glb(b, text, size_bytes);
    else if (text[strspn(text, " \t\r\n\xef\xbb\xbf")] == '{')
        error = add_gltf(b, text, size_bytes);
    else
        error = each_line(b, text, add_libraries);
    free(text);
    return error;
}

/* {"file": ...} becomes {"asset": ...}. */
static int put_asset(json_t *object, const struct digest *digest)
{
    char hex[DIGEST_HEX_BYTES];
    digest_to_hex(digest, hex);
    json_object_del(object, "file");
    return json_object_set_new(object, "asset", json_string(hex)) == 0 ? 0 : ERR_MEMORY;
}

/* Finds the path of the file that document[member] names; "" when it names none. */
static int file_of(const char *job_path, const json_t *document, const char *member, char *out,
                   size_t capacity, struct fault *fault)
{
    char base[2048], pointer[64];
    const json_t *object = json_object_get(document, member);
    const char *file = json_string_value(json_object_get(object, "file"));
    out[0] = '\0';
    if (!file) return 0;
    snprintf(pointer, sizeof pointer, "/%s", member);
    if (json_object_get(object, "asset"))
        return fault_set(fault, ERR_RANGE, pointer, "give either \"file\" or \"asset\", not both");
    folder_of(job_path, base, sizeof base);
    if ((size_t)snprintf(out, capacity, "%s%s", file[0] == '/' ? "" : base, file) < capacity)
        return 0;
    snprintf(pointer, sizeof pointer, "/%s/file", member);
    return fault_set(fault, ERR_LIMIT, pointer, "the file's name is too long");
}

/* Uploads the file that document[member] names. */
static int upload(struct client *c, const char *path, json_t *document, const char *member,
                  struct fault *fault)
{
    struct digest digest;
    int error = client_put_asset(c, path, &digest, fault);
    const bool of_server = error == ERR_IO || error == ERR_KILLED;
    if (error && !of_server && fault->code && !fault->pointer[0])
        snprintf(fault->pointer, sizeof fault->pointer, "/%s/file", member);
    return error ? error : put_asset(json_object_get(document, member), &digest);
}

static int upload_scene(struct client *c, const char *job_path, json_t *document,
                        struct fault *fault)
{
    struct bundle b = {.client = c, .prefix = "", .fault = fault};
    char path[4096];
    int error = file_of(job_path, document, "scene", path, sizeof path, fault);
    if (error || !path[0]) return error;
    folder_of(path, b.folder, sizeof b.folder);
    b.files = json_object();
    error = b.files ? upload(c, path, document, "scene", fault) : ERR_MEMORY;
    if (!error) error = add_references(&b, path);
    if (!error && json_object_size(b.files) > 0 &&
        json_object_set(json_object_get(document, "scene"), "files", b.files) != 0)
        error = ERR_MEMORY;
    json_decref(b.files);
    return error;
}

static int add_named(void *bundle, const char *name)
{
    return add_file(bundle, name);
}

static int add_sequence_file(struct bundle *b, const char *path)
{
    size_t size_bytes;
    char *text = read_text(path, &size_bytes, b->fault);
    if (!text) return b->fault->code;
    int error = add_file(b, path + strlen(b->folder));
    if (!error) error = sequence_files_each(text, size_bytes, add_named, b);
    free(text);
    return error;
}

/* {"file": ...} becomes {"document": ...}, and its files are among the scene's. */
static int upload_rgbd(struct client *c, const char *job_path, json_t *document,
                       struct fault *fault)
{
    struct bundle b = {.client = c, .prefix = RGBD_PREFIX, .fault = fault};
    json_t *rgbd = json_object_get(document, "rgbd"), *scene = json_object_get(document, "scene");
    char path[4096], name[4096 + sizeof RGBD_PREFIX];
    int error = file_of(job_path, document, "rgbd", path, sizeof path, fault);
    if (error || !path[0]) return error;
    folder_of(path, b.folder, sizeof b.folder);
    if (!json_object_get(scene, "files")) json_object_set_new(scene, "files", json_object());
    b.files = json_object_get(scene, "files");
    error = json_is_object(b.files) ? add_sequence_file(&b, path) : 0;
    if (error && fault->code && strcmp(fault->pointer, "/scene/file") == 0)
        strcpy(fault->pointer, "/rgbd/file");
    snprintf(name, sizeof name, RGBD_PREFIX "%s", path + strlen(b.folder));
    json_object_del(rgbd, "file");
    if (json_object_set_new(rgbd, "document", json_string(name)) != 0 && !error) error = ERR_MEMORY;
    return error;
}

int scene_bundle_upload(struct client *c, const char *job_path, json_t *document,
                        struct fault *fault)
{
    char path[4096];
    int error = upload_scene(c, job_path, document, fault);
    if (!error) error = upload_rgbd(c, job_path, document, fault);
    if (!error) error = file_of(job_path, document, "environment", path, sizeof path, fault);
    if (!error && path[0]) error = upload(c, path, document, "environment", fault);
    if (!error) error = file_of(job_path, document, "backplate", path, sizeof path, fault);
    if (!error && path[0]) error = upload(c, path, document, "backplate", fault);
    return error;
}
