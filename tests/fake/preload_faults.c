/* A machine that fails on purpose, to be preloaded (LD_PRELOAD): writes to files, fsync, rename and
 * allocations fail as a control block says, and the wall clock is off by as much as it says.
 *
 *   FAULTS_CONTROL=FILE   the block, shared with whoever writes to the file meanwhile
 *   FAULTS_FOR=NAME       of processes of this name alone; others go on
 *
 * The block is of 64-bit numbers, little-endian: for each kind (write, fsync, rename, allocation,
 * make, send) calls so far, the first call that fails (from 1; 0: none), how many do in a row, with
 * which errno; then seconds by which CLOCK_REALTIME is off; then the same four numbers for writes
 * of the log. `write` counts those to regular files but for standard streams, which are the log's,
 * `make` what creates a file, a folder or a name of one, `send` what goes into a socket. An errno
 * of 0: the call does not fail but hangs for as long as the block says so. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum kind { WRITE, FSYNC, RENAME, ALLOCATION, MAKE, SEND, KINDS };

struct fault_plan {
    int64_t calls, first, count, error;
};
struct control {
    struct fault_plan plans[KINDS];
    int64_t clock_offset_s;
    struct fault_plan log;
};

static struct control *control; /* NULL: nothing fails */

/* glibc's own, which need no looking up: looking up allocates. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

#define REAL(type, name) ((type)(uintptr_t)dlsym(RTLD_NEXT, name))

__attribute__((constructor)) static void open_control(void)
{
    const char *path = getenv("FAULTS_CONTROL"), *wanted = getenv("FAULTS_FOR");
    if (!path || (wanted && strcmp(wanted, program_invocation_short_name) != 0)) return;
    const int fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0) abort();
    void *block = mmap(NULL, sizeof *control, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (block == MAP_FAILED) abort();
    close(fd);
    control = block;
}

static int is_hit(const struct fault_plan *plan, int64_t call)
{
    const int64_t first = __atomic_load_n(&plan->first, __ATOMIC_RELAXED);
    return first != 0 && call >= first && call - first < plan->count;
}

/* Counts a call; true, with errno set, when it is to fail. */
static int plan_fails(struct fault_plan *plan)
{
    const int64_t call = __atomic_add_fetch(&plan->calls, 1, __ATOMIC_RELAXED);
    if (!is_hit(plan, call)) return 0;
    const struct timespec pause = {.tv_nsec = 10000000};
    while (plan->error == 0 && is_hit(plan, call)) nanosleep(&pause, NULL);
    for (int64_t ms = plan->error; ms < 0 && is_hit(plan, call); ms += 10) nanosleep(&pause, NULL);
    if (plan->error <= 0) return 0;
    errno = (int)plan->error;
    return 1;
}

static int fails(enum kind kind)
{
    return control && plan_fails(&control->plans[kind]);
}

static int write_fails(int fd)
{
    const int saved = errno;
    struct stat st;
    const int known = control && fstat(fd, &st) == 0;
    errno = saved;
    if (known && S_ISREG(st.st_mode))
        return fd > STDERR_FILENO ? fails(WRITE) : plan_fails(&control->log);
    return known && S_ISSOCK(st.st_mode) && fails(SEND);
}

/* -- writing -- */

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) real = REAL(ssize_t(*)(int, const void *, size_t), "write");
    return write_fails(fd) ? -1 : real(fd, data, size);
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t offset)
{
    static ssize_t (*real)(int, const void *, size_t, off_t);
    if (!real) real = REAL(ssize_t(*)(int, const void *, size_t, off_t), "pwrite");
    return write_fails(fd) ? -1 : real(fd, data, size, offset);
}

ssize_t pwrite64(int fd, const void *data, size_t size, off_t offset)
{
    return pwrite(fd, data, size, offset);
}

ssize_t writev(int fd, const struct iovec *parts, int count)
{
    static ssize_t (*real)(int, const struct iovec *, int);
    if (!real) real = REAL(ssize_t(*)(int, const struct iovec *, int), "writev");
    return write_fails(fd) ? -1 : real(fd, parts, count);
}

ssize_t pwritev(int fd, const struct iovec *parts, int count, off_t offset)
{
    static ssize_t (*real)(int, const struct iovec *, int, off_t);
    if (!real) real = REAL(ssize_t(*)(int, const struct iovec *, int, off_t), "pwritev");
    return write_fails(fd) ? -1 : real(fd, parts, count, offset);
}

