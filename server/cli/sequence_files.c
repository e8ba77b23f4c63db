#include "server/cli/sequence_files.h"

#include "proto/json.h"

static int add_member(const json_t *of, const char *member, int (*add)(void *, const char *),
                      void *ctx)
{
    const char *name = json_string_value(json_object_get(of, member));
    return name ? add(ctx, name) : 0;
}

int sequence_files_each(const char *text, size_t size_bytes,
                        int (*add)(void *ctx, const char *name), void *ctx)
{
    json_t *sequence, *frame;
    size_t i;
    if (json_read_foreign(text, size_bytes, &sequence) == ERR_MEMORY) return ERR_MEMORY;
    int error = add_member(json_object_get(sequence, "poses"), "file", add, ctx);
    json_array_foreach (json_object_get(sequence, "frames"), i, frame) {
        if (!error) error = add_member(frame, "color", add, ctx);
        if (!error) error = add_member(frame, "depth", add, ctx);
    }
    json_decref(sequence);
    return error;
}
