#pragma once
/* What an EXR file tells of its layers of ids (Cryptomatte): their manifests. They are shared by
 * the frames and files of a scene; any thread may hold and drop them. */
#include "proto/scene/matte.h"

struct exr_mattes;

/* Takes the manifests, of enum matte_kind; NULL: the file has no such layer. ERR_MEMORY, which
 * frees them. */
int exr_mattes_create(char *manifests[MATTE_KINDS], struct exr_mattes **out);
struct exr_mattes *exr_mattes_hold(struct exr_mattes *mattes); /* NULL is ignored */
void exr_mattes_drop(struct exr_mattes **mattes);              /* likewise; nulls the pointer */

/* Returns a layer's manifest; NULL: there is none. */
const char *exr_mattes_manifest(const struct exr_mattes *mattes, enum matte_kind kind);
