#include "server/store/removal_notes.h"

#define KIND "removals"

int removal_notes_add(const struct objects *o, const struct digest *d)
{
    bool existed;
    return marks_add(o, KIND, d, &existed);
}

void removal_notes_forget(const struct objects *o, const struct digest *d)
{
    (void)marks_remove(o, KIND, d);
}

void removal_notes_each(const struct objects *o, marks_found each, void *ctx)
{
    (void)marks_each(o, KIND, each, ctx);
}
