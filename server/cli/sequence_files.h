#pragma once
/* The files that the document of a sequence of colour and depth names. */
#include <stddef.h>

/* Calls `add` with each name until it fails, and returns what it returned last. What is wrong with
 * the document is the importer's to say. ERR_MEMORY. */
int sequence_files_each(const char *text, size_t size_bytes,
                        int (*add)(void *ctx, const char *name), void *ctx);
