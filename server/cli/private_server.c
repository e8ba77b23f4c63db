#include "server/cli/private_server.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define STOP_TRIES 400 /* of 25 ms: the server's own deadline for its workers is 5 s */

static int make_data_dir(struct private_server *s, struct fault *fault)
{
    const char *tmp = getenv("TMPDIR");
    snprintf(s->data_dir, sizeof s->data_dir, "%.200s/shearwater-render-XXXXXX",
             tmp && *tmp ? tmp : "/tmp");
    if (mkdtemp(s->data_dir)) return 0;
    int error = fault_set(fault, ERR_IO, "", "%s: %s", s->data_dir, strerror(errno));
    s->data_dir[0] = '\0';
    return error;
}

/* In the child: becomes `shearwater serve`, its standard output the pipe. */
static void become_server(const struct private_server *s, unsigned workers, unsigned threads,
                          int out)
{
    char worker_text[16], thread_text[16], program[4096];
    ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    if (n < 0) _exit(127);
    program[n] = '\0';
    snprintf(worker_text, sizeof worker_text, "%u", workers == PRIVATE_SERVER_ALONE ? 0 : workers);
    snprintf(thread_text, sizeof thread_text, "%u", threads);
    char *argv[14] = {program,    "serve",
                      "--listen", "127.0.0.1:0",
                      "--data",   (char *)s->data_dir,
                      "--quiet",  "--exit-with-parent"};
    int n_args = 8;
    if (workers > 0) {
        argv[n_args++] = "--workers";
        argv[n_args++] = worker_text;
    }
    if (threads > 0) {
        argv[n_args++] = "--worker-threads";
        argv[n_args++] = thread_text;
    }
    dup2(out, STDOUT_FILENO);
    /* Ctrl-C goes to the command, which then stops its server in order. */
    setpgid(0, 0);
    execv(program, argv);
    _exit(127);
}

/* Reads "listening on URL" from the child. */
static int await_address(struct private_server *s, int in, struct fault *fault)
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
                 : fault_set(fault, ERR_KILLED, "",
                             "the private server ended before it was ready; run `shearwater serve` "
                             "to see why");
}

int private_server_start(struct private_server *s, unsigned workers, unsigned worker_threads,
                         struct fault *fault)
{
    int ends[2];
    *s = (struct private_server){0};
    int error = make_data_dir(s, fault);
    if (error) return error;
    if (pipe2(ends, O_CLOEXEC) != 0) {
        error = fault_set(fault, ERR_IO, "", "pipe: %s", strerror(errno));
        goto fail;
    }
    s->pid = fork();
    if (s->pid == 0) become_server(s, workers, worker_threads, ends[1]);
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
    private_server_stop(s, NULL);
    return error;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

void private_server_stop(struct private_server *s, struct rusage *usage)
{
    struct rusage used = {0};
    int status;
    if (s->pid > 0) {
        kill(s->pid, SIGTERM);
        int tries = 0;
        while (wait4(s->pid, &status, WNOHANG, &used) == 0 && tries++ < STOP_TRIES)
            nanosleep(&(struct timespec){.tv_nsec = 25000000}, NULL);
        if (tries >= STOP_TRIES) {
            kill(s->pid, SIGKILL);
            wait4(s->pid, &status, 0, &used);
        }
        s->pid = 0;
    }
    if (usage) *usage = used;
    if (s->data_dir[0]) nftw(s->data_dir, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    s->data_dir[0] = '\0';
}
