#include "server/cli/embedded_server.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/pidfd.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "proto/runtime/clock.h"
#include "server/cli/cli.h"

#define LOOK_MS     25
#define PATIENCE_MS 10000 /* the server's own deadline for its workers is 5 s */

static int make_data_dir(struct embedded_server *s, struct fault *fault)
{
    const char *tmp = getenv("TMPDIR");
    snprintf(s->data_dir, sizeof s->data_dir, "%.200s/shearwater-render-XXXXXX",
             tmp && *tmp ? tmp : "/tmp");
    if (mkdtemp(s->data_dir)) return 0;
    int error = fault_set(fault, ERR_IO, "", "%s: %s", s->data_dir, strerror(errno));
    s->data_dir[0] = '\0';
    return error;
}

/* Goes on as `shearwater serve` in the child, with the pipe as standard output. It does not exec,
 * which would load and bind dozens of libraries once more: 5 ms of a picture that takes 100. */
_Noreturn static void become_server(const struct embedded_server *s, unsigned workers,
                                    unsigned threads, const int ends[2])
{
    char worker_text[16], thread_text[16];
    snprintf(worker_text, sizeof worker_text, "%u", workers == EMBEDDED_SERVER_ALONE ? 0 : workers);
    snprintf(thread_text, sizeof thread_text, "%u", threads);
    char *argv[14] = {"serve",       "--listen",          "127.0.0.1:0",
                      "--data",      (char *)s->data_dir, "--ephemeral",
                      "--unwatched", "--quiet",           "--exit-with-parent"};
    int n_args = 9;
    if (workers > 0) {
        argv[n_args++] = "--workers";
        argv[n_args++] = worker_text;
    }
    if (threads > 0) {
        argv[n_args++] = "--worker-threads";
        argv[n_args++] = thread_text;
    }
    dup2(ends[1], STDOUT_FILENO);
    /* either is standard output itself where that was closed */
    for (int i = 0; i < 2; i++)
        if (ends[i] != STDOUT_FILENO) close(ends[i]);
    exit(cli_serve(n_args, argv));
}

/* Forks. The child has its own way with signals, whenever they come, and goes with its parent. */
static pid_t fork_child(void)
{
    const pid_t parent = getpid();
    sigset_t ends, before;
    sigemptyset(&ends);
    sigaddset(&ends, SIGINT);
    sigaddset(&ends, SIGTERM);
    fflush(NULL); /* what waits to be written is not the child's, too */
    sigprocmask(SIG_BLOCK, &ends, &before);
    const pid_t pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (getppid() != parent) _exit(1);
        /* Ctrl-C goes to the command, which then stops its server in order. */
        setpgid(0, 0);
        signal(SIGINT, SIG_DFL);
        signal(SIGTERM, SIG_DFL);
    }
    sigprocmask(SIG_SETMASK, &before, NULL);
    return pid;
}

/* Reads "listening on URL" from the child. */
static int await_address(struct embedded_server *s, int in, struct fault *fault)
{
    char line[256];
    FILE *f = fdopen(in, "r");
    if (!f) {
        close(in);
        return fault_set(fault, ERR_IO, "", "cannot read from the server: %s", strerror(errno));
    }
    bool found = false;
    while (!found && fgets(line, sizeof line, f))
        found = sscanf(line, "listening on %63s", s->base_url) == 1;
    fclose(f);
    return found ? 0
                 : fault_set(
                       fault, ERR_KILLED, "",
                       "the private coordinator ended before it was ready; run `shearwater serve` "
                       "to see why");
}

int embedded_server_start(struct embedded_server *s, unsigned workers, unsigned worker_threads,
                          struct fault *fault)
{
    int ends[2];
    *s = (struct embedded_server){0};
    int error = make_data_dir(s, fault);
    if (error) return error;
    if (pipe2(ends, O_CLOEXEC) != 0) {
        error = fault_set(fault, ERR_IO, "", "pipe: %s", strerror(errno));
        goto fail;
    }
    s->pid = fork_child();
    if (s->pid == 0) become_server(s, workers, worker_threads, ends);
    close(ends[1]);
    if (s->pid < 0) {
        s->pid = 0;
        close(ends[0]);
        error = fault_set(fault, ERR_IO, "", "fork: %s", strerror(errno));
        goto fail;
    }
    error = await_address(s, ends[0], fault);
    if (!error) return 0;
fail:
    embedded_server_stop(s, NULL);
    return error;
}

static int64_t clock_ms(void)
{
    return (int64_t)(clock_us(CLOCK_MONOTONIC) / 1000);
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

/* Waits until the child has ended, or for `patience_ms`. False: it still runs. */
static bool await_end(pid_t pid, int patience_ms, struct rusage *used)
{
    const int64_t deadline_ms = clock_ms() + patience_ms;
    struct pollfd end = {.fd = pidfd_open(pid, 0), .events = POLLIN};
    bool ended = false;
    for (int64_t left_ms = patience_ms; !ended && left_ms > 0; left_ms = deadline_ms - clock_ms()) {
        /* without a descriptor it is looked for now and then */
        poll(&end, end.fd < 0 ? 0 : 1, (int)(end.fd < 0 && left_ms > LOOK_MS ? LOOK_MS : left_ms));
        ended = wait4(pid, NULL, WNOHANG, used) == pid;
    }
    if (end.fd >= 0) close(end.fd);
    return ended;
}

void embedded_server_stop(struct embedded_server *s, struct rusage *usage)
{
    struct rusage used = {0};
    if (s->pid > 0) {
        kill(s->pid, SIGTERM);
        if (!await_end(s->pid, PATIENCE_MS, &used)) {
            kill(s->pid, SIGKILL);
            while (wait4(s->pid, NULL, 0, &used) < 0 && errno == EINTR) {
            }
        }
        s->pid = 0;
    }
    if (usage) *usage = used;
    if (s->data_dir[0]) nftw(s->data_dir, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    s->data_dir[0] = '\0';
}
