/* shearwater-import: runs once per scene as a child of the coordinator, behind a fence. */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include "server/import/fence/fence.h"
#include "server/import/options.h"
#include "server/import/report.h"

static int report_fd = -1;

/* Also runs in signal handlers: nothing here but write. */
static void write_line(const char *line)
{
    const int fds[] = {STDOUT_FILENO, report_fd};
    for (size_t i = 0; i < 2; i++) {
        size_t left = strlen(line);
        for (const char *at = line; fds[i] >= 0 && left > 0;) {
            ssize_t n = write(fds[i], at, left);
            if (n <= 0) break;
            at += n;
            left -= (size_t)n;
        }
    }
}

/* The ends that come from outside the normal way: time is up, or C++ code below us gave up. */
static void on_end(int signal_number)
{
    if (signal_number == SIGABRT)
        write_line("{\"ok\":false,\"code\":\"MEMORY\",\"pointer\":\"scene\",\"detail\":"
                   "\"a library gave up, most likely for lack of memory\"}\n");
    else if (signal_number == SIGBUS)
        write_line("{\"ok\":false,\"code\":\"IO\",\"pointer\":\"scene\",\"detail\":"
                   "\"a file shrank while it was read\"}\n");
    else if (signal_number == SIGXFSZ)
        write_line("{\"ok\":false,\"code\":\"LIMIT\",\"pointer\":\"blob\",\"detail\":"
                   "\"the scene blob is larger than allowed\"}\n");
    else
        write_line("{\"ok\":false,\"code\":\"TIMEOUT\",\"pointer\":\"scene\",\"detail\":"
                   "\"the import took longer than allowed\"}\n");
    _exit(1);
}

static void catch_ends(void)
{
    static const int signals[] = {SIGALRM, SIGXCPU, SIGXFSZ, SIGABRT, SIGBUS};
    struct sigaction action = {.sa_handler = on_end};
    sigfillset(&action.sa_mask);
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        sigaction(signals[i], &action, NULL);
    signal(SIGPIPE, SIG_IGN);
    const struct itimerval deadline = {
        .it_value = {LIMIT_IMPORT_MS / 1000, LIMIT_IMPORT_MS % 1000 * 1000}};
    setitimer(ITIMER_REAL, &deadline, NULL);
}

static double cpu_seconds(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

/* Writes and frees a line; NULL means that there was no memory for it. */
static void tell(char *line)
{
    write_line(line != NULL ? line
                            : "{\"ok\":false,\"code\":\"MEMORY\",\"pointer\":\"report\","
                              "\"detail\":\"memory is exhausted\"}\n");
    free(line);
}

static int run(const struct options *options, struct fault *fault)
{
    static struct warnings warnings; /* large, and there is one run */
    struct import_stats stats;
    if (options->report != NULL) {
        report_fd = open(options->report, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
        if (report_fd < 0) return fault_set(fault, ERR_IO, "--report", "it cannot be written");
    }
    int rc = fence_raise(options->root, options->out, fault);
    if (rc == 0)
        rc = import_scene(options->root, options->name, &options->choice, options->out, &warnings,
                          &stats, fault);
    if (rc == 0) tell(report_success(&stats, &warnings, cpu_seconds()));
    return rc;
}

int main(int argc, char **argv)
{
    struct options options;
    struct fault fault = {0};
    catch_ends();
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* the coordinator wants no blob once it has died */
    int rc = options_read(argc, argv, &options, &fault);
    if (rc == 0 && (options.help || options.dump)) {
        if (options.help)
            options_print_help(stdout);
        else
            options_dump(stdout);
        return 0;
    }
    if (rc == 0) rc = run(&options, &fault);
    if (rc != 0) tell(report_failure(&fault));
    return rc == 0 ? 0 : 1;
}
