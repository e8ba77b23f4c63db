#include "server/image/exr_mattes.h"

#include <stdatomic.h>
#include <stdlib.h>

struct exr_mattes {
    _Atomic uint32_t references;
    char *manifests[MATTE_KINDS]; /* owned */
};

int exr_mattes_create(char *manifests[MATTE_KINDS], struct exr_mattes **out)
{
    *out = calloc(1, sizeof **out);
    for (int k = 0; k < MATTE_KINDS; k++) {
        if (*out)
            (*out)->manifests[k] = manifests[k];
        else
            free(manifests[k]);
    }
    if (*out) (*out)->references = 1;
    return *out ? 0 : ERR_MEMORY;
}

struct exr_mattes *exr_mattes_hold(struct exr_mattes *mattes)
{
    if (mattes) atomic_fetch_add(&mattes->references, 1);
    return mattes;
}

void exr_mattes_drop(struct exr_mattes **out)
{
    struct exr_mattes *mattes = *out;
    *out = NULL;
    if (!mattes || atomic_fetch_sub(&mattes->references, 1) > 1) return;
    for (int k = 0; k < MATTE_KINDS; k++) free(mattes->manifests[k]);
    free(mattes);
}

const char *exr_mattes_manifest(const struct exr_mattes *mattes, enum matte_kind kind)
{
    return mattes->manifests[kind];
}