ssize_t send(int fd, const void *data, size_t size, int flags)
{
    static ssize_t (*real)(int, const void *, size_t, int);
    if (!real) real = REAL(ssize_t(*)(int, const void *, size_t, int), "send");
    return fails(SEND) ? -1 : real(fd, data, size, flags);
}

ssize_t sendmsg(int fd, const struct msghdr *message, int flags)
{
    static ssize_t (*real)(int, const struct msghdr *, int);
    if (!real) real = REAL(ssize_t(*)(int, const struct msghdr *, int), "sendmsg");
    return fails(SEND) ? -1 : real(fd, message, flags);
}

int fsync(int fd)
{
    static int (*real)(int);
    if (!real) real = REAL(int (*)(int), "fsync");
    return fails(FSYNC) ? -1 : real(fd);
}

int fdatasync(int fd)
{
    static int (*real)(int);
    if (!real) real = REAL(int (*)(int), "fdatasync");
    return fails(FSYNC) ? -1 : real(fd);
}

int rename(const char *from, const char *to)
{
    static int (*real)(const char *, const char *);
    if (!real) real = REAL(int (*)(const char *, const char *), "rename");
    return fails(RENAME) ? -1 : real(from, to);
}

/* -- making -- */

int open(const char *path, int flags, ...)
{
    static int (*real)(const char *, int, ...);
    mode_t mode = 0;
    va_list arguments;
    va_start(arguments, flags);
    if (flags & (O_CREAT | __O_TMPFILE)) mode = va_arg(arguments, mode_t);
    va_end(arguments);
    if (!real) real = REAL(int (*)(const char *, int, ...), "open");
    return (flags & O_CREAT) && fails(MAKE) ? -1 : real(path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    mode_t mode = 0;
    va_list arguments;
    va_start(arguments, flags);
    if (flags & (O_CREAT | __O_TMPFILE)) mode = va_arg(arguments, mode_t);
    va_end(arguments);
    return open(path, flags, mode);
}

int mkdir(const char *path, mode_t mode)
{
    static int (*real)(const char *, mode_t);
    if (!real) real = REAL(int (*)(const char *, mode_t), "mkdir");
    return fails(MAKE) ? -1 : real(path, mode);
}

int link(const char *from, const char *to)
{
    static int (*real)(const char *, const char *);
    if (!real) real = REAL(int (*)(const char *, const char *), "link");
    return fails(MAKE) ? -1 : real(from, to);
}

int mkostemp(char *path, int flags)
{
    static int (*real)(char *, int);
    if (!real) real = REAL(int (*)(char *, int), "mkostemp");
    return fails(MAKE) ? -1 : real(path, flags);
}

char *mkdtemp(char *path)
{
    static char *(*real)(char *);
    if (!real) real = REAL(char *(*)(char *), "mkdtemp");
    return fails(MAKE) ? NULL : real(path);
}

/* -- allocations -- */

void *malloc(size_t size)
{
    return fails(ALLOCATION) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return fails(ALLOCATION) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return fails(ALLOCATION) ? NULL : __libc_realloc(old, size);
}

/* blosc 1.21 does not look at what it gets, and has LZ4 write to address 0: a fault of the library,
 * which nobody can keep it from. What dies of it is started again, as what aborts is. */
static int is_blosc(const void *caller)
{
    Dl_info found;
    return dladdr(caller, &found) && found.dli_fname && strstr(found.dli_fname, "libblosc");
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    const int saved = errno;
    const int checked = control && !is_blosc(__builtin_return_address(0));
    void *block = checked && fails(ALLOCATION) ? NULL : __libc_memalign(alignment, size);
    errno = saved;
    if (!block) return ENOMEM;
    *out = block;
    return 0;
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return fails(ALLOCATION) ? NULL : __libc_memalign(alignment, size);
}

/* -- the wall clock -- */

static int64_t offset_s(void)
{
    return control ? __atomic_load_n(&control->clock_offset_s, __ATOMIC_RELAXED) : 0;
}

int clock_gettime(clockid_t clock, struct timespec *out)
{
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = REAL(int (*)(clockid_t, struct timespec *), "clock_gettime");
    const int result = real(clock, out);
    if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
        out->tv_sec += offset_s();
    return result;
}

int gettimeofday(struct timeval *restrict out, void *restrict zone)
{
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    *out = (struct timeval){.tv_sec = now.tv_sec, .tv_usec = now.tv_nsec / 1000};
    return 0;
}

time_t time(time_t *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) *out = now.tv_sec;
    return now.tv_sec;
}
