#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "proto/json.h"

/* Longest piece of input that a sentence repeats. */
#define ECHO_BYTES 64

void json_cursor_init(struct json_cursor *at, struct fault *fault)
{
    at->fault = fault;
    at->length = 0;
    at->pointer[0] = '\0';
}

/* Appends what fits; a pointer that is cut still says roughly where. */
static void append(struct json_cursor *at, const char *text)
{
    const size_t room = sizeof at->pointer - 1 - at->length, length = strlen(text);
    const size_t take = length < room ? length : room;
    memcpy(at->pointer + at->length, text, take);
    at->length += take;
    at->pointer[at->length] = '\0';
}

size_t json_cursor_enter(struct json_cursor *at, const char *key)
{
    const size_t length = at->length, room = sizeof at->pointer - 1 - length;
    char printable[LIMIT_POINTER_BYTES] = "";
    if (room > sizeof "/...") json_printable(key, printable, room);
    append(at, "/");
    for (const char *c = printable; *c; c++) {
        const char one[2] = {*c, '\0'};
        append(at, *c == '~' ? "~0" : *c == '/' ? "~1" : one); /* RFC 6901 */
    }
    return length;
}

size_t json_cursor_enter_index(struct json_cursor *at, size_t index)
{
    char key[24];
    snprintf(key, sizeof key, "%zu", index);
    return json_cursor_enter(at, key);
}

void json_cursor_leave(struct json_cursor *at, size_t length)
{
    at->length = length;
    at->pointer[length] = '\0';
}

static int refuse(struct json_cursor *at, int code, const char *format, va_list arguments)
{
    char detail[LIMIT_DETAIL_BYTES];
    vsnprintf(detail, sizeof detail, format, arguments);
    return fault_set(at->fault, code, at->pointer, "%s", detail);
}

int json_cursor_refuse(struct json_cursor *at, int code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    refuse(at, code, format, arguments);
    va_end(arguments);
    return code;
}

int json_cursor_refuse_member(struct json_cursor *at, const char *key, int code, const char *format,
                              ...)
{
    va_list arguments;
    const size_t length = json_cursor_enter(at, key);
    va_start(arguments, format);
    refuse(at, code, format, arguments);
    va_end(arguments);
    json_cursor_leave(at, length);
    return code;
}

const char *json_type_name(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "a boolean";
    default:
        return "null";
    }
}

static int refuse_type(struct json_cursor *at, const json_t *value, const char *what)
{
    return json_cursor_refuse(at, ERR_TYPE, "it is %s and must be %s", json_type_name(value), what);
}

int json_cursor_expect(struct json_cursor *at, const json_t *value, json_type type,
                       const char *what)
{
    return json_typeof(value) == type ? 0 : refuse_type(at, value, what);
}

/* Edits (insert, delete, replace) from a to b, or more than `most`. */
static size_t edit_distance(const char *a, const char *b, size_t most)
{
    size_t row[ECHO_BYTES + 1];
    const size_t n = strlen(a), m = strlen(b);
    if (n > ECHO_BYTES || m > ECHO_BYTES) return most + 1;
    for (size_t j = 0; j <= m; j++) row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            const size_t replace = diagonal + (a[i - 1] != b[j - 1]);
            const size_t insert = row[j - 1] + 1, remove = row[j] + 1;
            diagonal = row[j];
            row[j] = insert < remove ? insert : remove;
            if (replace < row[j]) row[j] = replace;
        }
    }
    return row[m];
}

/* Returns how many edits still count as a slip of the same word. */
static size_t slip_of(const char *word)
{
    const size_t length = strlen(word);
    return length <= 3 ? 1 : length <= 6 ? 2 : 3;
}

/* The nearest of the names seen so far. */
struct guess {
    const char *name;
    size_t distance;
};

static void guess_try(struct guess *guess, const char *text, const char *name)
{
    const size_t distance = edit_distance(text, name, slip_of(name));
    if (distance > slip_of(name)) return;
    if (!guess->name || distance < guess->distance) *guess = (struct guess){name, distance};
}

