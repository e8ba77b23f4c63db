#include "proto/json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whether memory for a value of this thread was missing since the last text. jansson 2.14 ignores a
 * token that cannot grow, and reads one byte less. Code that builds an object would have to check
 * every member to find a missing one. */
static _Thread_local bool lacks;

static void *noticed_malloc(size_t size_bytes)
{
    void *memory = malloc(size_bytes);
    if (!memory) lacks = true;
    return memory;
}

__attribute__((constructor)) static void notice(void)
{
    json_set_alloc_funcs(noticed_malloc, free);
}

/* Dumps twice, since into a buffer that is large enough nothing is appended that may fail. */
static char *text_of(const json_t *value, size_t flags)
{
    const size_t size_bytes = json_dumpb(value, NULL, 0, flags);
    char *text = size_bytes > 0 ? malloc(size_bytes + 1) : NULL;
    if (!text) return NULL;
    if (json_dumpb(value, text, size_bytes, flags) != size_bytes) {
        free(text);
        return NULL;
    }
    text[size_bytes] = '\0';
    return text;
}

char *json_text(const json_t *value, size_t flags)
{
    char *text = lacks || !value ? NULL : text_of(value, flags);
    lacks = false;
    return text;
}

void json_begin(void)
{
    lacks = false;
}

json_t *json_words(const char *text)
{
    const bool lacked = lacks;
    lacks = false;
    json_t *value = json_string(text);
    const bool is_utf8 = value || lacks;
    lacks = lacks || lacked;
    if (is_utf8) return value;
    char plain[LIMIT_DETAIL_BYTES];
    size_t n = 0;
    for (; text[n] && n + 1 < sizeof plain; n++)
        plain[n] = (unsigned char)text[n] < 0x80 ? text[n] : '?';
    plain[n] = '\0';
    return json_string(plain);
}

void json_printable(const char *text, char *out, size_t capacity)
{
    static const char digits[] = "0123456789abcdef";
    size_t at = 0;
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        const bool plain = c >= 0x20 && c < 0x7f;
        const size_t need = plain ? 1 : 4;
        if (at + need + sizeof "..." > capacity) {
            memcpy(out + at, "...", 3);
            at += 3;
            break;
        }
        if (plain) {
            out[at++] = (char)c;
            continue;
        }
        out[at++] = '\\';
        out[at++] = 'x';
        out[at++] = digits[c >> 4];
        out[at++] = digits[c & 15];
    }
    out[at] = '\0';
}

/* Returns the deepest nesting of brackets outside strings, since jansson recurses, and counts how
 * many values there are at most, since each is an allocation. */
static size_t nesting(const char *text, size_t size_bytes, size_t *values)
{
    size_t depth = 0, deepest = 0;
    *values = 1;
    bool in_string = false;
    for (size_t i = 0; i < size_bytes; i++) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\') i++;
            if (c == '"') in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            depth++;
            ++*values;
            if (depth > deepest) deepest = depth;
        } else if ((c == ']' || c == '}') && depth > 0) {
            depth--;
        } else if (c == ',') {
            ++*values;
        }
    }
    return deepest;
}

static int code_of(enum json_error_code code)
{
    switch (code) {
    case json_error_out_of_memory:
        return ERR_MEMORY;
    case json_error_numeric_overflow:
        return ERR_RANGE;
    default:
        return ERR_SYNTAX;
    }
}

/* Loads the whole document or none: ERR_MEMORY also where jansson does not report it. */
static int load(const char *text, size_t size_bytes, size_t flags, json_t **out,
                json_error_t *error)
{
    const bool lacked = lacks;
    lacks = false;
    *out = json_loadb(text, size_bytes, flags, error);
    const bool whole = !lacks;
    lacks = lacked;
    if (*out && whole) return 0;
    json_decref(*out);
    *out = NULL;
    return whole ? code_of(json_error_code(error)) : ERR_MEMORY;
}

int json_read_foreign(const char *text, size_t size_bytes, json_t **out)
{
    json_error_t error;
    return load(text, size_bytes, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, out, &error);
}

int json_read(const char *text, size_t size_bytes, size_t limit_bytes, json_t **out,
              struct fault *fault)
{
    json_error_t error;
    char what[JSON_ERROR_TEXT_LENGTH];
    if (size_bytes > limit_bytes)
        return fault_set(fault, ERR_LIMIT, "", "%zu bytes are above the limit of %zu", size_bytes,
                         limit_bytes);
    if (size_bytes == 0) return fault_set(fault, ERR_SYNTAX, "", "there is no document");
    size_t values;
    const size_t depth = nesting(text, size_bytes, &values);
    if (depth > LIMIT_JSON_DEPTH)
        return fault_set(fault, ERR_LIMIT, "", "it is nested %zu deep, above the limit of %d",
                         depth, LIMIT_JSON_DEPTH);
    if (values > LIMIT_JSON_VALUES && limit_bytes <= LIMIT_JOB_BYTES)
        return fault_set(fault, ERR_LIMIT, "", "it has %zu values, above the limit of %d", values,
                         LIMIT_JSON_VALUES);
    const int code = load(text, size_bytes, JSON_REJECT_DUPLICATES, out, &error);
    if (!code) return 0;
    if (code == ERR_MEMORY) return fault_set(fault, code, "", "%s", error_text(code));
    json_printable(error.text, what, sizeof what);
    return fault_set(fault, code, "", "line %d, column %d: %s", error.line, error.column, what);
}
