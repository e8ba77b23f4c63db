#include "tests/property/check.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

struct answer {
    enum property_result result;
    char says[PROPERTY_SAYS_BYTES];
};

/* Seen by children, too. */
static struct answer *shared_answer(void)
{
    static struct answer *answer;
    if (answer) return answer;
    answer = mmap(NULL, sizeof *answer, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (answer == MAP_FAILED) abort();
    return answer;
}

enum property_result check(const struct property *property, const struct property_case *c,
                           char says[PROPERTY_SAYS_BYTES])
{
    struct answer *answer = shared_answer();
    int status = 0;
    memset(answer, 0, sizeof *answer);
    answer->result = PROPERTY_FAILS;
    fflush(NULL);
    const pid_t child = fork();
    if (child < 0) abort();
    if (child == 0) {
        alarm(CHECK_MAX_S);
        answer->result = property->holds(c, answer->says);
        _exit(0);
    }
    if (waitpid(child, &status, 0) != child) abort();
    memcpy(says, answer->says, PROPERTY_SAYS_BYTES);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return answer->result;
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
        snprintf(says, PROPERTY_SAYS_BYTES, "not done within %d s", CHECK_MAX_S);
    else if (WIFSIGNALED(status))
        snprintf(says, PROPERTY_SAYS_BYTES, "ended by signal %d (%s)", WTERMSIG(status),
                 strsignal(WTERMSIG(status)));
    else
        snprintf(says, PROPERTY_SAYS_BYTES, "ended with status %d", WEXITSTATUS(status));
    return PROPERTY_FAILS;
}

int check_shrink(const struct property *property, struct property_case *c, int most,
                 char says[PROPERTY_SAYS_BYTES])
{
    int tries = 0;
    struct property_case simpler;
    char said[PROPERTY_SAYS_BYTES];
    const time_t end = time(NULL) + SHRINK_MAX_S;
    for (int n = 0; tries < most && time(NULL) < end && case_simpler(c, n, &simpler); n++) {
        if (!memcmp(&simpler, c, sizeof simpler)) continue;
        tries++;
        if (check(property, &simpler, said) != PROPERTY_FAILS) continue;
        *c = simpler;
        memcpy(says, said, PROPERTY_SAYS_BYTES);
        n = -1; /* all ways once more */
    }
    return tries;
}
