/* Cookies of browsers: what stands for which token, and for how long; and which texts are tokens.
 */
#include <stdlib.h>
#include <string.h>

#include "server/access/sign_ins.h"
#include "server/access/tokens.h"
#include "tests/unit/unit.h"

static const struct digest first = {{1}}, second = {{2}};
static struct sign_ins all;

static int clear(void **state)
{
    (void)state;
    sign_ins_init(&all, SIGN_IN_S);
    return 0;
}

EACH_TEST(clear, NULL);

static const struct digest *find(const char *cookie, uint64_t now_s)
{
    struct sign_in_ref ref;
    return sign_ins_find(&all, cookie, now_s, &ref);
}

TEST(a_cookie_stands_for_its_token)
{
    char a[SIGN_IN_TEXT_BYTES], b[SIGN_IN_TEXT_BYTES];
    assert_int_equal(sign_ins_add(&all, &first, 100, a), 0);
    assert_int_equal(sign_ins_add(&all, &second, 100, b), 0);
    assert_string_not_equal(a, b);
    assert_true(digest_equal(find(a, 100), &first) && digest_equal(find(b, 100), &second));
    sign_ins_remove(&all, a);
    assert_null(find(a, 100));
    assert_non_null(find(b, 100));
}

TEST(it_ends)
{
    char a[SIGN_IN_TEXT_BYTES];
    assert_int_equal(sign_ins_add(&all, &first, 100, a), 0);
    assert_non_null(find(a, 99 + SIGN_IN_S));
    assert_null(find(a, 100 + SIGN_IN_S));
}

static struct digest token_of(unsigned number)
{
    return (struct digest){{(uint8_t)number, (uint8_t)(number >> 8), 7}};
}

static void add(unsigned token, char cookie[SIGN_IN_TEXT_BYTES])
{
    const struct digest hash = token_of(token);
    assert_int_equal(sign_ins_add(&all, &hash, 1, cookie), 0);
}

TEST(a_token_pushes_out_its_own_oldest)
{
    char other[SIGN_IN_TEXT_BYTES], own[SIGN_INS_OF_TOKEN + 1][SIGN_IN_TEXT_BYTES];
    add(1, other);
    for (int i = 0; i <= SIGN_INS_OF_TOKEN; i++) add(2, own[i]);
    assert_null(find(own[0], 2));
    for (int i = 1; i <= SIGN_INS_OF_TOKEN; i++) assert_non_null(find(own[i], 2));
    for (int i = 0; i < 2 * SIGN_INS_MAX; i++) add(2, own[0]);
    assert_non_null(find(own[0], 2));
    assert_non_null(find(other, 2));
}

/* All places but the last are taken, by tokens of one sign-in and of three. */
TEST(whoever_has_most_makes_room)
{
    char lone[SIGN_IN_TEXT_BYTES], many[2][3][SIGN_IN_TEXT_BYTES], last[SIGN_IN_TEXT_BYTES];
    add(1, lone);
    for (unsigned i = 0; i < 6; i++) add(2 + i % 2, many[i % 2][i / 2]);
    for (unsigned i = 8; i <= SIGN_INS_MAX; i++) add(1000 + i, last);
    add(5, last); /* the oldest of the two that have three goes */
    assert_null(find(many[0][0], 2));
    assert_non_null(find(many[1][0], 2));
    add(6, last); /* now the other one has most */
    assert_null(find(many[1][0], 2));
    add(7, last); /* both have two */
    assert_null(find(many[0][1], 2));
    assert_non_null(find(many[0][2], 2));
    assert_non_null(find(many[1][1], 2));
    assert_non_null(find(lone, 2));
    assert_non_null(find(last, 2));
}

TEST(places_of_the_past_are_free)
{
    char a[SIGN_IN_TEXT_BYTES], b[SIGN_IN_TEXT_BYTES];
    const struct digest late = token_of(1);
    for (unsigned i = 0; i < SIGN_INS_MAX; i++) add(10 + i, a);
    assert_int_equal(sign_ins_add(&all, &late, 1 + SIGN_IN_S, b), 0);
    assert_int_equal(sign_ins_add(&all, &late, 1 + SIGN_IN_S, a), 0);
    assert_non_null(find(b, 1 + SIGN_IN_S));
    unsigned taken = 0;
    for (unsigned i = 0; i < SIGN_INS_MAX; i++) taken += all.list[i].number != 0;
    assert_int_equal(taken, 2);
}

/* What was let in by a sign-in asks whether it holds: a place that is another's is not it. */
TEST(a_reference_ends_with_its_sign_in)
{
    char a[SIGN_IN_TEXT_BYTES], b[SIGN_IN_TEXT_BYTES];
    struct sign_in_ref ref, none = {0};
    add(1, a);
    assert_non_null(sign_ins_find(&all, a, 1, &ref));
    assert_true(sign_ins_holds(&all, &ref, SIGN_IN_S));
    assert_false(sign_ins_holds(&all, &ref, 1 + SIGN_IN_S));
    assert_false(sign_ins_holds(&all, &none, 1));
    sign_ins_remove(&all, a);
    assert_false(sign_ins_holds(&all, &ref, 1));
    assert_null(sign_ins_find(&all, a, 1, &none));
    assert_int_equal(none.number, 0);
    for (unsigned i = 0; i < SIGN_INS_MAX; i++) add(10 + i, b);
    assert_false(sign_ins_holds(&all, &ref, 1));
}

static bool is_second(void *ctx, const struct digest *token)
{
    (void)ctx;
    return digest_equal(token, &second);
}

TEST(those_of_tokens_that_are_gone_go)
{
    char a[SIGN_IN_TEXT_BYTES], b[SIGN_IN_TEXT_BYTES];
    assert_int_equal(sign_ins_add(&all, &first, 1, a), 0);
    assert_int_equal(sign_ins_add(&all, &second, 1, b), 0);
    sign_ins_sweep(&all, is_second, NULL);
    assert_null(find(a, 2));
    assert_non_null(find(b, 2));
}

TEST(other_texts_stand_for_nothing)
{
    char a[SIGN_IN_TEXT_BYTES], longer[SIGN_IN_TEXT_BYTES + 1] = "";
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

TEST(tokens_are_found_whole)
{
    char text[TOKEN_TEXT_BYTES];
    struct tokens *tokens = calloc(1, sizeof *tokens + 2 * sizeof(struct token));
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

TEST(texts_that_may_be_tokens)
{
    char most[257]; /* without an end: a sanitizer sees a read beyond */
    memset(most, 'a', sizeof most);
    assert_true(tokens_is_text(most, 256) && tokens_is_text(most, 20));
    assert_false(tokens_is_text(most, 257) || tokens_is_text(most, 19));
    assert_true(tokens_is_text("abcdefghij-._~+/0189==", 22));
    assert_false(tokens_is_text("abcdefghij klmnopqrstuv", 23));
    assert_false(tokens_is_text("abcdefghij\"klmnopqrstuv", 23));
}
