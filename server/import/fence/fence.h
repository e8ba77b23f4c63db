#pragma once
/* The fence confines the process that reads a hostile file.
 *
 * It limits address space, CPU time, file size and open files, and forbids core dumps and new
 * privileges. With Landlock the process reads only beneath the root and writes only beside the
 * blob. System calls that an import does not need end the process (syscalls.h), so it has no
 * network and starts no programs. On kernels without Landlock (before 5.13, or switched off) the
 * rooted opener (files.h) bounds reading, and the rights of the user bound writing. Without seccomp
 * filters nothing is imported. Builds with sanitizers, which are for tests, have the limits alone.
 * The fence is raised once, after the arguments are read and before any byte of the scene is. */
#include "proto/error.h"

/* Raises the fence. `out` is the path of the blob. It leaves out what the kernel lacks. ERR_IO for
 * what the kernel refuses. */
int fence_raise(const char *root, const char *out, struct fault *fault);