static const struct json_member *find_member(const struct json_member *table, const char *name)
{
    for (; table->name; table++)
        if (strcmp(table->name, name) == 0) return table;
    return NULL;
}

static int refuse_unknown(struct json_cursor *at, const struct json_member *table, const char *key)
{
    struct guess guess = {NULL, 0};
    char echo[ECHO_BYTES];
    json_printable(key, echo, sizeof echo);
    for (const struct json_member *m = table; m->name; m++) guess_try(&guess, key, m->name);
    if (guess.name)
        return json_cursor_refuse_member(at, key, ERR_UNKNOWN_MEMBER,
                                         "\"%s\" is unknown; did you mean \"%s\"?", echo,
                                         guess.name);
    return json_cursor_refuse_member(at, key, ERR_UNKNOWN_MEMBER, "\"%s\" is unknown", echo);
}

int json_cursor_members(struct json_cursor *at, const json_t *value,
                        const struct json_member *table, void *object)
{
    const char *key;
    json_t *child;
    int error = json_cursor_expect(at, value, JSON_OBJECT, "an object");
    if (error) return error;
    json_object_foreach ((json_t *)(uintptr_t)value, key, child) {
        const struct json_member *m = find_member(table, key);
        if (!m) return refuse_unknown(at, table, key);
        const size_t length = json_cursor_enter(at, key);
        error = m->read(at, m, child, object);
        if (error) return error;
        json_cursor_leave(at, length);
    }
    for (const struct json_member *m = table; m->name; m++)
        if (m->required && !json_object_get(value, m->name))
            return json_cursor_refuse_member(at, m->name, ERR_MISSING, "\"%s\" is required",
                                             m->name);
    return 0;
}

int json_cursor_number(struct json_cursor *at, const json_t *value, double min, double max,
                       double *out)
{
    if (!json_is_number(value)) return refuse_type(at, value, "a number");
    const double v = json_number_value(value);
    if (!isfinite(v)) return json_cursor_refuse(at, ERR_NOT_FINITE, "it is not finite");
    if (v < min) return json_cursor_refuse(at, ERR_RANGE, "%.9g is below %.9g", v, min);
    if (v > max) return json_cursor_refuse(at, ERR_RANGE, "%.9g is above %.9g", v, max);
    *out = v;
    return 0;
}

int json_cursor_whole(struct json_cursor *at, const json_t *value, int64_t min, int64_t max,
                      int64_t *out)
{
    int64_t v;
    if (!json_is_number(value)) return refuse_type(at, value, "a whole number");
    if (json_is_integer(value)) {
        v = json_integer_value(value);
    } else {
        const double real = json_real_value(value);
        if (real != floor(real))
            return json_cursor_refuse(at, ERR_TYPE, "%.9g is not a whole number", real);
        if (fabs(real) > 0x1p62)
            return json_cursor_refuse(at, ERR_RANGE, "%.9g is not in %lld..%lld", real,
                                      (long long)min, (long long)max);
        v = (int64_t)real;
    }
    if (v < min)
        return json_cursor_refuse(at, ERR_RANGE, "%lld is below %lld", (long long)v,
                                  (long long)min);
    if (v > max)
        return json_cursor_refuse(at, ERR_RANGE, "%lld is above %lld", (long long)v,
                                  (long long)max);
    *out = v;
    return 0;
}

int json_cursor_digest(struct json_cursor *at, const json_t *value, struct digest *out)
{
    const int error = json_cursor_expect(at, value, JSON_STRING, "a SHA-256 digest");
    if (error) return error;
    if (digest_from_hex(json_string_value(value), out) == 0) return 0;
    return json_cursor_refuse(at, ERR_SYNTAX, "it is not 64 lower-case hexadecimal digits");
}

static void *field(const struct json_member *m, void *object)
{
    return (char *)object + m->offset;
}

