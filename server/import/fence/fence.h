#pragma once
/* The fence around a hostile file: what this process may use and touch from here on.
 *
 * Limits on address space, CPU time, file size and open files; no core dump, no new privileges;
 * where the kernel has Landlock, reading only beneath the root and writing only beside the blob.
 * System calls beyond those that an import needs end the process (syscalls.h): no network, no other
 * programs. Kernels without Landlock (before 5.13, or switched off) leave reading to the rooted
 * opener (files.h), and writing to the rights of the user; without seccomp filters nothing is
 * imported. Builds with sanitizers, which are for tests, have the limits alone. Raised once, after
 * the arguments are read and before any byte of the scene is. */
#include "proto/error.h"

/* `out` is the path of the blob. What the kernel lacks is left out; what it refuses is ERR_IO. */
int fence_raise(const char *root, const char *out, struct fault *fault);
