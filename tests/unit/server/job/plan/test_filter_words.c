/* The words of filters and of other choices: openapi.yaml, the viewer's form and the command line
 * give those that job documents take and plans report. The working directory is the repository. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "proto/job/job_internal.h"
#include "server/cli/job_changes.h"
#include "server/job/plan/plan_parts.h"
#include "tests/unit/unit.h"

#define CONTRACT "proto/openapi.yaml"
#define FORM     "web/job/job_fields.js"
#define BYTES    262144

/* The file with every run of white space as one space. */
static char *read_page(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *page = calloc(1, BYTES), *to = page;
    if (!file) fail_msg("%s cannot be opened", path);
    assert_non_null(page);
    for (int c, last = 0; (c = fgetc(file)) != EOF && to - page < BYTES - 1; last = c) {
        if (c == '\n') c = ' ';
        if (c != ' ' || last != ' ') *to++ = (char)c;
    }
    fclose(file);
    return page;
}

static void expect(const char *path, const char *text)
{
    char *page = read_page(path);
    if (!strstr(page, text)) fail_msg("%s does not say %s", path, text);
    free(page);
}

/* "a, b, c", each word in quotation marks or bare. */
static void list(const struct json_choice *words, const char *mark, char out[512])
{
    size_t n = 0;
    for (const struct json_choice *w = words; w->name; w++)
        n += (size_t)snprintf(out + n, 512 - n, "%s%s%s%s", w == words ? "" : ", ", mark, w->name,
                              mark);
    assert_true(n < 512);
}

static void contract_has(const char *before, const struct json_choice *words)
{
    char names[512], text[640];
    list(words, "", names);
    snprintf(text, sizeof text, "%s enum: [%s]", before, names);
    expect(CONTRACT, text);
}

TEST(documents_take_those_of_the_contract)
{
    contract_has(" Layer: type: string", job_layer_words);
    contract_has(" pixel_type: {type: string,", job_pixel_type_words);
    contract_has(" pixel_filter: {type: string,", job_pixel_filter_words);
    contract_has(" profile: {type: string,", job_profile_words);
    contract_has(" method: type: string", job_method_words);
    contract_has(" indirect: type: string", job_indirect_words);
    contract_has(" glossy: type: string", job_glossy_words);
    contract_has(" lens: type: string", job_lens_words);
}

static void form_has(const char *member, const struct json_choice *words)
{
    char names[512], text[640];
    char *page = read_page(FORM);
    list(words, "\"", names);
    snprintf(text, sizeof text, "at: \"/filter/%s\"", member);
    const char *field = strstr(page, text);
    snprintf(text, sizeof text, "of: [%s]", names);
    const char *of = field ? strstr(field, "of: [") : NULL;
    if (!of || strncmp(of, text, strlen(text)) != 0) fail_msg("%s does not say %s", FORM, text);
    free(page);
}

TEST(the_form_offers_them)
{
    form_has("method", job_method_words);
    form_has("indirect", job_indirect_words);
    form_has("glossy", job_glossy_words);
    form_has("lens", job_lens_words);
}

static void option_has(const char *name, const struct json_choice *words)
{
    struct job_changes changes;
    const struct option_line options[] = {JOB_CHANGES_OPTIONS(&changes)};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        if (strcmp(options[i].name, name) != 0) continue;
        for (; words->name; words++)
            if (!strstr(options[i].value, words->name))
                fail_msg("--%s does not say %s", name, words->name);
        return;
    }
    fail_msg("there is no --%s", name);
}

TEST(options_name_them)
{
    option_has("method", job_method_words);
    option_has("indirect", job_indirect_words);
    option_has("glossy", job_glossy_words);
    option_has("lens", job_lens_words);
}

static void report_has(const char *member, const char *(*name)(uint32_t filter), uint32_t last)
{
    struct json_choice words[16] = {0};
    char before[64];
    for (uint32_t filter = 0; filter <= last; filter++) words[filter].name = name(filter);
    snprintf(before, sizeof before, " %s: {type: string,", member);
    contract_has(before, words);
}

TEST(plans_report_those_of_the_contract)
{
    report_has("indirect_filter", plan_indirect_filter_name, INDIRECT_FILTER_SHEARED);
    report_has("glossy_filter", plan_glossy_filter_name, GLOSSY_FILTER_LAST);
    report_has("lens_filter", plan_lens_filter_name, LENS_FILTER_SHEARED);
    report_has("lens_relight", plan_lens_relight_name, LENS_RELIGHT_SKY);
}
