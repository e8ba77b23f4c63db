#include "server/import/obj/mtl.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "proto/scene/mtl_map.h"

#define LINE_BYTES 2048 /* longer lines are cut: names are at most 512 bytes */

enum kind { NUMBERS, OPACITY, TRANSPARENCY, IMAGE, IGNORED_IMAGE };

/* Keywords, compared without regard to case, as writers differ. */
#define ROW(word, kind, bit, field, numbers)                                                       \
    {                                                                                              \
        word, kind, bit, offsetof(struct mtl_material, field), numbers                             \
    }
static const struct {
    const char *word;
    enum kind kind;
    uint32_t bit;
    size_t offset;
    int numbers;
} keywords[] = {
    ROW("Kd", NUMBERS, MTL_KD, kd, 3),
    ROW("Ks", NUMBERS, MTL_KS, ks, 3),
    ROW("Ke", NUMBERS, MTL_KE, ke, 3),
    ROW("Tf", NUMBERS, MTL_TF, tf, 3),
    ROW("Ns", NUMBERS, MTL_NS, ns, 1),
    ROW("Ni", NUMBERS, MTL_NI, ni, 1),
    ROW("Pm", NUMBERS, MTL_PM, pm, 1),
    ROW("Pr", NUMBERS, MTL_PR, pr, 1),
    ROW("illum", NUMBERS, MTL_ILLUM, illum, 1),
    ROW("d", OPACITY, MTL_D, d, 1),
    ROW("Tr", TRANSPARENCY, MTL_D, d, 1),
    ROW("map_Kd", IMAGE, 0, map_kd, 0),
    ROW("map_Ke", IMAGE, 0, map_ke, 0),
    ROW("map_emissive", IMAGE, 0, map_ke, 0),
    ROW("map_d", IMAGE, 0, map_d, 0),
    ROW("map_Tr", IMAGE, 0, map_d, 0),
    ROW("map_Ks", IGNORED_IMAGE, MTL_MAP_KS, ns, 0),
    ROW("map_Ns", IGNORED_IMAGE, MTL_MAP_KS, ns, 0),
    ROW("map_Pm", IGNORED_IMAGE, MTL_MAP_METAL, ns, 0),
    ROW("map_Pr", IGNORED_IMAGE, MTL_MAP_METAL, ns, 0),
    ROW("map_Bump", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
    ROW("map_Kn", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
    ROW("bump", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
    ROW("norm", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
    ROW("disp", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
    ROW("map_disp", IGNORED_IMAGE, MTL_MAP_BUMP, ns, 0),
};
#define KEYWORD_COUNT (sizeof keywords / sizeof keywords[0])

/* A text that is read line by line. */
struct text {
    const char *at, *end;
    const char *file;
    unsigned line;
};

static struct text text_of(const struct file_view *view, const char *file)
{
    const char *at = (const char *)view->data;
    size_t size_bytes = view->size_bytes;
    mtl_skip_mark(&at, &size_bytes);
    return (struct text){at, at + size_bytes, file, 0};
}

static int out_of_memory(struct fault *fault)
{
    return fault_set(fault, ERR_MEMORY, "mtllib", "no memory for materials");
}

/* Copies the next line without its end; false at the text's end. */
static bool next_line(struct text *t, char line[LINE_BYTES])
{
    if (t->at == t->end) return false;
    size_t n = 0;
    while (t->at + n < t->end && t->at[n] != '\n' && t->at[n] != '\r') n++;
    const size_t kept = n < LINE_BYTES - 1 ? n : LINE_BYTES - 1;
    memcpy(line, t->at, kept);
    line[kept] = '\0';
    for (char *c = line; c < line + kept; c++)
        if (*c == '\0') *c = ' ';
    t->at += n;
    if (t->at < t->end && *t->at == '\r') t->at++;
    if (t->at < t->end && *t->at == '\n') t->at++;
    t->line++;
    return true;
}

/* Splits a line into its first word and the rest. */
static char *split(char *line, char **rest)
{
    char *word = line + strspn(line, " \t");
    *rest = word + strcspn(word, " \t");
    if (**rest) *(*rest)++ = '\0';
    return word;
}

static void *field(struct mtl_material *m, size_t offset)
{
    return (char *)m + offset;
}

/* Reads up to `count` numbers; of a colour with one it is grey, as the format has it. */
static bool read_numbers(const char *rest, int count, float *out)
{
    int got = 0;
    for (; got < count; got++) {
        char *end;
        out[got] = strtof(rest, &end);
        if (end == rest) break;
        rest = end;
    }
    if (got == 0) return false;
    for (int i = got; i < count; i++) out[i] = out[0];
    return true;
}

static int read_image(const struct text *t, const char *word, char *rest, struct mtl_image *out,
                      struct warnings *warnings, struct fault *fault)
{
    struct mtl_map map;
    mtl_map_read(rest, &map);
    if (map.ignored[0]) {
        char place[LIMIT_POINTER_BYTES];
        snprintf(place, sizeof place, "%.180s:%u", t->file, t->line);
        text_make_printable(place);
        warnings_add(warnings, place, "the option %s of %s is ignored", map.ignored, word);
    }
    if (!map.name[0] || out->name != NULL) return 0;
    *out = (struct mtl_image){.name = strdup(map.name), .clamp = map.clamp};
    memcpy(out->scale, map.scale, sizeof out->scale);
    memcpy(out->offset, map.offset, sizeof out->offset);
    return out->name != NULL ? 0 : out_of_memory(fault);
}

static int read_keyword(const struct text *t, const char *word, char *rest, struct mtl_material *m,
                        struct warnings *warnings, struct fault *fault)
{
    float values[3] = {0};
    size_t k = 0;
    while (k < KEYWORD_COUNT && strcasecmp(keywords[k].word, word) != 0) k++;
    if (k == KEYWORD_COUNT) return 0;
    switch (keywords[k].kind) {
    case IMAGE:
        return read_image(t, keywords[k].word, rest, field(m, keywords[k].offset), warnings, fault);
    case IGNORED_IMAGE:
        m->given |= keywords[k].bit;
        return 0;
    case OPACITY: /* -halo is an effect of its own, which is not drawn */
        rest += strspn(rest, " \t");
        if (strncmp(rest, "-halo", 5) == 0) rest += 5;
        break;
    default:
        break;
    }
    if (!read_numbers(rest, keywords[k].numbers, values)) return 0;
    if (keywords[k].kind == TRANSPARENCY) values[0] = 1 - values[0];
    memcpy(field(m, keywords[k].offset), values, (size_t)keywords[k].numbers * sizeof values[0]);
    m->given |= keywords[k].bit;
    return 0;
}

static int add_material(struct mtl *mtl, char *name, struct fault *fault)
{
    if (mtl->count == LIMIT_MATERIALS)
        return fault_set(fault, ERR_LIMIT, "mtllib", "the libraries have more than %u materials",
                         LIMIT_MATERIALS);
    if ((mtl->count & (mtl->count - 1)) == 0) { /* doubles at powers of two */
        const size_t capacity = mtl->count > 0 ? 2 * (size_t)mtl->count : 1;
        struct mtl_material *list = realloc(mtl->list, capacity * sizeof *list);
        if (list == NULL) return out_of_memory(fault);
        mtl->list = list;
    }
    mtl->list[mtl->count] = (struct mtl_material){.name = strdup(mtl_name_clean(name))};
    return mtl->list[mtl->count++].name != NULL ? 0 : out_of_memory(fault);
}

static int read_library(struct mtl *mtl, struct text *t, struct warnings *warnings,
                        struct fault *fault)
{
    char line[LINE_BYTES], *rest;
    const uint32_t first = mtl->count;
    int rc = 0;
    while (rc == 0 && next_line(t, line)) {
        const char *word = split(line, &rest);
        if (strcmp(word, "newmtl") == 0)
            rc = add_material(mtl, rest, fault);
        else if (mtl->count > first)
            rc = read_keyword(t, word, rest, &mtl->list[mtl->count - 1], warnings, fault);
    }
    return rc;
}

static int read_file(struct mtl *mtl, struct files *files, const char *obj_name, const char *name,
                     struct warnings *warnings, struct fault *fault)
{
    char path[LIMIT_PATH_BYTES];
    struct file_view view;
    const char *beside = mtl_name_beside(name);
    if (beside[0] == '\0' || strcmp(beside, "..") == 0)
        return fault_set(fault, ERR_NOT_FOUND, "mtllib", "\"%.200s\" is a folder", name);
    int rc = files_resolve(obj_name, beside, false, path, "mtllib", fault);
    if (rc == 0) rc = files_map(files, path, "mtllib", &view, fault);
    if (rc != 0) return rc;
    struct text t = text_of(&view, path);
    rc = read_library(mtl, &t, warnings, fault);
    files_unmap(&view);
    return rc;
}

/* As read_file, but a file that is missing is found to be so. */
static int try_file(struct mtl *mtl, struct files *files, const char *obj_name, const char *name,
                    struct warnings *warnings, bool *missing, struct fault *fault)
{
    const int rc = read_file(mtl, files, obj_name, name, warnings, fault);
    *missing = rc == ERR_NOT_FOUND;
    if (rc == 0 && mtl_name_beside(name) != name)
        warnings_add(warnings, "mtllib", "\"%.200s\" is taken from beside the scene, as \"%.200s\"",
                     name, mtl_name_beside(name));
    return *missing ? 0 : rc;
}

static void warn_missing(struct warnings *warnings, const char *name)
{
    warnings_add(warnings, "mtllib", "the file \"%.200s\" is missing: its materials are grey",
                 name);
}

/* One library, whose name may have spaces; or, where no file is called so, several. What is missing
 * is left out, as other programs do: people pass OBJ files on without them. */
static int read_libraries(struct mtl *mtl, struct files *files, const char *obj_name, char *rest,
                          struct warnings *warnings, struct fault *fault)
{
    char *save = NULL, *name = mtl_name_clean(rest), words[LINE_BYTES];
    bool missing = false, found = false;
    if (!name[0]) return 0;
    int rc = try_file(mtl, files, obj_name, name, warnings, &missing, fault);
    if (rc != 0 || !missing) return rc;
    struct warnings of_words = {0};
    snprintf(words, sizeof words, "%s", name);
    for (char *one = strtok_r(words, " \t", &save); one && rc == 0;
         one = strtok_r(NULL, " \t", &save)) {
        rc = try_file(mtl, files, obj_name, one, warnings, &missing, fault);
        if (missing) warn_missing(&of_words, one);
        found = found || !missing;
    }
    for (uint32_t i = 0; found && i < of_words.count; i++)
        warnings_add(warnings, "mtllib", "%s", of_words.list[i].sentence);
    if (!found) warn_missing(warnings, name);
    return rc;
}

int mtl_read(struct mtl *mtl, struct files *files, const char *obj_name,
             const struct file_view *obj, struct warnings *warnings, struct fault *fault)
{
    char line[LINE_BYTES], *rest;
    struct text t = text_of(obj, obj_name);
    int rc = 0;
    *mtl = (struct mtl){0};
    while (rc == 0 && next_line(&t, line))
        if (strcmp(split(line, &rest), "mtllib") == 0)
            rc = read_libraries(mtl, files, obj_name, rest, warnings, fault);
    if (rc != 0) mtl_fini(mtl);
    return rc;
}

void mtl_fini(struct mtl *mtl)
{
    for (uint32_t i = 0; i < mtl->count; i++) {
        struct mtl_material *m = &mtl->list[i];
        free(m->name);
        free(m->map_kd.name);
        free(m->map_ke.name);
        free(m->map_d.name);
    }
    free(mtl->list);
    *mtl = (struct mtl){0};
}

const struct mtl_material *mtl_find(const struct mtl *mtl, const char *name)
{
    for (uint32_t i = 0; i < mtl->count; i++)
        if (strcmp(mtl->list[i].name, name) == 0) return &mtl->list[i];
    return NULL;
}
