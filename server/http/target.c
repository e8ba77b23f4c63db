#include "server/http/target.h"

#include <stdlib.h>
#include <string.h>

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/* Decodes %xx in place. False for a bad escape or one that gives a control character. */
static bool decode(char *text)
{
    char *out = text;
    for (const char *in = text; *in; in++) {
        int c = (unsigned char)*in;
        if (c == '%') {
            int high = hex_digit(in[1]);
            int low = high < 0 ? -1 : hex_digit(in[2]);
            if (low < 0) return false;
            c = high * 16 + low;
            in += 2;
        }
        if (c < 0x20 || c == 0x7f) return false;
        *out++ = (char)c;
    }
    *out = '\0';
    return true;
}

/* A segment means one thing only if no reader could take it for a way to another folder. */
static bool segment_is_plain(const char *s)
{
    return *s && strcmp(s, ".") != 0 && strcmp(s, "..") != 0 && !strpbrk(s, "/\\");
}

/* Cuts `path` (without its leading slash) at slashes, then decodes the parts. */
static int split_path(char *path, struct target *t, struct fault *fault)
{
    if (!*path) return 0;
    for (char *at = path; at;) {
        char *slash = strchr(at, '/');
        if (slash) *slash = '\0';
        if (!decode(at) || !segment_is_plain(at))
            return fault_set(fault, ERR_SYNTAX, "",
                             "the path has an empty, dotted or badly escaped segment");
        if (t->segment_count == TARGET_SEGMENTS)
            return fault_set(fault, ERR_NOT_FOUND, "", "no resource lies that deep");
        t->segment[t->segment_count++] = at;
        at = slash ? slash + 1 : NULL;
    }
    return 0;
}

static int split_query(char *query, struct target *t, struct fault *fault)
{
    for (char *at = query; at && *at;) {
        char *end = strchr(at, '&');
        if (end) *end = '\0';
        char *value = strchr(at, '=');
        if (value) *value++ = '\0';
        if (!decode(at) || (value && !decode(value)) || !*at)
            return fault_set(fault, ERR_SYNTAX, "", "the query has an empty name or a bad escape");
        if (target_parameter(t, at))
            return fault_set(fault, ERR_SYNTAX, "", "a query parameter is given twice");
        if (t->parameter_count == TARGET_PARAMETERS)
            return fault_set(fault, ERR_SYNTAX, "", "the query has more than %d parameters",
                             TARGET_PARAMETERS);
        t->parameter[t->parameter_count++] = (struct target_parameter){at, value ? value : ""};
        at = end ? end + 1 : NULL;
    }
    return 0;
}

/* Rebuilds the decoded path behind the parts, for look-ups of whole paths. */
static void join_path(struct target *t, char *out)
{
    t->path = out;
    if (t->segment_count == 0) *out++ = '/';
    for (size_t i = 0; i < t->segment_count; i++) {
        size_t n = strlen(t->segment[i]);
        *out++ = '/';
        memcpy(out, t->segment[i], n);
        out += n;
    }
    *out = '\0';
}

/* A request line with a space in its target could be taken apart in two ways. */
static bool is_written_plainly(const char *raw)
{
    for (; *raw; raw++)
        if ((unsigned char)*raw <= 0x20 || *raw == 0x7f) return false;
    return true;
}

int target_read(const char *raw, struct target *out, struct fault *fault)
{
    size_t size_bytes = strnlen(raw, LIMIT_HTTP_URL_BYTES + 1);
    *out = (struct target){0};
    if (size_bytes > LIMIT_HTTP_URL_BYTES)
        return fault_set(fault, ERR_LIMIT, "", "the request target is above %d bytes",
                         LIMIT_HTTP_URL_BYTES);
    if (raw[0] != '/')
        return fault_set(fault, ERR_SYNTAX, "", "the request target must begin with a slash");
    if (!is_written_plainly(raw))
        return fault_set(fault, ERR_SYNTAX, "",
                         "the request target has a space or a control character");
    out->text = malloc(2 * size_bytes + 2);
    if (!out->text) return fault_set(fault, ERR_MEMORY, "", "memory is exhausted");
    memcpy(out->text, raw, size_bytes + 1);
    char *query = strchr(out->text, '?');
    if (query) *query++ = '\0';
    int error = split_path(out->text + 1, out, fault);
    if (!error) error = split_query(query, out, fault);
    if (error) {
        target_fini(out);
        return error;
    }
    join_path(out, out->text + size_bytes + 1);
    return 0;
}

void target_fini(struct target *t)
{
    free(t->text);
    *t = (struct target){0};
}

const char *target_parameter(const struct target *t, const char *name)
{
    for (size_t i = 0; i < t->parameter_count; i++)
        if (strcmp(t->parameter[i].name, name) == 0) return t->parameter[i].value;
    return NULL;
}
