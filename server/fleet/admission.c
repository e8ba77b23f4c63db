#include "server/fleet/admission.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static bool refuse(struct message_refused *refused, int code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static bool refuse(struct message_refused *refused, int code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    refused->code = code;
    vsnprintf(refused->text, sizeof refused->text, format, args);
    va_end(args);
    return false;
}

static const char *smaller_isa(const char *a, const char *b)
{
    static const char *const growing[] = {"sse4.2", "avx2", "avx512"};
    for (size_t i = 0; i < sizeof growing / sizeof growing[0]; i++)
        if (strcmp(a, growing[i]) == 0 || strcmp(b, growing[i]) == 0) return growing[i];
    return b;
}

void admission_refuse_greeting(int error, struct message_refused *refused)
{
    if (error == ERR_LIMIT)
        refuse(refused, error,
               "the worker's name has more than %d bytes, or it has more than %d threads: give it "
               "a shorter --name or fewer --threads",
               LIMIT_NAME_BYTES - 1, LIMIT_THREADS);
    else if (error == ERR_RANGE)
        refuse(refused, error,
               "the worker's name is no printable UTF-8, or it has no thread: give it another "
               "--name");
    else
        refuse(refused, error, "the greeting cannot be read (%s): connect a worker of this build",
               error_text(error));
}

bool admission_check(const struct admission *a, const struct message_hello *h,
                     struct message_refused *refused)
{
    if (h->protocol_version != PROTOCOL_VERSION)
        return refuse(refused, ERR_VERSION,
                      "worker speaks protocol %u, coordinator %u: install the same build on both "
                      "machines (the coordinator's is %.64s)",
                      h->protocol_version, PROTOCOL_VERSION, a->build_id);
    if (strcmp(h->build_id, a->build_id) != 0)
        return refuse(refused, ERR_MISMATCH,
                      "worker build %.64s, coordinator %.64s: install the same build on both "
                      "machines",
                      h->build_id, a->build_id);
    if (strcmp(h->isa, a->isa) != 0)
        return refuse(refused, ERR_MISMATCH,
                      "worker traces with %.32s, coordinator with %.32s, and their samples would "
                      "differ: set SHEARWATER_ISA=%.32s on all machines",
                      h->isa, a->isa, smaller_isa(h->isa, a->isa));
    if (a->embree_version[0] && strcmp(h->embree_version, a->embree_version) != 0)
        return refuse(refused, ERR_MISMATCH,
                      "worker has Embree %.32s, this coordinator's workers have %.32s: install the "
                      "same Embree on all machines",
                      h->embree_version, a->embree_version);
    if (a->workers >= LIMIT_WORKERS)
        return refuse(refused, ERR_FULL,
                      "the coordinator has %d workers already, its limit: stop some of them",
                      LIMIT_WORKERS);
    return true;
}
