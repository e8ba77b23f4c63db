#pragma once
/* Where a job moves nodes of its scene to: scene.moves, [{node, translation, rotation_deg}]. */
#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/error.h"
#include "proto/limits.h"

/* Moves a node, or a group of an OBJ, with all beneath it: turned about +y through the middle of
 * its bounds, then shifted. Nodes of one name move as one. */
struct job_move {
    char node[LIMIT_NAME_BYTES];
    float translation[3]; /* default 0 0 0 */
    float rotation_deg;   /* what lies along +x comes to lie along (cos, 0, sin); default 0 */
};

/* Moves of nodes with different names, made one after the other. */
struct job_moves {
    uint32_t count;
    struct job_move list[LIMIT_MOVES];
};

/* Returns whether both move the same nodes to the same places. */
bool job_moves_equal(const struct job_moves *a, const struct job_moves *b);

/* Writes the array, which job_moves_parse reads. Returns a new reference; NULL without memory. */
json_t *job_moves_write(const struct job_moves *moves);
/* Does the same as a text, which the caller frees; NULL where nothing is moved. ERR_MEMORY. */
int job_moves_text(const struct job_moves *moves, char **out);
/* Reads its text. On failure *fault has the code, the JSON pointer and a sentence. */
int job_moves_parse(const char *text, struct job_moves *out, struct fault *fault);
