#pragma once
/* A scene at several times: a base, and a blob for each time. */
#include "server/import/fence/files.h"
#include "server/import/import.h"

/* Does what import_scene does with times. `b` is the base's builder, or the whole scene's where
 * nothing moves. */
int sequence_import(struct files *files, const char *name, const struct scene_choice *choice,
                    const struct file_view *main, const char *out, struct builder *b,
                    struct import_stats *stats, struct fault *fault);

/* Reads a scene file as a whole, at the choice's time. */
int scene_read(struct files *files, const char *name, const struct scene_choice *choice,
               const struct file_view *main, struct builder *b, struct fault *fault);

/* Finds lights among the meshes, adds a camera where there is none, and finishes the builder. */
int scene_finish(struct builder *b, const struct scene_choice *choice, struct fault *fault);
