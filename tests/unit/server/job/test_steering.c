/* The document that steers a job comes from anybody: every fault is named at its place. */
#include <stdlib.h>
#include <string.h>

#include "server/job/steering.h"
#include "tests/unit/unit.h"

static void read_well(const char *text, struct steering *out)
{
    struct fault fault = {0};
    assert_int_equal(steering_read(text, strlen(text), out, &fault), 0);
}

TEST(reads_what_is_given)
{
    struct steering s;
    read_well("{\"priority\": -100}", &s);
    assert_int_equal(s.given, STEERING_PRIORITY);
    assert_int_equal(s.priority, -100);
    read_well("{\"paused\": true, \"priority\": 3}", &s);
    assert_int_equal(s.given, STEERING_PRIORITY | STEERING_PAUSED);
    assert_true(s.paused);
    read_well("{\"region\": {\"x\": 1, \"y\": 2, \"width\": 30, \"height\": 40}}", &s);
    assert_int_equal(s.given, STEERING_REGION);
    assert_int_equal(s.region.x0, 1);
    assert_int_equal(s.region.y0, 2);
    assert_int_equal(s.region.x1, 31);
    assert_int_equal(s.region.y1, 42);
    read_well("{\"near\": {\"x\": 16383, \"y\": 0}}", &s);
    assert_true(s.has_near);
    assert_int_equal(s.near_x, 16383);
}

TEST(null_takes_back)
{
    struct steering s;
    read_well("{\"region\": null, \"near\": null}", &s);
    assert_int_equal(s.given, STEERING_REGION | STEERING_NEAR);
    assert_true(rect_is_empty(s.region));
    assert_false(s.has_near);
}

TEST(refuses_at_the_place)
{
    static const struct {
        const char *text, *pointer;
        int code;
    } cases[] = {
        {"", "", ERR_SYNTAX},
        {"{", "", ERR_SYNTAX},
        {"[]", "", ERR_TYPE},
        {"{}", "", ERR_MISSING},
        {"{\"prority\": 1}", "/prority", ERR_UNKNOWN_MEMBER},
        {"{\"priority\": 101}", "/priority", ERR_RANGE},
        {"{\"priority\": -101}", "/priority", ERR_RANGE},
        {"{\"priority\": 1e300}", "/priority", ERR_RANGE},
        {"{\"priority\": 0.5}", "/priority", ERR_TYPE},
        {"{\"priority\": null}", "/priority", ERR_TYPE},
        {"{\"priority\": \"1\"}", "/priority", ERR_TYPE},
        {"{\"paused\": 1}", "/paused", ERR_TYPE},
        {"{\"paused\": null}", "/paused", ERR_TYPE},
        {"{\"paused\": true, \"paused\": false}", "", ERR_SYNTAX},
        {"{\"region\": []}", "/region", ERR_TYPE},
        {"{\"region\": {}}", "/region/x", ERR_MISSING},
        {"{\"region\": {\"x\": 0, \"y\": 0, \"width\": 0, \"height\": 1}}", "/region/width",
         ERR_RANGE},
        {"{\"region\": {\"x\": -1, \"y\": 0, \"width\": 1, \"height\": 1}}", "/region/x",
         ERR_RANGE},
        {"{\"region\": {\"x\": 0, \"y\": 0, \"width\": 1, \"height\": 2147483648}}",
         "/region/height", ERR_RANGE},
        {"{\"region\": {\"x\": 0, \"y\": 0, \"width\": 1, \"height\": 1, \"z\": 1}}", "/region/z",
         ERR_UNKNOWN_MEMBER},
        {"{\"near\": {\"x\": 1}}", "/near/y", ERR_MISSING},
        {"{\"near\": {\"x\": 1, \"y\": 16384}}", "/near/y", ERR_RANGE},
        {"{\"near\": {\"x\": 1.5, \"y\": 1}}", "/near/x", ERR_TYPE},
        {"{\"near\": false}", "/near", ERR_TYPE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct steering s;
        struct fault fault = {0};
        int error = steering_read(cases[i].text, strlen(cases[i].text), &s, &fault);
        if (error != cases[i].code || strcmp(fault.pointer, cases[i].pointer) != 0)
            fail_msg("%s: %s at \"%s\" (%s)", cases[i].text, error_name(error), fault.pointer,
                     fault.detail);
        assert_true(fault.detail[0] != '\0');
    }
}

/* Any text cut anywhere, and any byte of it replaced, is read or refused with a sentence. */
TEST(survives_damage)
{
    static const char text[] = "{\"priority\": 5, \"paused\": false, \"region\": {\"x\": 1, \"y\": "
                               "2, \"width\": 3, \"height\": 4}, \"near\": {\"x\": 7, \"y\": 8}}";
    char damaged[sizeof text];
    for (size_t i = 0; i < sizeof text - 1; i++) {
        for (int byte = -1; byte < 256; byte += 5) {
            struct steering s;
            struct fault fault = {0};
            memcpy(damaged, text, sizeof text);
            if (byte >= 0) damaged[i] = (char)byte;
            size_t size = byte < 0 ? i : sizeof text - 1;
            if (steering_read(damaged, size, &s, &fault) != 0) {
                assert_true(fault.code < 0 && fault.detail[0] != '\0');
                continue;
            }
            assert_true(s.given != 0 && abs(s.priority) <= LIMIT_PRIORITY);
            assert_true(s.region.x0 >= 0 && s.region.x1 <= 2 * LIMIT_IMAGE_SIDE_PX);
        }
    }
}

static int check(int x, int y, int width, int height, const char **pointer)
{
    static struct fault fault;
    struct steering s = {.given = STEERING_REGION, .region = {x, y, x + width, y + height}};
    fault = (struct fault){0};
    int error = steering_check(&s, 320, 200, &fault);
    *pointer = fault.pointer;
    return error;
}

TEST(stays_within_the_picture)
{
    const char *pointer;
    assert_int_equal(check(0, 0, 320, 200, &pointer), 0);
    assert_int_equal(check(319, 199, 1, 1, &pointer), 0);
    assert_int_equal(check(0, 0, 321, 200, &pointer), ERR_RANGE);
    assert_string_equal(pointer, "/region/width");
    assert_int_equal(check(320, 0, 1, 1, &pointer), ERR_RANGE);
    assert_string_equal(pointer, "/region/x");
    assert_int_equal(check(0, 100, 1, 101, &pointer), ERR_RANGE);
    assert_string_equal(pointer, "/region/height");
    struct fault fault = {0};
    struct steering s = {.given = STEERING_NEAR, .has_near = true, .near_x = 5, .near_y = 200};
    assert_int_equal(steering_check(&s, 320, 200, &fault), ERR_RANGE);
    assert_string_equal(fault.pointer, "/near/y");
}
