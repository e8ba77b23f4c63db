/* The batch script of an array of workers: times as Slurm writes them, words that the shell reads
 * back as they were, and what is refused. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "server/cli/slurm_array.h"
#include "tests/unit/unit.h"

static const struct slurm_array ordinary = {.connect = "render.example:8041",
                                            .key = "/home/ana/worker.key",
                                            .program = "/opt/bin/shearwater-worker",
                                            .jobs = 4,
                                            .cpus = 16,
                                            .time_s = 7200,
                                            .idle_exit_s = 300,
                                            .connect_within_s = 120};

TEST(times_are_read_as_slurm_writes_them)
{
    static const struct {
        const char *text;
        uint32_t time_s;
    } times[] = {{"2", 120},         {"90", 5400},          {"2:30", 150},
                 {"01:00:00", 3600}, {"12:00:01", 43201},   {"1-0", 86400},
                 {"1-02:03", 93780}, {"1-02:03:04", 93784}, {"365-0", 31536000}};
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        uint32_t time_s = 0;
        struct fault fault = {0};
        assert_int_equal(slurm_array_read_time(times[i].text, &time_s, &fault), 0);
        assert_int_equal(time_s, times[i].time_s);
    }
}

TEST(other_times_are_refused)
{
    static const struct {
        const char *text;
        int error;
    } times[] = {
        {"", ERR_SYNTAX},          {"0", ERR_SYNTAX},           {"-5", ERR_SYNTAX},
        {"1h", ERR_SYNTAX},        {"1:2:3:4", ERR_SYNTAX},     {"1-", ERR_SYNTAX},
        {"UNLIMITED", ERR_SYNTAX}, {"5; rm -rf /", ERR_SYNTAX}, {"99999999999", ERR_SYNTAX},
        {"1", ERR_RANGE},          {"366-0", ERR_RANGE},        {"1:59", ERR_RANGE}};
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        uint32_t time_s = 0;
        struct fault fault = {0};
        if (slurm_array_read_time(times[i].text, &time_s, &fault) != times[i].error)
            fail_msg("%s is taken, or refused for another reason", times[i].text);
        assert_string_equal(fault.pointer, "--time");
    }
}

static char *script_of(const struct slurm_array *array)
{
    char *text = NULL;
    size_t size_bytes = 0;
    FILE *out = open_memstream(&text, &size_bytes);
    assert_non_null(out);
    assert_int_equal(slurm_array_write(array, out), 0);
    fclose(out);
    return text;
}

static void assert_has(const char *script, const char *part)
{
    if (!strstr(script, part)) fail_msg("\"%s\" is not in\n%s", part, script);
}

TEST(the_script_says_what_was_asked_for)
{
    char *script = script_of(&ordinary);
    assert_int_equal(strncmp(script, "#!/bin/bash\n", 12), 0);
    assert_has(script, "\n#SBATCH --array=1-4\n");
    assert_has(script, "\n#SBATCH --cpus-per-task=16\n");
    assert_has(script, "\n#SBATCH --time=0-02:00:00\n");
    assert_has(script, "\n#SBATCH --requeue\n");
    assert_has(script, "\n#SBATCH --signal=B:USR1@60\n");
    assert_has(script, "--threads 16 --lifetime 7170 --idle-exit 300 --connect-within 120");
    assert_null(strstr(script, "SHEARWATER_ISA"));
    free(script);
    struct slurm_array of_one_isa = ordinary;
    of_one_isa.isa = "avx2";
    script = script_of(&of_one_isa);
    assert_has(script, "\nexport SHEARWATER_ISA='avx2'\n");
    free(script);
}

static void write_mock(const char *path)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs("#!/bin/sh\nprintf '%s\\n' \"$@\"\n", f);
    assert_int_equal(fchmod(fileno(f), 0700), 0);
    fclose(f);
}

/* Runs the script with a mock of the worker, which writes its arguments, one a line. */
TEST(the_shell_reads_words_back_as_they_were)
{
    char dir[] = "/tmp/shearwater-test-script-XXXXXX";
    char mock[128], script[128], command[256], line[128];
    struct slurm_array odd = ordinary;
    assert_non_null(mkdtemp(dir));
    snprintf(mock, sizeof mock, "%s/it's $(a) \"test\" of `words`", dir);
    snprintf(script, sizeof script, "%s/script", dir);
    snprintf(command, sizeof command, "bash %s", script);
    write_mock(mock);
    odd.program = mock;
    odd.key = "/home/o'hara; exit 7/$HOME/key";
    FILE *f = fopen(script, "w");
    assert_non_null(f);
    assert_int_equal(slurm_array_write(&odd, f), 0);
    fclose(f);
    f = popen(command, "r");
    assert_non_null(f);
    for (int i = 0; i < 4; i++) assert_non_null(fgets(line, sizeof line, f));
    assert_string_equal(line, "/home/o'hara; exit 7/$HOME/key\n");
    while (fgets(line, sizeof line, f)) continue;
    assert_int_equal(pclose(f), 0);
    assert_int_equal(remove(script), 0);
    assert_int_equal(remove(mock), 0);
    assert_int_equal(remove(dir), 0);
}

TEST(what_does_not_belong_into_a_script_is_refused)
{
    static const char *const addresses[] = {"render.example", ":8041", "unix:/run/x:1",
                                            "render.example:8041\n#SBATCH --uid=0"};
    struct fault fault = {0};
    assert_int_equal(slurm_array_check(&ordinary, &fault), 0);
    for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++) {
        struct slurm_array wrong = ordinary;
        wrong.connect = addresses[i];
        assert_int_equal(slurm_array_check(&wrong, &fault), ERR_SYNTAX);
        assert_string_equal(fault.pointer, "--connect");
    }
    struct slurm_array wrong = ordinary;
    wrong.key = "/home/ana/two\nlines";
    assert_int_equal(slurm_array_check(&wrong, &fault), ERR_SYNTAX);
    assert_string_equal(fault.pointer, "--key");
}
