/* Open Image Denoise is found, or refused with a sentence that says why. */
#include <stdio.h>

#include "tests/unit/server/reconstruct/oidn/fake_oidn.h"

static void expect_refused(int error, const struct fault *fault, const char *words)
{
    assert_int_equal(error, ERR_UNSUPPORTED);
    assert_int_equal(fault->code, ERR_UNSUPPORTED);
    assert_string_equal(fault->pointer, "/filter/residual");
    if (!strstr(fault->detail, words)) fail_msg("\"%s\" lacks \"%s\"", fault->detail, words);
}

TEST(a_library_of_version_2_is_taken)
{
    struct oidn_library library;
    struct fault fault;
    assert_int_equal(fake_oidn_open("fake", "half", &library, &fault), 0);
    assert_string_equal(library.label, "Open Image Denoise 2.3.99");
    oidn_library_close(&library);
    assert_null(library.handle);
    oidn_library_close(&library);
}

TEST(what_is_not_there_is_refused)
{
    struct oidn_library library;
    struct fault fault;
    expect_refused(oidn_library_open("libNoSuchDenoiser.so.2", &library, &fault), &fault,
                   "is not installed on the coordinator's machine (libNoSuchDenoiser.so.2: ");
    assert_null(library.handle);
}

TEST(what_lacks_a_function_is_refused)
{
    struct oidn_library library;
    struct fault fault;
    expect_refused(oidn_library_open("libm.so.6", &library, &fault), &fault,
                   "libm.so.6 lacks oidnNewDevice");
    expect_refused(fake_oidn_open("lacks", "half", &library, &fault), &fault,
                   "lacks oidnSetFilterBool");
    assert_null(library.handle);
}

TEST(other_versions_are_refused)
{
    struct oidn_library library;
    struct fault fault;
    expect_refused(fake_oidn_open("fake", "version", &library, &fault), &fault,
                   "Open Image Denoise 1.4.3 is installed, but oidn needs a version 2");
}

TEST(a_machine_without_a_device_is_refused)
{
    struct oidn_library library;
    struct fault fault;
    expect_refused(fake_oidn_open("fake", "nowhere", &library, &fault), &fault,
                   "Open Image Denoise: this CPU is too old");
    expect_refused(fake_oidn_open("fake", "device", &library, &fault), &fault,
                   "Open Image Denoise: the device is out of order");
}

/* The machine that runs this may have one or not: each call says the same. */
TEST(this_machines_is_looked_up_once)
{
    struct fault first = {0}, second = {0};
    const struct oidn_library *library = oidn_library_get(&first);
    assert_ptr_equal(oidn_library_get(&second), library);
    assert_int_equal(first.code, library ? 0 : ERR_UNSUPPORTED);
    assert_string_equal(first.detail, second.detail);
}
