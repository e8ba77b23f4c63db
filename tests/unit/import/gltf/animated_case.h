#pragma once
/* glTF documents with animations, over one file of numbers. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/unit/import/scene_room.h"
#include "tests/unit/unit.h"

#define HALF_ROOT 0.70710678f

/* The bytes behind the accessors, which have these names in documents as "@name". */
struct series {
    const char *name;
    unsigned components, count;
    float values[36];
};
static const struct series series[] = {
    {"positions", 3, 3, {0, 0, 0, 1, 0, 0, 0, 1, 0}},
    {"target", 3, 3, {0, 0, 3, 0, 0, 3, 0, 0, 3}},
    {"times", 1, 3, {1, 2, 4}},
    {"steps", 3, 3, {0, 0, 0, 2, 0, 0, 2, 8, 0}},
    {"turns", 4, 3, {0, 0, 0, 1, 0, 0, HALF_ROOT, HALF_ROOT, 0, 0, -1, 0}}, /* by 0, 90, 180 */
    {"cubic", 3, 9, {9, 9, 9, 1, 0, 0, 2, 0, 0, -1, 0, 0, 3, 0,
                     0, 0, 4, 0, 0, 0, 0, 5, 5, 5,  9, 9, 9}},
    {"weights", 1, 3, {0, 1, .5f}},
    {"back", 1, 3, {1, 3, 2}},
    {"nan", 1, 3, {1, NAN, 4}},
    {"nowhere", 4, 3, {0}},
    {"lost", 3, 3, {0, 0, 0, NAN, 0, 0, INFINITY, 0, 0}},
    {"colors", 4, 3, {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1}},
    {"cubic_turns", 4, 9, {0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2}},
    {"twice", 1, 3, {1, 1, 4}},
    {"flags", 1, 3, {1, 0, 1}},
    {"angles", 1, 3, {.5f, 1, 1.5f}},
    {"mirrors", 3, 3, {1, 1, 1, -1, 1, 1, 1, 1, 1}},
};
#define SERIES_COUNT (sizeof series / sizeof series[0])

/* Replaces each "@name" by the accessor's number. */
static inline void put_numbers(const char *from, char *out)
{
    while (*from) {
        unsigned i = 0;
        if (*from != '@') {
            *out++ = *from++;
            continue;
        }
        const size_t length = strspn(++from, "abcdefghijklmnopqrstuvwxyz_");
        while (strlen(series[i].name) != length || strncmp(series[i].name, from, length) != 0)
            assert_true(++i < SERIES_COUNT);
        out += sprintf(out, "%u", i);
        from += length;
    }
    *out = '\0';
}

/* Writes a document with buffers, accessors, and the rest. */
static inline const char *document(const char *rest)
{
    static char text[16384];
    char *at = text + sprintf(text,
                              "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": "
                              "\"d.bin\", \"byteLength\": %zu}], \"bufferViews\": [",
                              sizeof series);
    for (unsigned i = 0; i < SERIES_COUNT; i++)
        at += sprintf(at, "%s{\"buffer\": 0, \"byteOffset\": %zu, \"byteLength\": %zu}",
                      i ? "," : "", (size_t)((const char *)series[i].values - (const char *)series),
                      (size_t)series[i].components * series[i].count * sizeof(float));
    at += sprintf(at, "], \"accessors\": [");
    for (unsigned i = 0; i < SERIES_COUNT; i++)
        at += sprintf(at,
                      "%s{\"bufferView\": %u, \"componentType\": 5126, \"count\": %u, \"type\": "
                      "\"%s%.0u\"}",
                      i ? "," : "", i, series[i].count, series[i].components > 1 ? "VEC" : "SCALAR",
                      series[i].components > 1 ? series[i].components : 0);
    at += sprintf(at, "], ");
    put_numbers(rest, at);
    return strcat(text, "}");
}

#define MESH                                                                                       \
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": @positions}, \"material\": "   \
    "0, \"targets\": [{\"POSITION\": @target}]}]}], \"materials\": [{}], "
#define NODE "\"scenes\": [{\"nodes\": [0]}], \"nodes\": [{\"mesh\": 0}], "
#define SAMPLER(input, output, curve)                                                              \
    "{\"input\": @" input ", \"output\": @" output ", \"interpolation\": \"" curve "\"}"
#define CHANNEL(sampler, path)                                                                     \
    "{\"sampler\": " #sampler ", \"target\": {\"node\": 0, \"path\": \"" path "\"}}"
#define POINTER(sampler, pointer)                                                                  \
    "{\"sampler\": " #sampler ", \"target\": {\"path\": \"pointer\", \"extensions\": "             \
    "{\"KHR_animation_pointer\": {\"pointer\": \"" pointer "\"}}}}"
#define ANIMATION(name, samplers, channels)                                                        \
    "{\"name\": \"" name "\", \"samplers\": [" samplers "], \"channels\": [" channels "]}"
#define ANIMATIONS(list) "\"animations\": [" list "]"
#define MOVED(input, output, curve, path)                                                          \
    MESH NODE ANIMATIONS(ANIMATION("a", SAMPLER(input, output, curve), CHANNEL(0, path)))
