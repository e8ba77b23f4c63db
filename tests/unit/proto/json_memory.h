#pragma once
/* jansson without memory for the n-th piece that it asks for. */
#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

/* Asks for more than there is in place of the n-th piece. */
static unsigned until_failure;
static json_malloc_t noticed_malloc;
static json_free_t noticed_free;

static void *fail_once(size_t size)
{
    return noticed_malloc(until_failure > 0 && --until_failure == 0 ? PTRDIFF_MAX : size);
}

static int fail_when_told(void **state)
{
    (void)state;
    json_get_alloc_funcs(&noticed_malloc, &noticed_free);
    json_set_alloc_funcs(fail_once, noticed_free);
    return 0;
}

static int fail_no_more(void **state)
{
    (void)state;
    json_set_alloc_funcs(noticed_malloc, noticed_free);
    return 0;
}

/* Sanitizers end programs that ask for that much, unless told. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1";
}

const char *__tsan_default_options(void);
const char *__tsan_default_options(void)
{
    return "allocator_may_return_null=1";
}
