#include "server/import/fence/syscalls.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "proto/error.h"

#define X32_BIT      0x40000000u
#define OFFSET(what) ((uint32_t)offsetof(struct seccomp_data, what))
#define LOAD(what)   BPF_STMT(BPF_LD | BPF_W | BPF_ABS, OFFSET(what))
#define RETURN(what) BPF_STMT(BPF_RET | BPF_K, (what))
#define REFUSE(code) RETURN(SECCOMP_RET_ERRNO | ((code)&SECCOMP_RET_DATA))
/* The call `name` is let pass. */
#define ALLOW(name) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_##name, 0, 1), RETURN(SECCOMP_RET_ALLOW)
/* The call fails with `code`: libraries try it and do without. */
#define DENY(name, code) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_##name, 0, 1), REFUSE(code)
/* The call is let pass unless its third argument asks for memory that runs. */
#define ALLOW_NOT_EXEC(name)                                                                       \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_##name, 0, 4), LOAD(args[2]),                          \
        BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1), REFUSE(EPERM),                      \
        RETURN(SECCOMP_RET_ALLOW)

/* So is fcntl, but for commands by which the kernel would signal a process. */
#define FCNTL_REFUSED(command) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (command), 0, 1), REFUSE(EPERM)
#define ALLOW_FCNTL                                                                                \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_fcntl, 0, 10), LOAD(args[1]), FCNTL_REFUSED(F_SETOWN), \
        FCNTL_REFUSED(F_SETSIG), FCNTL_REFUSED(F_SETOWN_EX), FCNTL_REFUSED(F_SETLEASE),            \
        RETURN(SECCOMP_RET_ALLOW)

/* abort() signals the thread itself; `pid` is where our own number goes. */
#define ALLOW_TO_SELF(name, pid)                                                                   \
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_##name, 0, 4), LOAD(args[0]),                          \
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (pid), 0, 1), RETURN(SECCOMP_RET_ALLOW),               \
        RETURN(SECCOMP_RET_KILL_PROCESS)

int syscalls_confine(void)
{
    const struct sock_filter filter[] = {
        LOAD(arch),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0),
        RETURN(SECCOMP_RET_KILL_PROCESS),
        LOAD(nr),
        BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, X32_BIT, 0, 1),
        RETURN(SECCOMP_RET_KILL_PROCESS),
        /* Memory. */
        ALLOW_NOT_EXEC(mmap),
        ALLOW_NOT_EXEC(mprotect),
        ALLOW(munmap),
        ALLOW(mremap),
        ALLOW(brk),
        ALLOW(madvise),
        ALLOW(futex),
        /* Files: which ones Landlock and the rooted opener say. */
        ALLOW(openat),
        ALLOW(openat2),
        ALLOW(open),
        ALLOW(close),
        ALLOW(dup),
        ALLOW_FCNTL,
        ALLOW(read),
        ALLOW(pread64),
        ALLOW(readv),
        ALLOW(write),
        ALLOW(pwrite64),
        ALLOW(writev),
        ALLOW(lseek),
        ALLOW(fstat),
        ALLOW(stat),
        ALLOW(lstat),
        ALLOW(newfstatat),
        ALLOW(statx),
        ALLOW(access),
        ALLOW(faccessat),
        ALLOW(faccessat2),
        ALLOW(readlink),
        ALLOW(readlinkat),
        ALLOW(getcwd),
        ALLOW(ftruncate),
        ALLOW(fallocate),
        ALLOW(fadvise64),
        ALLOW(fsync),
        ALLOW(fdatasync),
        ALLOW(rename),
        ALLOW(renameat),
        ALLOW(unlink),
        ALLOW(unlinkat),
        DENY(ioctl, ENOTTY), /* is it a terminal? no */
        /* Oneself. */
        ALLOW(rt_sigaction),
        ALLOW(rt_sigprocmask),
        ALLOW(rt_sigreturn),
        ALLOW(sigaltstack),
        ALLOW(setitimer),
        ALLOW(getrusage),
        ALLOW(getpid),
        ALLOW(gettid),
        ALLOW(clock_gettime),
        ALLOW(clock_getres),
        ALLOW(gettimeofday),
        ALLOW(getrandom),
        ALLOW(sched_yield),
        ALLOW(sched_getaffinity),
        ALLOW(sysinfo),
        ALLOW(uname),
        ALLOW(rseq),
        ALLOW(set_robust_list),
        ALLOW(restart_syscall),
        ALLOW(exit),
        ALLOW(exit_group),
        ALLOW_TO_SELF(tgkill, (uint32_t)getpid()),
        DENY(prlimit64, EPERM),
        RETURN(SECCOMP_RET_KILL_PROCESS),
    };
    const struct sock_fprog program = {.len = sizeof filter / sizeof filter[0],
                                       .filter = (struct sock_filter *)(uintptr_t)filter};
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0 ? 0 : ERR_UNSUPPORTED;
}