/* Compared as floats, so that a limit that is no exact float admits its own decimal. */
static int read_f32(struct json_cursor *at, const struct json_member *m, const json_t *v,
                    float *out)
{
    double number = 0.0;
    const int error = json_cursor_number(at, v, -INFINITY, INFINITY, &number);
    if (error) return error;
    *out = (float)number;
    if (*out < (float)m->min)
        return json_cursor_refuse(at, ERR_RANGE, "%.9g is below %.7g", number, m->min);
    if (*out > (float)m->max)
        return json_cursor_refuse(at, ERR_RANGE, "%.9g is above %.7g", number, m->max);
    return 0;
}

int json_member_f32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    return read_f32(at, m, v, field(m, o));
}

int json_member_f32x3(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    float *out = field(m, o);
    int error = json_cursor_expect(at, v, JSON_ARRAY, "an array of three numbers");
    if (error) return error;
    if (json_array_size(v) != 3)
        return json_cursor_refuse(at, ERR_TYPE, "it has %zu elements and must have 3",
                                  json_array_size(v));
    for (size_t i = 0; i < 3; i++) {
        const size_t length = json_cursor_enter_index(at, i);
        error = read_f32(at, m, json_array_get(v, i), &out[i]);
        if (error) return error;
        json_cursor_leave(at, length);
    }
    return 0;
}

int json_member_i32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    int64_t whole = 0;
    const int error = json_cursor_whole(at, v, (int64_t)m->min, (int64_t)m->max, &whole);
    if (error) return error;
    *(int32_t *)field(m, o) = (int32_t)whole;
    return 0;
}

int json_member_u32(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    int64_t whole = 0;
    const int error = json_cursor_whole(at, v, (int64_t)m->min, (int64_t)m->max, &whole);
    if (error) return error;
    *(uint32_t *)field(m, o) = (uint32_t)whole;
    return 0;
}

int json_member_u64(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    int64_t whole = 0;
    const int error = json_cursor_whole(at, v, (int64_t)m->min, (int64_t)m->max, &whole);
    if (error) return error;
    *(uint64_t *)field(m, o) = (uint64_t)whole;
    return 0;
}

int json_member_bool(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    if (!json_is_boolean(v)) return refuse_type(at, v, "true or false");
    *(bool *)field(m, o) = json_is_true(v);
    return 0;
}

int json_member_digest(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    return json_cursor_digest(at, v, field(m, o));
}

static int refuse_choice(struct json_cursor *at, const struct json_choice *choices,
                         const char *text)
{
    struct guess guess = {NULL, 0};
    char echo[ECHO_BYTES];
    json_printable(text, echo, sizeof echo);
    for (; choices->name; choices++) guess_try(&guess, text, choices->name);
    if (guess.name)
        return json_cursor_refuse(at, ERR_RANGE, "\"%s\" is unknown; did you mean \"%s\"?", echo,
                                  guess.name);
    return json_cursor_refuse(at, ERR_RANGE, "\"%s\" is unknown", echo);
}

int json_member_choice(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    const int error = json_cursor_expect(at, v, JSON_STRING, "a string");
    if (error) return error;
    const char *text = json_string_value(v);
    for (const struct json_choice *c = m->choices; c->name; c++) {
        if (strcmp(c->name, text) != 0) continue;
        if (c->unsupported) return json_cursor_refuse(at, ERR_UNSUPPORTED, "%s", c->unsupported);
        *(uint32_t *)field(m, o) = c->value;
        return 0;
    }
    return refuse_choice(at, m->choices, text);
}

int json_member_object(struct json_cursor *at, const struct json_member *m, const json_t *v,
                       void *o)
{
    return json_cursor_members(at, v, m->members, o);
}

int json_member_unsupported(struct json_cursor *at, const struct json_member *m, const json_t *v,
                            void *o)
{
    (void)v;
    (void)o;
    return json_cursor_refuse(at, ERR_UNSUPPORTED, "%s", m->sentence);
}
