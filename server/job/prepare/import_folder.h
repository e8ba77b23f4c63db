#pragma once
/* The folder that an importer works in:
 *
 *   DIR/in/              the scene's files under their relative names, and the main file
 *   DIR/out/scene.blob   what it makes of them
 *
 * There are two folders because the importer's fence lets it write beneath the blob's folder, and
 * the files in `in` are second names of stored assets. */
#include "proto/job/job.h"
#include "server/store/objects.h"

struct import_folder {
    char dir[OBJECTS_PATH_BYTES];
    char root[OBJECTS_PATH_BYTES + 8];
    char main_name[64]; /* in root */
    char blob[OBJECTS_PATH_BYTES + 24];
};

/* Makes and fills the folder. Blocking. ERR_NOT_FOUND for an asset that is gone, ERR_MAGIC for a
 * main file of no known kind, ERR_EXISTS for two files of one name. On failure nothing is left. */
int import_folder_make(const struct objects *objects, const struct digest *scene,
                       const struct job_file *files, uint32_t file_count, struct import_folder *out,
                       struct fault *fault);
void import_folder_remove(struct import_folder *folder);

/* Returns ".glb", ".gltf", ".obj", ".hdr", ".exr", ".png", ".jpg" or ".webp" by the first bytes of
 * a file; NULL: none of them. */
const char *import_folder_sniff(const void *head, size_t size_bytes);
