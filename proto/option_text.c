#include "proto/option_text.h"

#include <stdbool.h>
#include <string.h>

#define TEXT_COLUMN 30
#define LINE_WIDTH  80

void option_text_wrap(FILE *out, const char *text, int column)
{
    int at = column;
    while (*text) {
        const int length = (int)strcspn(text, " ");
        const bool is_first = at == column;
        if (!is_first && at + 1 + length > LINE_WIDTH) {
            fprintf(out, "\n%*s", column, "");
            at = column;
        } else if (!is_first) {
            fputc(' ', out);
            at++;
        }
        fprintf(out, "%.*s", length, text);
        at += length;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', out);
}

void option_text_help(FILE *out, const struct option_text *option)
{
    char left[128], letter[8] = "    ";
    if (option->letter) snprintf(letter, sizeof letter, "-%c, ", option->letter);
    const int length = snprintf(left, sizeof left, "  %s--%s%s%s", letter, option->name,
                                option->value ? " " : "", option->value ? option->value : "");
    if (length < TEXT_COLUMN)
        fprintf(out, "%-*s", TEXT_COLUMN, left);
    else
        fprintf(out, "%s\n%*s", left, TEXT_COLUMN, "");
    option_text_wrap(out, option->text, TEXT_COLUMN);
}

void option_text_dump(FILE *out, const struct option_text *option)
{
    const char letter[] = {'-', option->letter, '\0'};
    fprintf(out, "option\t%s\t--%s\t%s\t%s\n", option->letter ? letter : "", option->name,
            option->value ? option->value : "", option->text);
}
