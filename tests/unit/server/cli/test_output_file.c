/* Which names a command may write its files under. */
#include <string.h>

#include "server/cli/client/output_file.h"
#include "tests/unit/unit.h"

static int picture(const char *path, const char *ending)
{
    struct fault fault = {0};
    int error = output_file_check_picture(path, ending, &fault);
    if (error == ERR_RANGE) assert_non_null(strstr(fault.detail, path));
    return error;
}

TEST(pictures_do_not_claim_another_format)
{
    assert_int_equal(picture("/tmp/a.png", "exr"), ERR_RANGE);
    assert_int_equal(picture("/tmp/a.JPG", "exr"), ERR_RANGE);
    assert_int_equal(picture("/tmp/a.exr", "png"), ERR_RANGE);
    assert_int_equal(picture("/tmp/a.hdr", "png"), ERR_RANGE);
}

TEST(other_names_are_free)
{
    static const char *const names[] = {"/tmp/a.exr",    "/tmp/a.EXR",     "/tmp/a",
                                        "/tmp/a.result", "/tmp/a.png.exr", "/dev/null"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_int_equal(picture(names[i], "exr"), 0);
    assert_int_equal(picture("/tmp/a.png", "png"), 0);
    assert_int_equal(picture("/nowhere/a.exr", "exr"), ERR_IO);
}
