/* Paths: what leads out of the root is not opened, whatever it is spelt like. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/import/fence/files.h"
#include "tests/unit/unit.h"

static char root[64];

static void write_file(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", root, name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static int set_up(void **state)
{
    (void)state;
    char path[256];
    snprintf(root, sizeof root, "/tmp/test_files.XXXXXX");
    if (mkdtemp(root) == NULL) return -1;
    snprintf(path, sizeof path, "%s/sub", root);
    if (mkdir(path, 0755) != 0) return -1;
    write_file("a.txt", "alpha");
    write_file("empty", "");
    write_file("sub/b.txt", "beta");
    snprintf(path, sizeof path, "%s/link", root);
    if (symlink("a.txt", path) != 0) return -1;
    snprintf(path, sizeof path, "%s/out", root);
    return symlink("/etc", path);
}

static int tear_down(void **state)
{
    (void)state;
    static const char *const names[] = {"a.txt", "empty", "sub/b.txt", "link", "out", "sub", ""};
    char path[256];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/%s", root, names[i]);
        remove(path);
    }
    return 0;
}

ALL_TESTS(set_up, tear_down);

static int map(const char *path)
{
    struct files files;
    struct file_view view;
    struct fault fault = {0};
    assert_int_equal(files_open(&files, root, &fault), 0);
    int rc = files_map(&files, path, "place", &view, &fault);
    if (rc == 0) {
        assert_non_null(view.data);
        files_unmap(&view);
    } else {
        assert_int_equal(fault.code, rc);
        assert_string_equal(fault.pointer, "place");
    }
    files_close(&files);
    return rc;
}

TEST(opens_what_is_beneath)
{
    struct files files;
    struct file_view view;
    assert_int_equal(files_open(&files, root, NULL), 0);
    assert_int_equal(files_map(&files, "sub/b.txt", "place", &view, NULL), 0);
    assert_int_equal(view.size_bytes, 4);
    assert_memory_equal(view.data, "beta", 4);
    files_unmap(&view);
    files_close(&files);
    assert_int_equal(map("a.txt"), 0);
    assert_int_equal(map("empty"), 0);
}

TEST(refuses_what_leads_out)
{
    static const char *const paths[] = {"../a.txt",   "sub/../a.txt", "/etc/passwd",
                                        "",           "sub//b.txt",   "./a.txt",
                                        "sub\\b.txt", "sub/",         "a\n.txt"};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        assert_int_equal(map(paths[i]), ERR_RANGE);
}

TEST(follows_no_link)
{
    assert_int_equal(map("link"), ERR_IO);
    assert_int_equal(map("out/passwd"), ERR_IO);
}

TEST(tells_missing_from_unreadable)
{
    assert_int_equal(map("nothing"), ERR_NOT_FOUND);
    assert_int_equal(map("sub"), ERR_IO);
}

TEST(counts_files)
{
    struct files files;
    struct file_view view;
    assert_int_equal(files_open(&files, root, NULL), 0);
    for (int i = 0; i <= LIMIT_SCENE_FILES; i++) {
        assert_int_equal(files_map(&files, "a.txt", "place", &view, NULL), 0);
        files_unmap(&view);
    }
    assert_int_equal(files_map(&files, "a.txt", "place", &view, NULL), ERR_LIMIT);
    files_close(&files);
}

static void expect_resolved(const char *beside, const char *name, bool percent, const char *to)
{
    char out[LIMIT_PATH_BYTES];
    assert_int_equal(files_resolve(beside, name, percent, out, "place", NULL), 0);
    assert_string_equal(out, to);
}

TEST(resolves_beside_the_main_file)
{
    expect_resolved("scene.gltf", "tex.png", true, "tex.png");
    expect_resolved("dir/scene.gltf", "tex.png", true, "dir/tex.png");
    expect_resolved("dir/scene.gltf", "./img/./tex.png", true, "dir/img/tex.png");
    expect_resolved("scene.gltf", "a%20b.png", true, "a b.png");
    expect_resolved("scene.obj", "a%20b.png", false, "a%20b.png");
}

TEST(refuses_names_that_lead_out)
{
    static const char *const names[] = {"/etc/passwd",  "../a",    "a/../../b",   "%2e%2e/a",
                                        "http://x/y",   "%2fetc",  "file:///etc", "a%2f..%2fb",
                                        "..%5cwindows", "a%00.png"};
    char out[LIMIT_PATH_BYTES];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_int_not_equal(files_resolve("dir/s.gltf", names[i], true, out, "place", NULL), 0);
}

TEST(refuses_names_too_long)
{
    char name[LIMIT_PATH_BYTES + 1], out[LIMIT_PATH_BYTES];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    assert_int_not_equal(files_resolve("s.gltf", name, true, out, "place", NULL), 0);
    name[LIMIT_PATH_BYTES - 1] = 0;
    assert_int_equal(files_resolve("s.gltf", name, true, out, "place", NULL), ERR_LIMIT);
    name[LIMIT_PATH_BYTES - 3] = 0;
    assert_int_equal(files_resolve("s.gltf", name, true, out, "place", NULL), 0);
    assert_int_equal(files_resolve("folder/s.gltf", name, true, out, "place", NULL), ERR_LIMIT);
}
