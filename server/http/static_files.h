#pragma once
/* The viewer's files and the contract, read once at start into memory. Requests are looked up in
 * this list by their whole path: nothing from a URL ever reaches the file system. */
#include <stddef.h>

#include "proto/error.h"
#include "server/http/etag.h"

struct static_file {
    char path[128]; /* "/index.html" */
    const char *type;
    char etag[ETAG_BYTES];
    char *data; /* owned */
    size_t size_bytes;
};

struct static_files;

/* Loads the plain files with known endings in web_dir and its folders, without those that begin
 * with a dot, and without links. openapi_path becomes "/openapi.yaml". Either may be NULL. ERR_IO,
 * ERR_LIMIT, ERR_MEMORY; *fault names the file. */
int static_files_load(const char *web_dir, const char *openapi_path, struct static_files **out,
                      struct fault *fault);
void static_files_destroy(struct static_files **files);

/* Finds a file by its path; "/" is "/index.html". NULL: no such file. */
const struct static_file *static_files_find(const struct static_files *files, const char *path);
