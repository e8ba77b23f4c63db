#pragma once
/* Objects in a sequence whose frames show one model of the place (rgbd/rgbd_model.h), at several
 * times: the model is the base, which is made once. */
#include "server/import/fence/files.h"
#include "server/import/import.h"

/* Does what import_scene does with times and a sequence that is fused. `b` is the base's builder.
 */
int fused_import(struct files *files, const char *name, const struct scene_choice *choice,
                 const struct file_view *main, const char *out, struct builder *b,
                 struct import_stats *stats, struct fault *fault);
