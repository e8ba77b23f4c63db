#pragma once
/* JSON by the project's rules, and a cursor that reads objects by tables of members and knows at
 * each fault which JSON pointer it stands at. */
#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/digest.h"
#include "proto/error.h"

/* Reads JSON with the project's rules: at most limit_bytes, no duplicates, depth at most
 * LIMIT_JSON_DEPTH, valid UTF-8; where limit_bytes is at most LIMIT_JOB_BYTES, at most
 * LIMIT_JSON_VALUES values. The caller owns *out. ERR_LIMIT (size, depth), ERR_SYNTAX,
 * ERR_RANGE (a number that no double or 64-bit integer holds), ERR_MEMORY. */
int json_read(const char *text, size_t size_bytes, size_t limit_bytes, json_t **out,
              struct fault *fault);

/* Reads what another program wrote: any value, of any size, by jansson's own rules (nested 2048
 * deep at most, no \u0000) and without duplicates. The caller owns *out, NULL with an error.
 * ERR_SYNTAX, ERR_RANGE, ERR_MEMORY, as of json_read. */
int json_read_foreign(const char *text, size_t size_bytes, json_t **out);

/* Returns the text of a value, which the caller frees. NULL for NULL and without memory, also if
 * memory was missing since this thread's last text: what was built meanwhile may lack members. So
 * one thread builds a value and its text in one piece of work, and a value that is kept for later
 * is checked as it is built. `flags` are jansson's, such as JSON_COMPACT. It replaces json_dumps,
 * which in 2.14 leaves out the quote behind a key when there is no memory for it. */
char *json_text(const json_t *value, size_t flags);

/* Forgets earlier failures of this thread, at the start of a piece of work. */
void json_begin(void);

/* Writes `text` as printable ASCII, other bytes as \xNN, cut with "..." to fit. For echoing
 * input. */
void json_printable(const char *text, char *out, size_t capacity);

/* Returns a string of text that may quote input, at most LIMIT_DETAIL_BYTES of it; NULL without
 * memory. jansson refuses text that is no UTF-8, as where it is cut inside a sequence; every byte
 * beyond ASCII becomes a question mark then. */
json_t *json_words(const char *text);

/* Returns "an object", "a number", for sentences about a value of the wrong type. Static
 * storage. */
const char *json_type_name(const json_t *value);

struct json_cursor {
    struct fault *fault; /* may be NULL */
    size_t length;       /* of pointer */
    char pointer[LIMIT_POINTER_BYTES];
};

/* One of a member's words. `unsupported`: a sentence if this version cannot do it. */
struct json_choice {
    const char *name;
    uint32_t value;
    const char *unsupported;
};

struct json_member;
typedef int (*json_member_read)(struct json_cursor *at, const struct json_member *member,
                                const json_t *value, void *object);

/* A member that an object may have. `read` stores the value at `offset` of the object. */
struct json_member {
    const char *name;
    json_member_read read;
    size_t offset;
    double min, max; /* numbers: both ends allowed unless the reader says else */
    bool required;
    const struct json_choice *choices; /* ends with a NULL name */
    const struct json_member *members; /* ends with a NULL name */
    const char *sentence;              /* json_member_unsupported */
};

void json_cursor_init(struct json_cursor *at, struct fault *fault);

/* Steps into a member or an element; leave with the length that enter returned. */
size_t json_cursor_enter(struct json_cursor *at, const char *key);
size_t json_cursor_enter_index(struct json_cursor *at, size_t index);
void json_cursor_leave(struct json_cursor *at, size_t length);

/* Refuses the value that the cursor stands at; returns code. */
int json_cursor_refuse(struct json_cursor *at, int code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Does the same for a member of the object that the cursor stands at. */
int json_cursor_refuse_member(struct json_cursor *at, const char *key, int code, const char *format,
                              ...) __attribute__((format(printf, 4, 5)));

/* Checks the type of a value. ERR_TYPE unless it is `type`; `what` says what is expected: "a
 * number". */
int json_cursor_expect(struct json_cursor *at, const json_t *value, json_type type,
                       const char *what);

/* Reads an object by a table: unknown members are refused (with a guess at what was meant), and so
 * is the absence of required ones. */
int json_cursor_members(struct json_cursor *at, const json_t *value,
                        const struct json_member *table, void *object);

/* Reads a number in [min, max]. */
int json_cursor_number(struct json_cursor *at, const json_t *value, double min, double max,
                       double *out);

/* Reads a whole number in [min, max], which lie within +-2^53; 9.0 is one. */
int json_cursor_whole(struct json_cursor *at, const json_t *value, int64_t min, int64_t max,
                      int64_t *out);

/* Reads a SHA-256 as 64 lower-case hexadecimal digits. */
int json_cursor_digest(struct json_cursor *at, const json_t *value, struct digest *out);

/* Readers for tables. They store the value in the member's field of the object. */
int json_member_f32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o);
int json_member_f32x3(struct json_cursor *at, const struct json_member *m, const json_t *v,
                      void *o);
int json_member_i32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o);
int json_member_u32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o);
int json_member_u64(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o);
int json_member_bool(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o);

int json_member_digest(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o);

/* Reads one of the words in `choices`, as uint32_t. */
int json_member_choice(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o);

/* Reads an object by `members` into the same object as its parent; offsets count from there. */
int json_member_object(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o);

/* Refuses any value with ERR_UNSUPPORTED and `sentence`. */
int json_member_unsupported(struct json_cursor *at, const struct json_member *m, const json_t *v,
                            void *o);
