#pragma once
/* Imports OBJ with MTL by assimp.
 *
 * assimp parses the text and joins the vertices. It opens no other file: mtl.h reads the libraries
 * through `files`, so that a hostile mtllib line reaches nothing outside the scene's folder.
 * Textures, limits and numbers that are not finite are checked here. */
#include "server/import/fence/files.h"
#include "server/import/scene/builder.h"

/* Imports an OBJ. The call borrows `name` and `main`. */
int obj_import(struct files *files, const char *name, const struct file_view *main,
               struct builder *builder, struct fault *fault);
