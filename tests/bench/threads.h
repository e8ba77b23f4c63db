#pragma once
/* Runs a function on several cores. */
#include <pthread.h>
#include <unistd.h>

#define THREADS_MAX 16

/* Runs it on so many threads; one is the caller's own. Returns 0, or an error when a thread could
 * not be started. */
static inline int run_on_cores(long count, void *(*run)(void *ctx), void *ctx)
{
    pthread_t ids[THREADS_MAX];
    long begun = 0;
    int error = 0;
    if (count == 1) {
        run(ctx);
        return 0;
    }
    count = count < 1 ? 1 : count > THREADS_MAX ? THREADS_MAX : count;
    for (; begun < count && !error; begun += error ? 0 : 1)
        error = pthread_create(&ids[begun], NULL, run, ctx);
    while (begun > 0) pthread_join(ids[--begun], NULL);
    return error;
}

static inline int run_on_all_cores(void *(*run)(void *ctx), void *ctx)
{
    return run_on_cores(sysconf(_SC_NPROCESSORS_ONLN), run, ctx);
}
