#include "proto/job/job_marks.h"

#include <stdlib.h>
#include <string.h>

#include "proto/job/job_internal.h"

/* Decodes one character of valid UTF-8 and steps behind it. */
static uint32_t next_character(const unsigned char **text)
{
    const unsigned char *c = *text;
    const int more = *c < 0x80 ? 0 : *c < 0xe0 ? 1 : *c < 0xf0 ? 2 : 3;
    uint32_t character = more == 0 ? *c : *c & (0x3fu >> more);
    for (int i = 1; i <= more && c[i]; i++) character = character << 6 | (c[i] & 0x3fu);
    for (int i = 0; i <= more && **text; i++) (*text)++;
    return character;
}

/* Controls, breaks of lines, and marks that turn the direction of what follows: with these a name
 * could pass for another, or spoil the list that it stands in. */
static bool is_control(uint32_t c)
{
    return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 || c == 0x2029 ||
           (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

static bool is_layout(uint32_t c)
{
    return c == '\n' || c == '\t';
}

/* Counts the characters of a text; *control is the first that is not allowed, 0 for none. */
static size_t count_characters(const char *text, bool layout, uint32_t *control)
{
    const unsigned char *at = (const unsigned char *)text;
    size_t count = 0;
    *control = 0;
    for (; *at; count++) {
        const uint32_t c = next_character(&at);
        if (!*control && is_control(c) && !(layout && is_layout(c))) *control = c;
    }
    return count;
}

static int read_text(struct json_cursor *at, const json_t *v, size_t most, bool layout, char **out)
{
    uint32_t control;
    int error = json_cursor_expect(at, v, JSON_STRING, "a text or null");
    if (error) return error;
    const size_t count = count_characters(json_string_value(v), layout, &control);
    if (count == 0) return json_cursor_refuse(at, ERR_RANGE, "it is empty: leave it out, or null");
    if (count > most)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu characters are above the limit of %zu", count,
                                  most);
    if (control)
        return json_cursor_refuse(at, ERR_RANGE, "it has the control character U+%04X", control);
    *out = strdup(json_string_value(v));
    return *out ? 0 : json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
}

int job_name_read(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    (void)m;
    if (json_is_null(v)) return 0;
    return read_text(at, v, LIMIT_JOB_NAME, false, &((struct job *)o)->marks.name);
}

int job_comment_read(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    (void)m;
    if (json_is_null(v)) return 0;
    return read_text(at, v, LIMIT_JOB_COMMENT, true, &((struct job *)o)->marks.comment);
}

const char *job_label_fault(const char *label)
{
    uint32_t control;
    const size_t count = count_characters(label, false, &control);
    if (count == 0) return "is empty";
    if (count > LIMIT_JOB_LABEL) return "has more than 64 characters";
    if (control) return "has a control character";
    if (strchr(label, ',')) return "has a comma, which parts labels on command lines";
    return NULL;
}
_Static_assert(LIMIT_JOB_LABEL == 64, "the sentence above says so");

static int read_label(struct json_cursor *at, const json_t *v, struct job_marks *marks)
{
    int error = json_cursor_expect(at, v, JSON_STRING, "a label");
    if (error) return error;
    const char *label = json_string_value(v), *fault = job_label_fault(label);
    if (fault) return json_cursor_refuse(at, ERR_RANGE, "the label %s", fault);
    for (uint32_t i = 0; i < marks->label_count; i++)
        if (strcmp(marks->labels[i], label) == 0)
            return json_cursor_refuse(at, ERR_EXISTS, "the label is there twice");
    char *copy = strdup(label);
    if (!copy) return json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
    marks->labels[marks->label_count++] = copy;
    return 0;
}

static int label_order(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

int job_labels_read(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    struct job_marks *marks = &((struct job *)o)->marks;
    (void)m;
    int error = json_cursor_expect(at, v, JSON_ARRAY, "an array of labels");
    if (error) return error;
    if (json_array_size(v) > LIMIT_JOB_LABELS)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu labels are above the limit of %d",
                                  json_array_size(v), LIMIT_JOB_LABELS);
    for (size_t i = 0; !error && i < json_array_size(v); i++) {
        const size_t length = json_cursor_enter_index(at, i);
        error = read_label(at, json_array_get(v, i), marks);
        if (!error) json_cursor_leave(at, length);
    }
    qsort(marks->labels, marks->label_count, sizeof *marks->labels, label_order);
    return error;
}

/* What else is wrong with an address is found where it is called (server/webhook). */
static int read_url(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    (void)m;
    int error = json_cursor_expect(at, v, JSON_STRING, "an http or https URL");
    if (error) return error;
    const char *url = json_string_value(v);
    if (strlen(url) > LIMIT_WEBHOOK_URL_BYTES)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu bytes are above the limit of %d", strlen(url),
                                  LIMIT_WEBHOOK_URL_BYTES);
    if (strncmp(url, "http://", 7) != 0 && strncmp(url, "https://", 8) != 0)
        return json_cursor_refuse(at, ERR_RANGE, "it does not begin with http:// or https://");
    for (const char *c = url; *c; c++)
        if (*c <= ' ' || *c > '~')
            return json_cursor_refuse(at, ERR_RANGE, "a URL has visible ASCII characters only");
    char **out = &((struct job *)o)->marks.webhook;
    *out = strdup(url);
    return *out ? 0 : json_cursor_refuse(at, ERR_MEMORY, "memory is exhausted");
}

