#include "worker/link/parcel.h"

#include <stdlib.h>

struct parcel *parcel_take(struct bytes_writer *w)
{
    struct parcel *p = w->failed ? NULL : calloc(1, sizeof *p);
    if (!p) {
        bytes_writer_fini(w);
        return NULL;
    }
    *p = (struct parcel){.refs = 1, .size_bytes = w->size_bytes, .data = w->data};
    bytes_writer_init(w);
    return p;
}

struct parcel *parcel_ref(struct parcel *p)
{
    p->refs++;
    return p;
}

void parcel_unref(struct parcel **parcel)
{
    struct parcel *p = *parcel;
    *parcel = NULL;
    if (!p || --p->refs > 0) return;
    free(p->data);
    free(p);
}
