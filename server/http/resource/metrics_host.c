#include "server/http/resource/metrics_host.h"

#include <dirent.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include "server/http/daemon.h"
#include "server/http/resource/metric_text.h"

void metrics_store(FILE *out, const struct http *http)
{
    struct job_store_totals store;
    struct spools_totals spools;
    struct statvfs disk;
    job_store_totals(http->options.store, &store);
    spools_totals(http->options.spools, &spools);
    metric_family(out, "shearwater_store_commit_duration_seconds", "histogram",
                  "Time that groups of changes took to become durable, or to fail.");
    metric_histogram(out, "shearwater_store_commit_duration_seconds", "", &store.commits);
    metric_single(out, "shearwater_store_commit_failures_total", "counter",
                  "Groups of changes that could not be stored.", store.failures);
    metric_single(out, "shearwater_store_requests_waiting", "gauge",
                  "Requests to the store that wait for those before them.", store.waiting);
    const struct metric_sample kept[] = {{"kept", spools.kept}, {"skipped", spools.skipped}};
    metric_family(out, "shearwater_spool_results_total", "counter",
                  "Results to be kept on disk for a restart, by verdict.");
    metric_labelled(out, "shearwater_spool_results_total", "verdict", kept, 2);
    metric_single(out, "shearwater_spool_size_bytes", "gauge", "Results on disk for a restart.",
                  spools.size_bytes);
    if (statvfs(http->options.objects->dir, &disk) != 0) return;
    metric_single(out, "shearwater_data_free_bytes", "gauge",
                  "Room on the file system of the data folder.",
                  (uint64_t)disk.f_bavail * disk.f_frsize);
}

void metrics_log(FILE *out, const struct log *log)
{
    struct metric_sample lines[LOG_ERROR + 1];
    if (!log) return;
    for (int i = LOG_INFO; i <= LOG_ERROR; i++)
        lines[i] = (struct metric_sample){log_level_name((enum log_level)i), log->lines[i]};
    metric_family(out, "shearwater_log_lines_total", "counter", "Lines of the log, by level.");
    metric_labelled(out, "shearwater_log_lines_total", "level", lines, LOG_ERROR + 1);
    metric_single(out, "shearwater_log_lines_dropped_total", "counter",
                  "Lines that the log's reader had no room for, or that could not be written.",
                  log_lost(log));
}

static uint64_t resident_bytes(void)
{
    unsigned long total = 0, resident = 0;
    FILE *f = fopen("/proc/self/statm", "re");
    if (f && fscanf(f, "%lu %lu", &total, &resident) != 2) resident = 0;
    if (f) fclose(f);
    return (uint64_t)resident * (uint64_t)sysconf(_SC_PAGESIZE);
}

/* Without "." and "..", and the one that reads them. */
static uint64_t open_files(void)
{
    uint64_t count = 0;
    DIR *folder = opendir("/proc/self/fd");
    if (!folder) return 0;
    while (readdir(folder)) count++;
    closedir(folder);
    return count > 3 ? count - 3 : 0;
}

static void write_process(FILE *out, const struct http *http)
{
    struct rusage use;
    struct rlimit files = {0};
    getrusage(RUSAGE_SELF, &use);
    getrlimit(RLIMIT_NOFILE, &files);
    metric_family(out, "process_cpu_seconds_total", "counter", "CPU time of the coordinator.");
    fprintf(out, "process_cpu_seconds_total %.6f\n",
            (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec) * 1e-6);
    metric_single(out, "process_resident_memory_bytes", "gauge",
                  "Memory that the coordinator holds.", resident_bytes());
    metric_single(out, "process_open_fds", "gauge", "Open descriptors.", open_files());
    metric_single(out, "process_max_fds", "gauge", "Descriptors that may be open.",
                  (uint64_t)files.rlim_cur);
    metric_single(out, "process_start_time_seconds", "gauge",
                  "When the coordinator started, since 1970.", http->started_s);
}

void metrics_host(FILE *out, const struct http *http)
{
    metric_family(out, "shearwater_loop_delay_seconds", "histogram",
                  "How late a timer of the coordinator's loop came, four times a second.");
    metric_histogram(out, "shearwater_loop_delay_seconds", "", &http->delays);
    metric_single(out, "shearwater_pool_tasks", "gauge",
                  "Pieces of reconstruction and encoding that wait or are in work.",
                  thread_pool_pending(http->options.pool));
    write_process(out, http);
}
