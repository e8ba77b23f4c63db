/* Files by digest: whole or not there, whoever writes and however often. */
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/store/objects.h"
#include "tests/unit/unit.h"

static char root[64];

static int make_root(void **state)
{
    (void)state;
    strcpy(root, "/tmp/shearwater-objects-XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state)
{
    (void)state;
    objects_remove_dir(root);
    return access(root, F_OK) ? 0 : -1;
}

EACH_TEST(make_root, remove_root);

static void open_objects(struct objects *o)
{
    char dir[128];
    snprintf(dir, sizeof dir, "%s/deep/data", root);
    assert_int_equal(objects_open(o, dir, false), 0);
}

static int write_object(const struct objects *o, const char *text, const struct digest *expected,
                        struct digest *out, bool *existed)
{
    struct object_writer *w;
    assert_int_equal(object_writer_begin(o, &w), 0);
    size_t half = strlen(text) / 2;
    assert_int_equal(object_writer_append(w, text, half), 0);
    assert_int_equal(object_writer_append(w, text + half, strlen(text) - half), 0);
    int error = object_writer_finish(&w, expected, out, existed);
    assert_null(w);
    return error;
}

static void assert_content(const struct objects *o, const struct digest *d, const char *text)
{
    char path[OBJECTS_PATH_BYTES], content[256] = {0};
    uint64_t size = 0;
    assert_true(objects_have(o, d, &size));
    assert_int_equal(size, strlen(text));
    objects_path(o, d, path);
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    assert_int_equal(fread(content, 1, sizeof content, f), strlen(text));
    fclose(f);
    assert_string_equal(content, text);
}

static int entries_in_tmp(const struct objects *o)
{
    char command[OBJECTS_PATH_BYTES + 32];
    snprintf(command, sizeof command, "ls -A '%s/tmp' | wc -l", o->dir);
    FILE *p = popen(command, "r");
    int count = -1;
    assert_int_equal(fscanf(p, "%d", &count), 1);
    pclose(p);
    return count;
}

TEST(a_file_is_found_by_its_digest)
{
    struct objects o;
    struct digest d, expected;
    bool existed = true;
    open_objects(&o);
    digest_of("hello", 5, &expected);
    assert_false(objects_have(&o, &expected, NULL));
    assert_int_equal(write_object(&o, "hello", NULL, &d, &existed), 0);
    assert_false(existed);
    assert_true(digest_equal(&d, &expected));
    assert_content(&o, &d, "hello");
    char path[OBJECTS_PATH_BYTES];
    objects_path(&o, &d, path);
    assert_non_null(strstr(path, "/objects/2c/f24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e7304"));
    assert_int_equal(entries_in_tmp(&o), 0);
}

TEST(a_second_writer_finds_it_there)
{
    struct objects o;
    struct digest d;
    bool existed = false;
    open_objects(&o);
    assert_int_equal(write_object(&o, "twice", NULL, &d, NULL), 0);
    assert_int_equal(write_object(&o, "twice", NULL, &d, &existed), 0);
    assert_true(existed);
    assert_content(&o, &d, "twice");
    assert_int_equal(entries_in_tmp(&o), 0);
}

TEST(another_digest_keeps_nothing)
{
    struct objects o;
    struct digest expected, d, real;
    open_objects(&o);
    digest_of("the promised", 12, &expected);
    digest_of("the delivered", 13, &real);
    assert_int_equal(write_object(&o, "the delivered", &expected, &d, NULL), ERR_MISMATCH);
    assert_true(digest_equal(&d, &real));
    assert_false(objects_have(&o, &expected, NULL));
    assert_false(objects_have(&o, &real, NULL));
    assert_int_equal(entries_in_tmp(&o), 0);
}

TEST(an_empty_file_is_a_file)
{
    struct objects o;
    struct digest d, empty;
    open_objects(&o);
    digest_of("", 0, &empty);
    assert_int_equal(write_object(&o, "", NULL, &d, NULL), 0);
    assert_true(digest_equal(&d, &empty));
    assert_content(&o, &d, "");
}

TEST(abort_leaves_nothing)
{
    struct objects o;
    struct object_writer *w;
    open_objects(&o);
    assert_int_equal(object_writer_begin(&o, &w), 0);
    assert_int_equal(object_writer_append(w, "x", 1), 0);
    object_writer_abort(&w);
    assert_null(w);
    object_writer_abort(&w);
    assert_int_equal(entries_in_tmp(&o), 0);
}

/* A library that opens the path by itself, even one that replaces it by renaming. */
TEST(a_library_may_write_the_file)
{
    struct objects o;
    struct object_writer *w;
    struct digest d, expected;
    char beside[OBJECTS_PATH_BYTES + 8];
    open_objects(&o);
    assert_int_equal(object_writer_begin(&o, &w), 0);
    snprintf(beside, sizeof beside, "%s.new", object_writer_path(w));
    FILE *f = fopen(beside, "wb");
    fputs("by a library", f);
    fclose(f);
    assert_int_equal(rename(beside, object_writer_path(w)), 0);
    assert_int_equal(object_writer_finish(&w, NULL, &d, NULL), 0);
    digest_of("by a library", 12, &expected);
    assert_true(digest_equal(&d, &expected));
    assert_content(&o, &d, "by a library");
}

TEST(adopt_takes_over_a_file)
{
    struct objects o;
    struct digest d, expected;
    char dir[OBJECTS_PATH_BYTES], path[OBJECTS_PATH_BYTES + 16];
    open_objects(&o);
    assert_int_equal(objects_make_dir(&o, dir), 0);
    snprintf(path, sizeof path, "%s/blob", dir);
    FILE *f = fopen(path, "wb");
    fputs("a blob", f);
    fclose(f);
    assert_int_equal(objects_adopt(&o, path, &d), 0);
    digest_of("a blob", 6, &expected);
    assert_true(digest_equal(&d, &expected));
    assert_content(&o, &d, "a blob");
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_equal(objects_adopt(&o, path, &d), ERR_NOT_FOUND);
    objects_remove_dir(dir);
    assert_int_equal(entries_in_tmp(&o), 0);
}

TEST(opening_sweeps_what_was_left)
{
    struct objects o;
    struct digest d;
    char dir[OBJECTS_PATH_BYTES], path[OBJECTS_PATH_BYTES + 16];
    open_objects(&o);
    assert_int_equal(write_object(&o, "stays", NULL, &d, NULL), 0);
    assert_int_equal(objects_make_dir(&o, dir), 0);
    snprintf(path, sizeof path, "%s/left", dir);
    fclose(fopen(path, "wb"));
    snprintf(path, sizeof path, "%s/tmp/tmp.123", o.dir);
    fclose(fopen(path, "wb"));
    open_objects(&o);
    assert_int_equal(entries_in_tmp(&o), 0);
    assert_content(&o, &d, "stays");
}

/* A torn file from a disk that lied is replaced. */
TEST(a_shorter_file_is_replaced)
{
    struct objects o;
    struct digest d;
    char path[OBJECTS_PATH_BYTES];
    bool existed = true;
    open_objects(&o);
    assert_int_equal(write_object(&o, "long enough", NULL, &d, NULL), 0);
    objects_path(&o, &d, path);
    assert_int_equal(truncate(path, 3), 0);
    assert_int_equal(write_object(&o, "long enough", NULL, &d, &existed), 0);
    assert_false(existed);
    assert_content(&o, &d, "long enough");
}

#define WRITERS 8
#define ROUNDS  20

static struct objects shared_objects;

static void *write_many(void *arg)
{
    long *failures = arg;
    for (int i = 0; i < ROUNDS; i++) {
        char text[32];
        struct object_writer *w;
        struct digest d;
        snprintf(text, sizeof text, "round %d", i);
        if (object_writer_begin(&shared_objects, &w)) return NULL;
        int error = object_writer_append(w, text, strlen(text));
        if (object_writer_finish(&w, NULL, &d, NULL) || error) ++*failures;
        if (!objects_have(&shared_objects, &d, NULL)) ++*failures;
    }
    return NULL;
}

TEST(writers_of_one_digest_do_not_disturb_each_other)
{
    pthread_t threads[WRITERS];
    long failures[WRITERS] = {0};
    open_objects(&shared_objects);
    for (int i = 0; i < WRITERS; i++) pthread_create(&threads[i], NULL, write_many, &failures[i]);
    for (int i = 0; i < WRITERS; i++) {
        pthread_join(threads[i], NULL);
        assert_int_equal(failures[i], 0);
    }
    for (int i = 0; i < ROUNDS; i++) {
        char text[32];
        struct digest d;
        snprintf(text, sizeof text, "round %d", i);
        digest_of(text, strlen(text), &d);
        assert_content(&shared_objects, &d, text);
    }
    assert_int_equal(entries_in_tmp(&shared_objects), 0);
}

TEST(an_impossible_folder_is_an_error)
{
    struct objects o;
    char path[128], longer[8192];
    snprintf(path, sizeof path, "%s/file", root);
    fclose(fopen(path, "wb"));
    snprintf(path, sizeof path, "%s/file/data", root);
    assert_int_equal(objects_open(&o, path, false), ERR_IO);
    memset(longer, 'a', sizeof longer - 1);
    longer[sizeof longer - 1] = 0;
    assert_int_equal(objects_open(&o, longer, false), ERR_LIMIT);
}
