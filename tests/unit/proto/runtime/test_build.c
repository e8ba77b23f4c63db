/* The build's name, and the instruction set that may only be asked to be smaller. */
#include <stdlib.h>
#include <string.h>

#include "proto/limits.h"
#include "proto/runtime/build.h"
#include "tests/unit/unit.h"

static const char *const sets[] = {"sse4.2", "avx2", "avx512"};

static int rank(const char *isa)
{
    for (int i = 0; i < 3; i++)
        if (strcmp(isa, sets[i]) == 0) return i;
    return -1;
}

TEST(id_is_version_and_digest)
{
    const char *id = build_id();
    size_t version = strspn(id, "0123456789.");
    assert_true(version >= 5);
    assert_int_equal(id[version], '+');
    assert_int_equal(strspn(id + version + 1, "0123456789abcdef"), 12);
    assert_int_equal(id[version + 13], '\0');
    assert_true(strlen(id) < LIMIT_NAME_BYTES);
}

TEST(isa_can_only_shrink)
{
    unsetenv("SHEARWATER_ISA");
    const char *best = build_isa();
    if (best == NULL) skip();
    int highest = rank(best);
    assert_true(highest >= 0);
    for (int i = 0; i < 3; i++) {
        setenv("SHEARWATER_ISA", sets[i], 1);
        assert_string_equal(build_isa(), sets[i <= highest ? i : highest]);
    }
    setenv("SHEARWATER_ISA", "", 1);
    assert_string_equal(build_isa(), best);
    unsetenv("SHEARWATER_ISA");
}

TEST(what_is_no_isa_is_refused)
{
    struct fault fault = {0};
    for (int i = 0; i < 3; i++) {
        setenv("SHEARWATER_ISA", sets[i], 1);
        assert_int_equal(build_isa_check(&fault), 0);
    }
    setenv("SHEARWATER_ISA", "AVX2", 1);
    assert_int_equal(build_isa_check(&fault), ERR_UNSUPPORTED);
    assert_non_null(strstr(fault.detail, "\"AVX2\" is no instruction set: sse4.2, avx2 or avx512"));
    setenv("SHEARWATER_ISA", "", 1);
    assert_int_equal(build_isa_check(&fault), 0);
    unsetenv("SHEARWATER_ISA");
    assert_int_equal(build_isa_check(&fault), 0);
}
