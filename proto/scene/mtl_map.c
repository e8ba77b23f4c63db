#include "proto/scene/mtl_map.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What an option has behind it. */
enum arguments { ONE_WORD, NUMBERS };

static const struct {
    const char *name;
    enum arguments arguments;
    bool drawn; /* or changes nothing that is drawn */
} options[] = {
    {"-blendu", ONE_WORD, true}, {"-blendv", ONE_WORD, true},   {"-bm", ONE_WORD, false},
    {"-boost", ONE_WORD, false}, {"-cc", ONE_WORD, false},      {"-clamp", ONE_WORD, true},
    {"-mm", NUMBERS, false},     {"-imfchan", ONE_WORD, false}, {"-o", NUMBERS, true},
    {"-s", NUMBERS, true},       {"-t", NUMBERS, false},        {"-texres", ONE_WORD, true},
    {"-type", ONE_WORD, true},
};
#define OPTION_COUNT (sizeof options / sizeof options[0])

char *mtl_name_clean(char *name)
{
    name += strspn(name, " \t");
    size_t n = strlen(name);
    while (n > 0 && isspace((unsigned char)name[n - 1])) name[--n] = '\0';
    if (n >= 2 && name[0] == '"' && name[n - 1] == '"') {
        name[n - 1] = '\0';
        name++;
    }
    char *to = name;
    for (const char *c = name; *c; c++) {
        const char byte = *c == '\\' ? '/' : *c; /* as written on Windows, where some write two */
        if (byte != '/' || to < name + 2 || to[-1] != '/') *to++ = byte;
    }
    *to = '\0';
    return name;
}

const char *mtl_name_beside(const char *name)
{
    const bool has_drive = isalpha((unsigned char)name[0]) && name[1] == ':';
    const char *slash = strrchr(name, '/');
    if (has_drive || name[0] == '/' || strncmp(name, "../", 3) == 0 || strstr(name, "/../"))
        return slash ? slash + 1 : name + 2 * has_drive;
    return name;
}

void mtl_skip_mark(const char **text, size_t *size_bytes)
{
    if (*size_bytes < 3 || memcmp(*text, "\xef\xbb\xbf", 3) != 0) return;
    *text += 3;
    *size_bytes -= 3;
}

static size_t word_length(const char *at)
{
    return strcspn(at, " \t\r\n");
}

/* Copies the word at `at`, cut, for comparisons. */
static void copy_word(const char *at, char out[MTL_OPTION_BYTES])
{
    snprintf(out, MTL_OPTION_BYTES, "%.*s", (int)word_length(at), at);
}

static char *next_word(char *at)
{
    at += word_length(at);
    return at + strspn(at, " \t");
}

/* Takes up to three numbers; a word that is none, or the last one of the line, is the name's. */
static char *take_numbers(char *at, float *first, float *second)
{
    for (int i = 0; i < 3; i++) {
        char *end;
        const float value = strtof(at, &end);
        if (end == at || end != at + word_length(at) || !*next_word(at)) break;
        if (i == 0 && first) *first = value;
        if (i == 1 && second) *second = value;
        at = next_word(at);
    }
    return at;
}

static char *take_option(char *at, size_t option, struct mtl_map *out)
{
    char word[MTL_OPTION_BYTES];
    const char *name = options[option].name;
    if (!options[option].drawn && !out->ignored[0])
        snprintf(out->ignored, sizeof out->ignored, "%s", name);
    at = next_word(at);
    if (strcmp(name, "-s") == 0) return take_numbers(at, &out->scale[0], &out->scale[1]);
    if (strcmp(name, "-o") == 0) return take_numbers(at, &out->offset[0], &out->offset[1]);
    if (options[option].arguments == NUMBERS) return take_numbers(at, NULL, NULL);
    copy_word(at, word);
    if (strcmp(name, "-clamp") == 0) out->clamp = strcmp(word, "on") == 0;
    return next_word(at);
}

void mtl_map_read(char *line, struct mtl_map *out)
{
    *out = (struct mtl_map){.scale = {1, 1}};
    char *at = line + strspn(line, " \t");
    while (*at == '-') {
        char word[MTL_OPTION_BYTES];
        size_t option = 0;
        copy_word(at, word);
        while (option < OPTION_COUNT && strcmp(options[option].name, word) != 0) option++;
        if (option == OPTION_COUNT) break; /* a name may begin so */
        at = take_option(at, option, out);
    }
    out->name = mtl_name_clean(at);
}
