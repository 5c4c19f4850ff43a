/* main.c - the program: finds the command and runs it. */
#include "cmd.h"
#include "options.h"

#include <stdio.h>
#include <string.h>

typedef struct verb {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *text;
} verb;

static const verb verbs[] = {
    {"render", cmd_render, "render scenes to pictures"},
    {"info", cmd_info, "show what a scene contains and needs"},
    {"pixel", cmd_pixel, "tell why a pixel has its colour"},
    {"compare", cmd_compare, "measure how far two pictures are apart"},
    {"bench", cmd_bench, "measure how fast work groups are"},
    {"chart", cmd_chart, "chart speed against accuracy"},
    {"devices", cmd_devices, "list OpenCL platforms and devices"},
    {"doctor", cmd_doctor, "check the installation and say how to mend it"},
};

enum { VERB_COUNT = sizeof verbs / sizeof *verbs };

static void print_help(void) {
    puts("Usage: feeler COMMAND [ARGUMENT…]\n\nA Whitted ray tracer on OpenCL.\n\nCommands:");
    for (size_t i = 0; i < VERB_COUNT; i++)
        printf("  %-10s %s\n", verbs[i].name, verbs[i].text);
    puts("\n  feeler COMMAND --help  shows a command's options\n  feeler --version       shows the version\n\n"
         "Example: feeler render scenes/first.yaml -o first.png");
}

static int run(int argc, char **argv) {
    const char *names[VERB_COUNT + 1] = {0};
    if (argc < 2) {
        report_usage(NULL, "a command is missing");
        return EXIT_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0) {
        print_help();
        return EXIT_DONE;
    }
    if (strcmp(word, "--version") == 0) {
        printf("feeler %s\n", feeler_version());
        return EXIT_DONE;
    }
    for (size_t i = 0; i < VERB_COUNT; i++) {
        names[i] = verbs[i].name;
        if (strcmp(word, verbs[i].name) == 0)
            return verbs[i].run(argc - 1, argv + 1);
    }
    const char *nearest = options_nearest(word, names);
    if (nearest)
        report_usage(NULL, "unknown command '%s' (did you mean '%s'?)", word, nearest);
    else
        report_usage(NULL, "unknown command '%s'", word);
    return EXIT_USAGE;
}

int main(int argc, char **argv) {
    int code = run(argc, argv);
    /* A full disk shows itself only here. */
    if ((fflush(stdout) || ferror(stdout)) && code == EXIT_DONE) {
        report_failure("cannot write to standard output");
        code = EXIT_FAILED;
    }
    return code;
}
