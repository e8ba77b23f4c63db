#pragma once
/* The subcommands of `shearwater`. argv[0] is the subcommand's name; the result is the exit status:
 * 0, 1 when the command failed, 2 for wrong usage. */

int cli_serve(int argc, char **argv);
int cli_render(int argc, char **argv);
int cli_submit(int argc, char **argv);
int cli_jobs(int argc, char **argv);
int cli_watch(int argc, char **argv);
int cli_steer(int argc, char **argv);
int cli_mark(int argc, char **argv);
int cli_cancel(int argc, char **argv);
int cli_health(int argc, char **argv);
int cli_token(int argc, char **argv);
int cli_workers(int argc, char **argv);
int cli_replay(int argc, char **argv);
int cli_compare(int argc, char **argv);
