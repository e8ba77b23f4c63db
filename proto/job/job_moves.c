/* Where a job moves nodes of its scene. */
#include <string.h>

#include "proto/job/job_internal.h"

#define ROTATION_MAX_DEG 360

static int read_node(struct json_cursor *at, const struct json_member *member, const json_t *value,
                     void *object)
{
    struct job_move *move = object;
    const char *name = json_string_value(value);
    (void)member;
    int error = json_cursor_expect(at, value, JSON_STRING, "the name of a node");
    if (error) return error;
    const size_t length = json_string_length(value);
    if (length == 0) return json_cursor_refuse(at, ERR_RANGE, "it names nothing");
    if (length >= sizeof move->node)
        return json_cursor_refuse(at, ERR_LIMIT, "a name of %zu bytes is above the limit of %d",
                                  length, LIMIT_NAME_BYTES - 1);
    memcpy(move->node, name, length + 1);
    return 0;
}

static const struct json_member move_members[] = {
    {.name = "node", .read = read_node, .required = true},
    {.name = "translation",
     .read = json_member_f32x3,
     .offset = offsetof(struct job_move, translation),
     .min = -LIMIT_COORDINATE,
     .max = LIMIT_COORDINATE},
    {.name = "rotation_deg",
     .read = json_member_f32,
     .offset = offsetof(struct job_move, rotation_deg),
     .min = -ROTATION_MAX_DEG,
     .max = ROTATION_MAX_DEG},
    {.name = NULL}};

static int read_move(struct json_cursor *at, const json_t *value, struct job_moves *moves)
{
    struct job_move *move = &moves->list[moves->count];
    memset(move, 0, sizeof *move);
    int error = json_cursor_members(at, value, move_members, move);
    for (uint32_t i = 0; i < moves->count && !error; i++)
        if (strcmp(moves->list[i].node, move->node) == 0)
            error = json_cursor_refuse_member(at, "node", ERR_EXISTS, "\"%s\" is named twice",
                                              move->node);
    if (!error) moves->count++;
    return error;
}

static int read_all(struct json_cursor *at, const json_t *value, struct job_moves *moves)
{
    moves->count = 0;
    int error = json_cursor_expect(at, value, JSON_ARRAY, "an array of moves");
    if (error) return error;
    if (json_array_size(value) > LIMIT_MOVES)
        return json_cursor_refuse(at, ERR_LIMIT, "%zu moves are above the limit of %d",
                                  json_array_size(value), LIMIT_MOVES);
    for (size_t i = 0; i < json_array_size(value) && !error; i++) {
        const size_t length = json_cursor_enter_index(at, i);
        error = read_move(at, json_array_get(value, i), moves);
        if (!error) json_cursor_leave(at, length);
    }
    return error;
}

int job_moves_read(struct json_cursor *at, const struct json_member *member, const json_t *value,
                   void *object)
{
    struct job *job = object;
    (void)member;
    return read_all(at, value, &job->moves);
}

int job_moves_parse(const char *text, struct job_moves *out, struct fault *fault)
{
    struct json_cursor at;
    json_t *list;
    int error = json_read(text, strlen(text), LIMIT_JOB_BYTES, &list, fault);
    if (error) return error;
    json_cursor_init(&at, fault);
    error = read_all(&at, list, out);
    json_decref(list);
    return error;
}

json_t *job_moves_write(const struct job_moves *moves)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < moves->count; i++) {
        const struct job_move *move = &moves->list[i];
        json_t *one = json_pack("{s:s,s:o,s:o}", "node", move->node, "translation",
                                job_number_write3(move->translation), "rotation_deg",
                                job_number_write(move->rotation_deg));
        if (one && json_array_append_new(list, one) == 0) continue;
        json_decref(list);
        return NULL;
    }
    return list;
}

int job_moves_text(const struct job_moves *moves, char **out)
{
    *out = NULL;
    if (moves->count == 0) return 0;
    json_t *list = job_moves_write(moves);
    *out = json_text(list, JSON_COMPACT);
    json_decref(list);
    return *out ? 0 : ERR_MEMORY;
}

bool job_moves_equal(const struct job_moves *a, const struct job_moves *b)
{
    return a->count == b->count && memcmp(a->list, b->list, a->count * sizeof *a->list) == 0;
}
