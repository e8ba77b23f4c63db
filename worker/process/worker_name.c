#include "worker/process/worker_name.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "proto/error.h"

#define HOST_BYTES 128
#define WORD_MAX_BYTES                                                                             \
    80 /* of an engine's; a Kubernetes name has 63, three of Slurm's fit a name */

/* Returns an engine's variable. NULL: it is not set, or is no word. */
static const char *word(const char *variable)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                  "0123456789._-";
    const char *text = getenv(variable);
    if (!text || text[0] == '\0' || strnlen(text, WORD_MAX_BYTES + 1) > WORD_MAX_BYTES) return NULL;
    return text[strspn(text, allowed)] == '\0' ? text : NULL;
}

/* Returns the length as snprintf does; 0: this is no job of Slurm's. */
static int slurm_name(const char *host, char *out, size_t capacity)
{
    const char *job = word("SLURM_JOB_ID"), *array = word("SLURM_ARRAY_JOB_ID");
    const char *task = word("SLURM_ARRAY_TASK_ID"), *process = word("SLURM_PROCID");
    char task_text[WORD_MAX_BYTES + 2] = "", process_text[WORD_MAX_BYTES + 2] = "";
    if (!job) return 0;
    if (array && task) {
        job = array;
        snprintf(task_text, sizeof task_text, "_%s", task);
    }
    if (process && strcmp(process, "0") != 0)
        snprintf(process_text, sizeof process_text, ".%s", process);
    return snprintf(out, capacity, "%s:slurm-%s%s%s", host, job, task_text, process_text);
}

static int kubernetes_name(char *out, size_t capacity)
{
    const char *pod = word("POD_NAME");
    if (!pod && getenv("KUBERNETES_SERVICE_HOST")) pod = word("HOSTNAME");
    return pod ? snprintf(out, capacity, "%s", pod) : 0;
}

int worker_name_default(char *out, size_t capacity)
{
    char host[HOST_BYTES] = "worker";
    gethostname(host, sizeof host - 1);
    int n = slurm_name(host, out, capacity);
    if (n <= 0 || (size_t)n >= capacity) n = kubernetes_name(out, capacity);
    if (n <= 0 || (size_t)n >= capacity)
        n = snprintf(out, capacity, "%s:%ld", host, (long)getpid());
    return n > 0 && (size_t)n < capacity ? 0 : ERR_LIMIT;
}
