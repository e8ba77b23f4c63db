/* The lock of a data folder: one coordinator has it, and what cannot be locked is told from what is
 * locked. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "server/cli/directories.h"
#include "tests/unit/unit.h"

static int failure; /* of flock; 0: it works */

/* It is this flock that is called. */
int flock(int fd, int operation)
{
    if (failure == 0) return (int)syscall(SYS_flock, fd, operation);
    errno = failure;
    return -1;
}

static char dir[64];

static int make_dir(void **state)
{
    (void)state;
    failure = 0;
    snprintf(dir, sizeof dir, "/tmp/shearwater-test-data-XXXXXX");
    return mkdtemp(dir) ? 0 : -1;
}

static int remove_dir(void **state)
{
    char lock[96];
    (void)state;
    snprintf(lock, sizeof lock, "%s/serve.lock", dir);
    unlink(lock);
    return rmdir(dir);
}

TEST(one_coordinator_has_a_folder)
{
    int first = -1, second = -1;
    struct fault fault = {0};
    assert_int_equal(directories_lock(dir, &first, &fault), 0);
    assert_int_equal(directories_lock(dir, &second, &fault), ERR_EXISTS);
    assert_non_null(strstr(fault.detail, "another coordinator"));
    close(second);
    close(first);
    assert_int_equal(directories_lock(dir, &first, &fault), 0);
    close(first);
}

TEST(a_file_system_without_locks_is_told_of)
{
    static const int failures[] = {ENOLCK, EOPNOTSUPP, ENOSYS};
    for (size_t i = 0; i < sizeof failures / sizeof failures[0]; i++) {
        int fd = -1;
        struct fault fault = {0};
        failure = failures[i];
        assert_int_equal(directories_lock(dir, &fd, &fault), ERR_UNSUPPORTED);
        assert_non_null(strstr(fault.detail, "cannot lock"));
        close(fd);
    }
}

EACH_TEST(make_dir, remove_dir);
