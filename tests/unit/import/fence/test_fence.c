/* The fence from inside: a process behind it that turns bad ends, or gets nothing. */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/import/fence/fence.h"
#include "tests/unit/unit.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define UNDER_SANITIZER true
#else
#define UNDER_SANITIZER false
#endif

static char base[] = "/tmp/shearwater-fence-XXXXXX";
static char root[128], blob[128], outside[128];

static int make_folders(void **state)
{
    (void)state;
    if (!mkdtemp(base)) return -1;
    snprintf(root, sizeof root, "%s/root", base);
    snprintf(blob, sizeof blob, "%s/out/blob", base);
    snprintf(outside, sizeof outside, "%s/secret", base);
    char folder[128];
    snprintf(folder, sizeof folder, "%s/out", base);
    FILE *f = fopen(outside, "w");
    if (!f || mkdir(root, 0700) != 0 || mkdir(folder, 0700) != 0) return -1;
    fputs("secret", f);
    return fclose(f);
}

static int remove_folders(void **state)
{
    char command[256];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", base);
    return system(command);
}

ALL_TESTS(make_folders, remove_folders);

/* The wait status of a child that does something behind the fence; its exit status is what that
 * returned, 100 when there was no fence. */
static int behind(int (*act)(void))
{
    fflush(NULL);
    const pid_t pid = fork();
    if (pid == 0) {
        struct fault fault;
        if (fence_raise(root, blob, &fault) != 0) _exit(100);
        _exit(act());
    }
    int status = -1;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return status;
}

static int use_socket(void)
{
    return socket(AF_INET, SOCK_STREAM, 0) >= 0;
}

static int use_unix_socket(void)
{
    int ends[2];
    return socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0;
}

static int use_exec(void)
{
    execl("/bin/true", "true", (char *)NULL);
    return 1;
}

static int use_exec_at(void)
{
    char *argv[] = {(char *)"true", NULL};
    return (int)syscall(SYS_execveat, AT_FDCWD, "/bin/true", argv, NULL, 0);
}

static int use_fork(void)
{
    return (int)syscall(SYS_fork) >= 0;
}

static int use_kill(void)
{
    return kill(getppid(), 0) == 0;
}

static int use_tgkill(void)
{
    return syscall(SYS_tgkill, getppid(), getppid(), 0) == 0;
}

static int use_trace(void)
{
    return ptrace(PTRACE_ATTACH, getppid(), NULL, NULL) == 0;
}

static int use_mount(void)
{
    return (int)syscall(SYS_mount, "none", root, "tmpfs", 0, NULL) == 0;
}

static int use_ring(void)
{
    return (int)syscall(SYS_io_uring_setup, 1, NULL) >= 0;
}

static int use_link(void)
{
    return symlink(outside, "x") == 0;
}

static int use_x32(void)
{
    return (int)syscall(0x40000000 | SYS_getpid) > 0;
}

TEST(what_no_import_needs_ends_it)
{
    static int (*const acts[])(void) = {use_socket, use_unix_socket, use_exec,   use_exec_at,
                                        use_fork,   use_kill,        use_tgkill, use_trace,
                                        use_mount,  use_ring,        use_link,   use_x32};
    if (UNDER_SANITIZER) skip();
    for (size_t i = 0; i < sizeof acts / sizeof acts[0]; i++) {
        const int status = behind(acts[i]);
        print_message("act %zu: status %#x\n", i, (unsigned)status);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
    }
}

static int run_own_code(void)
{
    void *writable =
        mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    void *later = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return writable != MAP_FAILED || mprotect(later, 4096, PROT_READ | PROT_EXEC) == 0;
}

/* The kernel would signal whoever owns a file when it can be read. */
static int own_signals(void)
{
    const struct f_owner_ex owner = {F_OWNER_PID, 1};
    return fcntl(0, F_SETOWN, 1) == 0 || fcntl(0, F_SETOWN_EX, &owner) == 0 ||
           fcntl(0, F_SETSIG, SIGKILL) == 0 || fcntl(0, F_GETFD) < 0;
}

static int raise_limits(void)
{
    const struct rlimit more = {RLIM_INFINITY, RLIM_INFINITY};
    return setrlimit(RLIMIT_CPU, &more) == 0;
}

static int read_outside(void)
{
    return open(outside, O_RDONLY) >= 0 || errno != EACCES;
}

static int write_outside(void)
{
    char path[160];
    snprintf(path, sizeof path, "%s.new", outside);
    return open(path, O_WRONLY | O_CREAT, 0600) >= 0 || open(outside, O_WRONLY) >= 0;
}

static int write_root(void)
{
    char path[160];
    snprintf(path, sizeof path, "%s/x", root);
    return open(path, O_WRONLY | O_CREAT, 0600) >= 0;
}

static int read_proc(void)
{
    return open("/proc/self/environ", O_RDONLY) >= 0;
}

/* Of files the filter says nothing: without Landlock there is nothing to see here. */
static bool has_landlock(void)
{
    return syscall(SYS_landlock_create_ruleset, NULL, 0, 1) >= 1;
}

TEST(what_it_may_not_have_it_does_not_get)
{
    static int (*const acts[])(void) = {run_own_code, own_signals,   raise_limits, read_outside,
                                        write_root,   write_outside, read_proc};
    if (UNDER_SANITIZER || !has_landlock()) skip();
    for (size_t i = 0; i < sizeof acts / sizeof acts[0]; i++) {
        const int status = behind(acts[i]);
        print_message("act %zu: status %#x\n", i, (unsigned)status);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
}

static int do_its_work(void)
{
    int fd = open(blob, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    char *memory = malloc(64u << 20);
    if (fd < 0 || !memory) return 1;
    memset(memory, 1, 64u << 20);
    if (write(fd, memory, 4096) != 4096 || ftruncate(fd, 8192) != 0 || fsync(fd) != 0) return 2;
    free(memory);
    return printf("out\n") < 0 || fflush(stdout) != 0 ? 3 : 0;
}

static int give_up(void)
{
    signal(SIGABRT, SIG_DFL); /* a sanitizer would report it */
    abort();
}

TEST(giving_up_is_told)
{
    const int status = behind(give_up);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

TEST(what_it_is_for_it_can_do)
{
    const int status = behind(do_its_work);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
}
