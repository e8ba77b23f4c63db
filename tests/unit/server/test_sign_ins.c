/* Cookies of browsers: what stands for which token, and for how long; and which texts are tokens.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "server/access/sign_ins.h"
#include "server/access/tokens.h"

static const struct digest first = {{1}}, second = {{2}};
static struct sign_ins all;

static int clear(void **state)
{
    (void)state;
    memset(&all, 0, sizeof all);
    return 0;
}

static const struct digest *find(const char *cookie, uint64_t now_s)
{
    return sign_ins_find(&all, cookie, now_s);
}

static void a_cookie_stands_for_its_token(void **state)
{
    char a[SIGN_IN_TEXT_BYTES], b[SIGN_IN_TEXT_BYTES];
    (void)state;
    assert_int_equal(sign_ins_add(&all, &first, 100, a), 0);
    assert_int_equal(sign_ins_add(&all, &second, 100, b), 0);
    assert_string_not_equal(a, b);
    assert_true(digest_equal(find(a, 100), &first) && digest_equal(find(b, 100), &second));
    sign_ins_remove(&all, a);
    assert_null(find(a, 100));
    assert_non_null(find(b, 100));
}

static void it_ends(void **state)
{
    char a[SIGN_IN_TEXT_BYTES];
    (void)state;
    assert_int_equal(sign_ins_add(&all, &first, 100, a), 0);
    assert_non_null(find(a, 99 + SIGN_IN_S));
    assert_null(find(a, 100 + SIGN_IN_S));
}

static void the_oldest_goes(void **state)
{
    char a[SIGN_IN_TEXT_BYTES], last[SIGN_IN_TEXT_BYTES];
    (void)state;
    assert_int_equal(sign_ins_add(&all, &first, 1, a), 0);
    for (uint64_t i = 1; i < SIGN_INS_MOST; i++)
        assert_int_equal(sign_ins_add(&all, &second, 1 + i, last), 0);
    assert_non_null(find(a, 2000));
    assert_int_equal(sign_ins_add(&all, &second, 2000, last), 0);
    assert_null(find(a, 2000));
    assert_non_null(find(last, 2000));
}

static void other_texts_stand_for_nothing(void **state)
{
    char a[SIGN_IN_TEXT_BYTES], longer[SIGN_IN_TEXT_BYTES + 1] = "";
    (void)state;
    assert_null(find("", 1));
    assert_int_equal(sign_ins_add(&all, &first, 1, a), 0);
    memcpy(longer, a, sizeof a);
    strcat(longer, "0");
    assert_null(find(longer, 1));
    a[SIGN_IN_TEXT_BYTES - 2] ^= 1;
    assert_null(find(a, 1));
    a[SIGN_IN_TEXT_BYTES - 2] = '\0';
    assert_null(find(a, 1));
}

static void tokens_are_found_whole(void **state)
{
    char text[TOKEN_TEXT_BYTES];
    struct tokens *tokens = calloc(1, sizeof *tokens + 2 * sizeof(struct token));
    (void)state;
    assert_non_null(tokens);
    assert_int_equal(tokens_make(text), 0);
    assert_int_equal(strlen(text), TOKEN_TEXT_BYTES - 1);
    tokens->count = 2;
    digest_of(text, strlen(text), &tokens->list[1].hash);
    assert_ptr_equal(tokens_find(tokens, text, strlen(text)), &tokens->list[1]);
    assert_null(tokens_find(tokens, text, strlen(text) - 1));
    assert_null(tokens_find(tokens, "", 0));
    text[5] ^= 1;
    assert_null(tokens_find(tokens, text, strlen(text)));
    free(tokens);
}

static void texts_that_may_be_tokens(void **state)
{
    char most[258];
    (void)state;
    memset(most, 'a', sizeof most);
    assert_true(tokens_is_text(most, 256) && tokens_is_text(most, 20));
    assert_false(tokens_is_text(most, 257) || tokens_is_text(most, 19));
    assert_true(tokens_is_text("abcdefghij-._~+/0189==", 22));
    assert_false(tokens_is_text("abcdefghij klmnopqrstuv", 23));
    assert_false(tokens_is_text("abcdefghij\"klmnopqrstuv", 23));
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, clear)
    const struct CMUnitTest tests[] = {
        TEST(a_cookie_stands_for_its_token),
        TEST(it_ends),
        TEST(the_oldest_goes),
        TEST(other_texts_stand_for_nothing),
        TEST(tokens_are_found_whole),
        TEST(texts_that_may_be_tokens),
    };
    return cmocka_run_group_tests_name("sign_ins", tests, NULL, NULL);
}
