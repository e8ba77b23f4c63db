#include "server/job/job_counts.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static struct job_count **place_of(struct job_counts *counts, const char *owner)
{
    struct job_count **at = &counts->first;
    while (*at && strcmp((*at)->owner, owner) != 0) at = &(*at)->next;
    return at;
}

int job_counts_take(struct job_counts *counts, const char *owner, size_t most)
{
    struct job_count **at = place_of(counts, owner);
    if (*at && most > 0 && (*at)->jobs >= most) return ERR_QUOTA;
    if (!*at) {
        struct job_count *fresh = calloc(1, sizeof *fresh);
        if (!fresh) return ERR_MEMORY;
        assert(strlen(owner) < sizeof fresh->owner);
        memcpy(fresh->owner, owner, strlen(owner) + 1);
        *at = fresh;
    }
    (*at)->jobs++;
    return 0;
}

void job_counts_give(struct job_counts *counts, const char *owner)
{
    struct job_count **at = place_of(counts, owner), *one = *at;
    assert(one && one->jobs > 0);
    if (--one->jobs > 0) return;
    *at = one->next;
    free(one);
}

void job_counts_fini(struct job_counts *counts)
{
    struct job_count *one;
    while ((one = counts->first)) {
        counts->first = one->next;
        free(one);
    }
}
