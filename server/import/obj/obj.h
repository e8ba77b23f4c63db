#pragma once
/* OBJ with MTL, read by assimp.
 *
 * assimp parses the text and joins the vertices; it opens every file through `files`, so that a
 * hostile mtllib line reaches nothing outside the scene's folder. All else (textures, limits,
 * numbers that are not finite) is checked here. */
#include "server/import/fence/files.h"
#include "server/import/scene/builder.h"

/* `name` and `main` are borrowed for the time of the call. */
int obj_import(struct files *files, const char *name, const struct file_view *main,
               struct builder *builder, struct fault *fault);
