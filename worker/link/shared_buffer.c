#include "worker/link/shared_buffer.h"

#include <stdlib.h>

struct shared_buffer *shared_buffer_take(struct bytes_writer *w)
{
    struct shared_buffer *p = w->failed ? NULL : calloc(1, sizeof *p);
    if (!p) {
        bytes_writer_fini(w);
        return NULL;
    }
    *p = (struct shared_buffer){.refs = 1, .size_bytes = w->size_bytes, .data = w->data};
    bytes_writer_init(w);
    return p;
}

struct shared_buffer *shared_buffer_ref(struct shared_buffer *p)
{
    p->refs++;
    return p;
}

void shared_buffer_unref(struct shared_buffer **buffer)
{
    struct shared_buffer *p = *buffer;
    *buffer = NULL;
    if (!p || --p->refs > 0) return;
    free(p->data);
    free(p);
}
