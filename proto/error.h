#pragma once
/* Codes, names and sentences of everything that can go wrong: one table, error.def.
 *
 * Functions return 0 or a negative ERR_ code. Where a person must be told which place and which
 * value is at fault, the function also fills a struct fault. */
#include "proto/limits.h"

enum error_code {
#define ERROR(name, number, text) ERR_##name = (number),
#include "proto/error.def"
#undef ERROR
};

/* Where and why a document or a buffer was refused. `pointer` is a JSON pointer ("/image/width")
 * or a place in the field's own words ("meshes[3].material"); `detail` is one sentence that names
 * the value. Both are always terminated. */
struct fault {
    int code;
    char pointer[LIMIT_POINTER_BYTES];
    char detail[LIMIT_DETAIL_BYTES];
};

/* Returns a code's name: "RANGE" for ERR_RANGE, "UNKNOWN" for a number that is no code. Static
 * storage. */
const char *error_name(int code);

/* Returns the code for an errno of reading or writing: ERR_NO_SPACE for a full disk or quota,
 * ERR_MEMORY, else ERR_IO. */
int error_of_errno(int number);

/* Returns the sentence of a code. Static storage. */
const char *error_text(int code);

/* Fills *fault (which may be NULL) and returns code, so that it can end a function. */
int fault_set(struct fault *fault, int code, const char *pointer, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