static const struct json_member webhook_members[] = {
    {.name = "url", .read = read_url, .required = true}, {.name = NULL}};

int job_webhook_read(struct json_cursor *at, const struct json_member *m, const json_t *v, void *o)
{
    (void)m;
    if (json_is_null(v)) return 0;
    int error = json_cursor_expect(at, v, JSON_OBJECT, "an object with a url, or null");
    return error ? error : json_cursor_members(at, v, webhook_members, o);
}

json_t *job_webhook_write(const char *url)
{
    return url ? json_pack("{s:s}", "url", url) : json_null();
}

json_t *job_text_write(const char *text)
{
    return text ? json_string(text) : json_null();
}

json_t *job_labels_write(const struct job_marks *marks)
{
    json_t *array = json_array();
    int failures = 0;
    for (uint32_t i = 0; i < marks->label_count; i++)
        failures += json_array_append_new(array, json_string(marks->labels[i])) != 0;
    if (failures == 0) return array;
    json_decref(array);
    return NULL;
}

static const struct json_member change_members[] = {{.name = "name", .read = job_name_read},
                                                    {.name = "comment", .read = job_comment_read},
                                                    {.name = "labels", .read = job_labels_read},
                                                    {.name = NULL}};

/* Writes those of `marks` that `given` has; NULL on failed allocation. */
static json_t *write_change(const struct job_marks *marks, const json_t *given)
{
    json_t *change = json_object();
    int failures = 0;
    if (json_object_get(given, "name"))
        failures += json_object_set_new(change, "name", job_text_write(marks->name)) != 0;
    if (json_object_get(given, "comment"))
        failures += json_object_set_new(change, "comment", job_text_write(marks->comment)) != 0;
    if (json_object_get(given, "labels"))
        failures += json_object_set_new(change, "labels", job_labels_write(marks)) != 0;
    if (change && failures == 0) return change;
    json_decref(change);
    return NULL;
}

int job_marks_read_change(const char *text, size_t size_bytes, json_t **out, struct fault *fault)
{
    json_t *root = NULL;
    struct job job = {0};
    struct json_cursor at;
    *out = NULL;
    int error = json_read(text, size_bytes, LIMIT_JOB_BYTES, &root, fault);
    if (error) return error;
    json_cursor_init(&at, fault);
    error = json_cursor_members(&at, root, change_members, &job);
    if (!error && json_object_size(root) == 0)
        error = json_cursor_refuse(&at, ERR_MISSING, "the document changes nothing");
    if (!error && !(*out = write_change(&job.marks, root)))
        error = json_cursor_refuse(&at, ERR_MEMORY, "memory is exhausted");
    job_marks_fini(&job.marks);
    json_decref(root);
    return error;
}

void job_marks_fini(struct job_marks *marks)
{
    free(marks->name);
    free(marks->comment);
    free(marks->webhook);
    for (uint32_t i = 0; i < marks->label_count; i++) free(marks->labels[i]);
    *marks = (struct job_marks){0};
}

int job_marks_copy(const struct job_marks *marks, struct job_marks *out)
{
    *out = (struct job_marks){0};
    if (marks->name) out->name = strdup(marks->name);
    if (marks->comment) out->comment = strdup(marks->comment);
    if (marks->webhook) out->webhook = strdup(marks->webhook);
    for (uint32_t i = 0; i < marks->label_count; i++) {
        out->labels[i] = strdup(marks->labels[i]);
        if (!out->labels[i]) break;
        out->label_count++;
    }
    if (!out->name == !marks->name && !out->comment == !marks->comment &&
        !out->webhook == !marks->webhook && out->label_count == marks->label_count)
        return 0;
    job_marks_fini(out);
    return ERR_MEMORY;
}
