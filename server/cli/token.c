/* shearwater token: creates an access token and adds its hash to a file for serve --tokens. */
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <string.h>

#include "server/access/tokens.h"
#include "server/cli/cli.h"
#include "server/cli/job_file.h"
#include "server/cli/option.h"

/* Texts that are too long to be kept are refused here; the rest is checked when the file is
 * written. */
static int fill(struct token *token, const char *name, const char *tenant, const char *role,
                struct fault *fault)
{
    if (strlen(name) >= sizeof token->name || strlen(tenant) >= sizeof token->tenant)
        return fault_set(fault, ERR_LIMIT, "", "names and tenants have at most 64 characters");
    memcpy(token->name, name, strlen(name) + 1);
    memcpy(token->tenant, tenant, strlen(tenant) + 1);
    if (!role_from_name(role, &token->role))
        return fault_set(fault, ERR_RANGE, "--role", "must be viewer, submitter or admin");
    return 0;
}

static int make(const char *path, struct token *token, struct fault *fault)
{
    char text[TOKEN_TEXT_BYTES];
    int error = tokens_make(text);
    if (error) return fault_set(fault, error, "", "the system gives no random numbers");
    digest_of(text, strlen(text), &token->hash);
    error = tokens_add(path, token, fault);
    if (!error && (printf("%s\n", text) < 0 || fflush(stdout) != 0))
        error = fault_set(fault, ERR_IO, "", "the token could not be printed: it is lost");
    gnutls_memset(text, 0, sizeof text);
    return error;
}

int cli_token(int argc, char **argv)
{
    const char *name = NULL, *tenant = NULL, *role = "submitter";
    const struct option_line lines[] = {
        {"name", 'n', OPTION_TEXT, "NAME", "name of the token, such as ana-laptop", 0, 0, &name},
        {"tenant", 't', OPTION_TEXT, "TENANT",
         "tenant whose jobs and files it gives access to (default: NAME)", 0, 0, &tenant},
        {"role", 'r', OPTION_TEXT, "viewer|submitter|admin", "what it allows (default: submitter)",
         0, 0, &role},
    };
    const struct option_table table = {
        .usage = "shearwater token FILE --name NAME [options]",
        .summary = "Creates an access token, prints it once, and adds its hash to FILE. A running "
                   "coordinator reads FILE again on SIGHUP.",
        .lines = lines,
        .line_count = sizeof lines / sizeof *lines,
        .least_arguments = 1,
        .most_arguments = 1,
    };
    struct token token = {.role = ROLE_NONE};
    struct fault fault = {0};
    int arguments, status = option_parse(&table, argc, argv, &arguments);
    if (status != OPTION_GO_ON) return status;
    if (!name) {
        fprintf(stderr, "shearwater token: --name is missing\n");
        return 2;
    }
    int error = fill(&token, name, tenant ? tenant : name, role, &fault);
    if (!error) error = make(argv[1], &token, &fault);
    return error ? job_file_complain("token", &fault) : 0;
}
