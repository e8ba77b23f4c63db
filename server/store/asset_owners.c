#include "server/store/asset_owners.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "server/store/job_store.h"
#include "server/store/marks.h"

#define KIND_BYTES (JOB_OWNER_BYTES + 8)

bool asset_owners_is_name(const char *owner)
{
    size_t n = strspn(owner, "abcdefghijklmnopqrstuvwxyz0123456789-_");
    return n > 0 && n < JOB_OWNER_BYTES && owner[n] == '\0';
}

static bool kind_of(const char *owner, char out[KIND_BYTES])
{
    if (!asset_owners_is_name(owner)) return false;
    snprintf(out, KIND_BYTES, "owners/%.64s", owner);
    return true;
}

int asset_owners_add(const struct objects *o, const char *owner, const struct digest *d,
                     bool *existed)
{
    char kind[KIND_BYTES];
    *existed = false;
    return kind_of(owner, kind) ? marks_add(o, kind, d, existed) : ERR_LIMIT;
}

int asset_owners_remove(const struct objects *o, const char *owner, const struct digest *d)
{
    char kind[KIND_BYTES];
    return kind_of(owner, kind) ? marks_remove(o, kind, d) : ERR_LIMIT;
}

bool asset_owners_have(const struct objects *o, const char *owner, const struct digest *d)
{
    char kind[KIND_BYTES];
    return kind_of(owner, kind) && marks_have(o, kind, d);
}

bool asset_owners_any(const struct objects *o, const struct digest *d)
{
    char path[OBJECTS_PATH_BYTES];
    const struct dirent *entry;
    bool found = false;
    if (snprintf(path, sizeof path, "%s/owners", o->dir) >= (int)sizeof path) return true;
    DIR *dir = opendir(path);
    if (!dir) return errno != ENOENT;
    while (!found && (entry = readdir(dir))) found = asset_owners_have(o, entry->d_name, d);
    closedir(dir);
    return found;
}

struct sum {
    const struct objects *objects;
    uint64_t bytes;
};

static void add_size(void *ctx, const struct digest *d)
{
    struct sum *sum = ctx;
    uint64_t size_bytes;
    if (objects_have(sum->objects, d, &size_bytes)) sum->bytes += size_bytes;
}

int asset_owners_sum(const struct objects *o, const char *owner, uint64_t *bytes)
{
    char kind[KIND_BYTES];
    struct sum sum = {.objects = o};
    *bytes = 0;
    if (!kind_of(owner, kind)) return ERR_LIMIT;
    const int error = marks_each(o, kind, add_size, &sum);
    *bytes = sum.bytes;
    return error;
}
