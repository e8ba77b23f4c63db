#pragma once
/* Warnings of what was ignored or repaired in a scene. Each kind appears once, with its first place
 * and how many more. */
#include <stdint.h>

#include "proto/limits.h"

struct warning {
    char sentence[LIMIT_DETAIL_BYTES];
    char place[LIMIT_POINTER_BYTES]; /* of the first; empty: the scene as a whole */
    uint64_t more;                   /* places after the first */
};

struct warnings {
    struct warning list[LIMIT_WARNINGS];
    uint32_t count;
    uint64_t dropped; /* kinds beyond LIMIT_WARNINGS */
};

/* Adds a sentence about a place, or counts it when the same sentence stands there already. */
void warnings_add(struct warnings *w, const char *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#define WARNING_TEXT_BYTES (LIMIT_DETAIL_BYTES + LIMIT_POINTER_BYTES + 64)

/* Writes a warning such as "meshes[0].primitives[1] and 3 more: vertex colours are ignored". It is
 * valid UTF-8 without control characters, whatever the file held. */
void warnings_text(const struct warnings *w, uint32_t index, char out[WARNING_TEXT_BYTES]);

/* Replaces control characters and all that is not UTF-8 by '?', in place. */
void text_make_printable(char *text);
