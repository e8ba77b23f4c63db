#include "server/import/fence/fence.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "server/import/fence/syscalls.h"

/* Sanitizers reserve terabytes of address space for their shadow, and read /proc at the end. */
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define UNDER_SANITIZER true
#endif
#endif
#if defined(UNDER_SANITIZER)
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define UNDER_SANITIZER true
#else
#define UNDER_SANITIZER false
#endif

/* The root, the out folder, standard streams, one scene file at a time, and some room. */
#define OPEN_FILES 64

/* After the soft limit SIGXCPU is told; this much later the kernel kills. */
#define CPU_GRACE_S 5

static int limit(__rlimit_resource_t resource, uint64_t soft, uint64_t hard, const char *name,
                 struct fault *fault)
{
    struct rlimit now, wanted = {(rlim_t)soft, (rlim_t)hard};
    if (getrlimit(resource, &now) == 0) { /* never above what the parent allows */
        if (wanted.rlim_max > now.rlim_max) wanted.rlim_max = now.rlim_max;
        if (wanted.rlim_cur > wanted.rlim_max) wanted.rlim_cur = wanted.rlim_max;
        if (wanted.rlim_cur > now.rlim_cur) wanted.rlim_cur = now.rlim_cur;
    }
    if (setrlimit(resource, &wanted) == 0) return 0;
    return fault_set(fault, ERR_IO, "fence", "the limit on %s is refused: %s", name,
                     strerror(errno));
}

static int limit_resources(struct fault *fault)
{
    int rc = 0;
    if (!UNDER_SANITIZER)
        rc =
            limit(RLIMIT_AS, LIMIT_IMPORT_MEMORY_BYTES, LIMIT_IMPORT_MEMORY_BYTES, "memory", fault);
    if (rc == 0)
        rc = limit(RLIMIT_CPU, LIMIT_IMPORT_CPU_S, LIMIT_IMPORT_CPU_S + CPU_GRACE_S, "CPU time",
                   fault);
    if (rc == 0) rc = limit(RLIMIT_FSIZE, LIMIT_BLOB_BYTES, LIMIT_BLOB_BYTES, "file size", fault);
    if (rc == 0) rc = limit(RLIMIT_NOFILE, OPEN_FILES, OPEN_FILES, "open files", fault);
    if (rc == 0) rc = limit(RLIMIT_CORE, 0, 0, "core dumps", fault);
    return rc;
}

static bool allow_beneath(int ruleset, const char *path, uint64_t access)
{
    struct landlock_path_beneath_attr rule = {.allowed_access = access};
    rule.parent_fd = open(path, O_PATH | O_CLOEXEC);
    if (rule.parent_fd < 0) return false;
    long rc = syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
    close(rule.parent_fd);
    return rc == 0;
}

/* The folder of a path; "." for a bare name. */
static void folder_of(const char *path, char out[LIMIT_PATH_BYTES * 8])
{
    const char *slash = strrchr(path, '/');
    size_t length = slash == NULL ? 0 : slash == path ? 1 : (size_t)(slash - path);
    snprintf(out, LIMIT_PATH_BYTES * 8, "%.*s", (int)length, length == 0 ? "" : path);
    if (length == 0) snprintf(out, LIMIT_PATH_BYTES * 8, ".");
}

/* Best effort: without Landlock the rooted opener still stands. Returns false when a kernel that
 * has it refuses. */
static bool raise_landlock(const char *root, const char *out)
{
    const uint64_t read = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
    const uint64_t write = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE |
                           LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REMOVE_FILE;
    /* All that version 1 knows; later versions add to it but keep its meaning. */
    struct landlock_ruleset_attr attr = {.handled_access_fs =
                                             (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1};
    long ruleset = syscall(SYS_landlock_create_ruleset, &attr, sizeof attr, 0);
    if (ruleset < 0) return true; /* not in this kernel, or switched off */
    char folder[LIMIT_PATH_BYTES * 8];
    folder_of(out, folder);
    bool ok = allow_beneath((int)ruleset, root, read) &&
              allow_beneath((int)ruleset, folder, write) &&
              syscall(SYS_landlock_restrict_self, (int)ruleset, 0) == 0;
    close((int)ruleset);
    return ok;
}

int fence_raise(const char *root, const char *out, struct fault *fault)
{
    int rc = limit_resources(fault);
    if (rc != 0) return rc;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return fault_set(fault, ERR_IO, "fence", "no_new_privs is refused: %s", strerror(errno));
    if (!UNDER_SANITIZER && !raise_landlock(root, out))
        return fault_set(fault, ERR_IO, "fence", "Landlock rules for \"%s\" are refused: %s", root,
                         strerror(errno));
    if (!UNDER_SANITIZER && syscalls_confine() != 0)
        return fault_set(fault, ERR_UNSUPPORTED, "fence",
                         "this kernel has no seccomp filters (CONFIG_SECCOMP_FILTER), and scenes "
                         "are not imported without: %s",
                         strerror(errno));
    return 0;
}
