/* cmd_chart.c - feeler chart: reads the options and hands over to the Python package, which measures and draws. */
#include "cmd.h"
#include "options.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct request {
    const char *out, *device;
    int size[2], repeat, truth_samples; /* 0: not given */
    bool specialised, quick, quiet;
} request;

static const char chart_notes[] =
    "A chart shows what error each setting leaves for the time it takes: level with samples, depth, cutoff, and other\n"
    "methods, one at a time around the scene's own settings. Errors are against level 'reference' with many samples.\n"
    "Each scene gets a PNG, an SVG, and its data as JSON and CSV. OUT is a folder, or a name in which {name} stands\n"
    "for the scene's. All settings are rendered in turn, round after round, so that what else the machine does meets\n"
    "all alike. The Python package feeler does it, with matplotlib, run by the Python that FEELER_PYTHON names, else\n"
    "by the checkout's .venv, else by python3.";

static options_result parse(request *r, int argc, char **argv, int *count) {
    const option options[] = {
        {"out", 'o', OPTION_TEXT, &r->out, "OUT", "accuracy-{name}", "where the charts go", 0, 0},
        {"size", 's', OPTION_SIZE, r->size, "WxH", "128x96", "pixels", 1, 4096},
        {"repeat", 0, OPTION_WHOLE, &r->repeat, "N", "5", "rounds", 1, 10000},
        {"truth-samples", 0, OPTION_WHOLE, &r->truth_samples, "N", "256", "of what errors are measured against", 2,
         4096},
        {"quick", 0, OPTION_FLAG, &r->quick, NULL, NULL, "64x48, 3 rounds, at most 16 samples, 64 for the truth", 0, 0},
        {"specialised", 0, OPTION_FLAG, &r->specialised, NULL, NULL,
         "chart instead, for all scenes together, what compiling no more than they need saves", 0, 0},
        {"device", 0, OPTION_TEXT, &r->device, "SELECT", "the first CPU",
         "a number or a part of a name, see 'feeler devices'", 0, 0},
        {"quiet", 'q', OPTION_FLAG, &r->quiet, NULL, NULL, "no progress and no tables", 0, 0},
        {0},
    };
    const command chart = {"chart", "SCENE…", "Charts speed against accuracy.", options, 1, INT_MAX, chart_notes};
    return options_parse(&chart, argc, argv, count);
}

static int set(json_t *json, const char *key, json_t *value) {
    return json_object_set_new(json, key, value);
}

/* The request that feeler/_chart.py reads. To be freed; NULL: out of memory, or a name that is no UTF-8. */
static char *make_request(const request *r, int count, char **scenes) {
    json_t *json = json_object(), *names = json_array();
    int failed = 0;
    for (int i = 0; i < count; i++)
        failed |= json_array_append_new(names, json_string(scenes[i]));
    failed |= set(json, "scenes", names) | set(json, "specialised", json_boolean(r->specialised)) |
              set(json, "quick", json_boolean(r->quick)) | set(json, "quiet", json_boolean(r->quiet));
    if (r->out)
        failed |= set(json, "out", json_string(r->out));
    if (r->device)
        failed |= set(json, "device", json_string(r->device));
    if (r->size[0])
        failed |= set(json, "size", json_pack("[i, i]", r->size[0], r->size[1]));
    if (r->repeat)
        failed |= set(json, "repeat", json_integer(r->repeat));
    if (r->truth_samples)
        failed |= set(json, "truth_samples", json_integer(r->truth_samples));
    char *text = failed ? NULL : json_dumps(json, JSON_COMPACT);
    json_decref(json);
    return text;
}

/* The Python to run: $FEELER_PYTHON, or that of the checkout in whose build folder this program is, or python3. */
static char *find_python(char *buffer, size_t size) {
    static const char venv[] = "/../.venv/bin/python";
    static char python3[] = "python3";
    char *chosen = getenv("FEELER_PYTHON");
    if (chosen && *chosen)
        return chosen;
    ssize_t length = readlink("/proc/self/exe", buffer, size - 1);
    if (length < 0 || (size_t)length == size - 1)
        return python3;
    buffer[length] = '\0';
    char *slash = strrchr(buffer, '/');
    if (!slash || (size_t)(slash - buffer) + sizeof venv > size)
        return python3;
    memcpy(slash, venv, sizeof venv);
    return access(buffer, X_OK) ? python3 : buffer;
}

/* What is in the working folder does not stand in for Python's modules. */
static char script[] = "import sys\n"
                       "sys.path = [folder for folder in sys.path if folder]\n"
                       "try:\n"
                       "    from feeler._chart import main\n"
                       "except KeyboardInterrupt:\n"
                       "    sys.exit(130)\n"
                       "except ImportError as error:\n"
                       "    sys.exit(f'feeler: chart: {sys.executable} cannot load the Python package feeler with its "
                       "charts ({error}); FEELER_PYTHON can name another Python')\n"
                       "sys.exit(main(sys.argv[1]))\n";

int cmd_chart(int argc, char **argv) {
    request r = {0};
    int count = 0;
    options_result parsed = parse(&r, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;
    char *text = make_request(&r, count, argv);
    if (!text) {
        report_failure("chart: out of memory, or a name that is no UTF-8");
        return EXIT_FAILED;
    }
    char path[PATH_MAX], flag[] = "-c";
    char *python = find_python(path, sizeof path);
    char *const arguments[] = {python, flag, script, text, NULL};
    execvp(python, arguments);
    report_failure("chart: cannot run '%s': %s; FEELER_PYTHON can name another Python", python, strerror(errno));
    free(text);
    return EXIT_FAILED;
}
