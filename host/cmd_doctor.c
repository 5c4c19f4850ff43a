/* cmd_doctor.c - feeler doctor: is everything here that feeler needs? */
#include "cmd.h"
#include "doctor.h"
#include "options.h"

#include <stdio.h>
#include <string.h>

static const char *text_of(const json_t *check, const char *key) {
    const char *text = json_string_value(json_object_get(check, key));
    return text ? text : "";
}

static void print_check(const char *state, const char *name, const char *text, const char *mend) {
    printf("%-8s %-13s %s\n", strcmp(state, "fail") == 0 ? "FAIL" : state, name, text);
    if (*mend)
        printf("%-8s %-13s to mend: %s\n", "", "", mend);
}

/* The program and the library are two files, and may come from two installations. Returns the number of failures. */
static int check_version(void) {
    if (strcmp(feeler_version(), FEELER_VERSION) == 0) {
        print_check("ok", "version", "feeler and libfeeler are both " FEELER_VERSION, "");
        return 0;
    }
    char text[128];
    snprintf(text, sizeof text, "feeler is %s, libfeeler is %s", FEELER_VERSION, feeler_version());
    print_check("fail", "version", text, "install both from one build, or mend LD_LIBRARY_PATH");
    return 1;
}

static int print_checks(const json_t *checks) {
    size_t i;
    json_t *check;
    int failures = check_version(), warnings = 0;
    json_array_foreach(checks, i, check) {
        const char *state = text_of(check, "state");
        print_check(state, text_of(check, "name"), text_of(check, "text"), text_of(check, "mend"));
        failures += strcmp(state, "fail") == 0;
        warnings += strcmp(state, "warning") == 0;
    }
    printf("\n%s: %d failure%s, %d warning%s\n", failures ? "feeler does not work here" : "feeler works here", failures,
           failures == 1 ? "" : "s", warnings, warnings == 1 ? "" : "s");
    return failures ? EXIT_FAILED : EXIT_DONE;
}

int cmd_doctor(int argc, char **argv) {
    const char *select = NULL;
    int count;
    const option options[] = {
        {"device", 0, OPTION_TEXT, &select, "SELECT", "the first CPU", "number or part of a name, see 'feeler devices'",
         0, 0},
        {0},
    };
    const command doctor = {"doctor", "", "Checks the installation and says how to mend it.", options, 0, 0, NULL};
    options_result parsed = options_parse(&doctor, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;

    feeler_error error = {0};
    char *text = feeler_doctor_json(select, &error);
    if (!text)
        return report_error(&error);
    json_t *root = json_loads(text, 0, NULL);
    feeler_free(text);
    if (!root) {
        report_failure("out of memory");
        return EXIT_FAILED;
    }
    int code = print_checks(json_object_get(root, "checks"));
    json_decref(root);
    return code;
}
