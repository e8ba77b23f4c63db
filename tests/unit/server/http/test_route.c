/* From a request target to a route: what is found, what is refused and why. */
#include <stdlib.h>
#include <string.h>

#include "server/http/request_check.h"
#include "server/http/route.h"
#include "tests/unit/unit.h"

#define ID  "0123456789abcdefghjkmnpqrs"
#define HEX "5891b5b522d5df086d0ff0b110fbd9d21bb4fc7163af34d08286a2e846f6be03"

static int read_and_find(enum method method, const char *raw, struct route_match *m)
{
    struct target target;
    struct fault fault = {0};
    int error = target_read(raw, &target, &fault);
    if (!error) {
        bool is_file = strcmp(target.path, "/main.js") == 0 || strcmp(target.path, "/") == 0;
        error = route_find(method, true, &target, is_file, m, &fault);
    }
    if (error) assert_true(fault.detail[0] != '\0');
    target_fini(&target);
    return error;
}

TEST(finds_every_resource)
{
    static const struct {
        enum method method;
        const char *target;
        enum route_id id;
    } cases[] = {
        {METHOD_PUT, "/v1/assets/" HEX, ROUTE_ASSET_PUT},
        {METHOD_HEAD, "/v1/assets/" HEX, ROUTE_ASSET_HEAD},
        {METHOD_DELETE, "/v1/assets/" HEX, ROUTE_ASSET_DELETE},
        {METHOD_POST, "/v1/jobs", ROUTE_JOB_SUBMIT},
        {METHOD_POST, "/v1/jobs?dry_run=1", ROUTE_JOB_SUBMIT},
        {METHOD_GET, "/v1/jobs?limit=5&state=running&text=a%20b&cursor=" ID, ROUTE_JOB_LIST},
        {METHOD_GET, "/v1/jobs/" ID, ROUTE_JOB_GET},
        {METHOD_HEAD, "/v1/jobs/" ID, ROUTE_JOB_GET},
        {METHOD_DELETE, "/v1/jobs/" ID "?purge=1", ROUTE_JOB_DELETE},
        {METHOD_GET, "/v1/jobs/" ID "/frames/12/image.exr", ROUTE_IMAGE_EXR},
        {METHOD_GET, "/v1/jobs/" ID "/thumbnail?of=1", ROUTE_THUMBNAIL},
        {METHOD_GET, "/v1/jobs/" ID "/frames/0/image.png?layer=a&exposure=-1", ROUTE_IMAGE_PNG},
        {METHOD_GET, "/v1/jobs/" ID "/events", ROUTE_EVENTS},
        {METHOD_GET, "/v1/jobs/" ID "/pixels?layer=beauty", ROUTE_PIXELS},
        {METHOD_GET, "/v1/workers", ROUTE_WORKER_LIST},
        {METHOD_PATCH, "/v1/workers/18", ROUTE_WORKER_PATCH},
        {METHOD_GET, "/v1/stats", ROUTE_STATS},
        {METHOD_GET, "/%6civez", ROUTE_LIVEZ},
        {METHOD_GET, "/readyz", ROUTE_READYZ},
        {METHOD_GET, "/metrics", ROUTE_METRICS},
        {METHOD_GET, "/openapi.yaml", ROUTE_OPENAPI},
        {METHOD_GET, "/", ROUTE_INDEX},
        {METHOD_GET, "/?any=thing", ROUTE_INDEX},
        {METHOD_GET, "/main.js", ROUTE_FILE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct route_match m;
        assert_int_equal(read_and_find(cases[i].method, cases[i].target, &m), 0);
        assert_int_equal(m.id, cases[i].id);
    }
}

TEST(reads_the_parts)
{
    struct route_match m;
    struct digest want;
    assert_int_equal(digest_from_hex(HEX, &want), 0);
    assert_int_equal(read_and_find(METHOD_PUT, "/v1/assets/" HEX, &m), 0);
    assert_true(digest_equal(&m.sha256, &want));
    assert_int_equal(read_and_find(METHOD_GET, "/v1/jobs/" ID "/frames/2147483647/image.exr", &m),
                     0);
    assert_string_equal(m.job, ID);
    assert_int_equal(m.frame, INT32_MAX);
    assert_int_equal(read_and_find(METHOD_PATCH, "/v1/workers/9999999999999999999", &m), 0);
    assert_true(m.worker == UINT64_C(9999999999999999999));
}

TEST(refuses)
{
    static const struct {
        enum method method;
        const char *target;
        int error;
    } cases[] = {
        {METHOD_GET, "/nothing", ERR_NOT_FOUND},
        {METHOD_GET, "/v1", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/frames", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/events/more", ERR_NOT_FOUND},
        {METHOD_GET, "/a/b/c/d/e/f/g/h/i", ERR_NOT_FOUND},
        {METHOD_GET, "/{file}", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/0123456789abcdefghjkmnpqr", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "q", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/0123456789ABCDEFGHJKMNPQRS", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/frames/-1/image.exr", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/frames/01/image.exr", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/frames/1e1/image.exr", ERR_NOT_FOUND},
        {METHOD_GET, "/v1/jobs/" ID "/frames/2147483648/image.exr", ERR_NOT_FOUND},
        {METHOD_PATCH, "/v1/workers/99999999999999999999", ERR_NOT_FOUND},
        {METHOD_PUT, "/v1/assets/abc", ERR_SYNTAX},
        {METHOD_DELETE, "/v1/assets/abc", ERR_SYNTAX},
        {METHOD_PUT, "/v1/assets/5891B5B522D5DF086D0FF0B110FBD9D21BB4FC7163AF34D08286A2E846F6BE03",
         ERR_SYNTAX},
        {METHOD_GET, "/v1/jobs?limt=5", ERR_UNKNOWN_MEMBER},
        {METHOD_GET, "/v1/jobs?limit%20cursor=5", ERR_UNKNOWN_MEMBER},
        {METHOD_GET, "/v1/jobs?limit=5&limit=6", ERR_SYNTAX},
        {METHOD_GET, "/v1/jobs?=5", ERR_SYNTAX},
        {METHOD_GET, "/v1/jobs?limit=%zz", ERR_SYNTAX},
        {METHOD_GET, "/../etc/passwd", ERR_SYNTAX},
        {METHOD_GET, "/%2e%2e/etc/passwd", ERR_SYNTAX},
        {METHOD_GET, "/v1/./jobs", ERR_SYNTAX},
        {METHOD_GET, "//main.js", ERR_SYNTAX},
        {METHOD_GET, "/main.js HTTP/1.1", ERR_SYNTAX},
        {METHOD_GET, "/v1/jobs?text=a b", ERR_SYNTAX},
        {METHOD_GET, "/main.js\t", ERR_SYNTAX},
        {METHOD_GET, "/v1/jobs/", ERR_SYNTAX},
        {METHOD_GET, "/main.js%00.png", ERR_SYNTAX},
        {METHOD_GET, "/..%2fmain.js", ERR_SYNTAX},
        {METHOD_GET, "/..%5cmain.js", ERR_SYNTAX},
        {METHOD_GET, "/%", ERR_SYNTAX},
        {METHOD_GET, "/%4", ERR_SYNTAX},
        {METHOD_GET, "http://localhost/livez", ERR_SYNTAX},
        {METHOD_GET, "*", ERR_SYNTAX},
        {METHOD_GET, "", ERR_SYNTAX},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct route_match m;
        int error = read_and_find(cases[i].method, cases[i].target, &m);
        if (error != cases[i].error) fail_msg("%s: %s", cases[i].target, error_name(error));
    }
}

TEST(names_the_methods_of_a_path)
{
    struct route_match m;
    assert_int_equal(read_and_find(METHOD_PUT, "/v1/jobs", &m), ERR_STATE);
    assert_string_equal(m.allow, "POST, GET, HEAD");
    assert_int_equal(read_and_find(METHOD_GET, "/v1/assets/" HEX, &m), ERR_STATE);
    assert_string_equal(m.allow, "PUT, HEAD, DELETE");
    assert_int_equal(read_and_find(METHOD_POST, "/main.js", &m), ERR_STATE);
    assert_string_equal(m.allow, "GET, HEAD");
}

TEST(caps_the_target)
{
    char *raw = malloc(LIMIT_HTTP_URL_BYTES + 2);
    struct target target;
    struct fault fault;
    memset(raw, 'a', LIMIT_HTTP_URL_BYTES + 1);
    raw[0] = '/';
    raw[LIMIT_HTTP_URL_BYTES + 1] = '\0';
    assert_int_equal(target_read(raw, &target, &fault), ERR_LIMIT);
    raw[LIMIT_HTTP_URL_BYTES] = '\0';
    assert_int_equal(target_read(raw, &target, &fault), 0);
    target_fini(&target);
    free(raw);
}

TEST(any_bytes_are_survived)
{
    static const char alphabet[] = "/%0.2e5cf?&=a\\\x01\xff v1jobs";
    srand(3);
    for (int round = 0; round < 50000; round++) {
        char raw[48] = "/";
        struct target target;
        struct fault fault;
        struct route_match m;
        size_t n = 1 + (size_t)rand() % 46;
        for (size_t i = 1; i < n; i++) raw[i] = alphabet[(size_t)rand() % (sizeof alphabet - 1)];
        raw[n] = '\0';
        if (target_read(raw, &target, &fault) != 0) continue;
        for (size_t i = 0; i < target.segment_count; i++) {
            assert_null(strchr(target.segment[i], '/'));
            assert_string_not_equal(target.segment[i], "..");
        }
        (void)route_find(METHOD_GET, true, &target, false, &m, &fault);
        target_fini(&target);
    }
}

TEST(hosts)
{
    static const char *const good[] = {"localhost",       "LocalHost:1", "127.0.0.1",
                                       "127.0.0.1:65535", "[::1]",       "[::1]:8040"};
    static const char *const bad[] = {"",
                                      "localhost.evil.example",
                                      "evil.example",
                                      "127.0.0.1.",
                                      "127.0.0.10",
                                      "127.0.0.1:",
                                      "[::1]x",
                                      "localhost:80a",
                                      "localhost:123456",
                                      "localhost@evil.example"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        assert_true(request_check_host_is_local(good[i]));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_false(request_check_host_is_local(bad[i]));
}
