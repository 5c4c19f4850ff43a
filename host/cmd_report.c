/* cmd_report.c - everything that goes to stderr, and results on stdout. */
#include "cmd.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool report_on_terminal(void) {
    const char *terminal = getenv("TERM");
    return isatty(STDERR_FILENO) && terminal && *terminal && strcmp(terminal, "dumb") != 0;
}

static bool in_colour(void) {
    const char *no_colour = getenv("NO_COLOR"); /* by no-color.org an empty value does not count */
    return report_on_terminal() && !(no_colour && *no_colour);
}

static void say_prefix(const char *colour) {
    if (in_colour())
        fprintf(stderr, "\033[1;%smfeeler:\033[0m ", colour);
    else
        fputs("feeler: ", stderr);
}

static const char red[] = "31", yellow[] = "33", cyan[] = "36";

int report_error(const feeler_error *error) {
    char text[sizeof error->source + sizeof error->text + 64];
    feeler_error_format(error, text, sizeof text);
    say_prefix(red);
    fprintf(stderr, "%s\n", text);
    size_t length = strlen(error->log);
    if (length)
        fprintf(stderr, "%s%s", error->log, error->log[length - 1] == '\n' ? "" : "\n");
    if (error->code == FEELER_INTERRUPTED)
        return EXIT_INTERRUPTED;
    return error->code == FEELER_BAD_USAGE ? EXIT_USAGE : EXIT_FAILED;
}

void report_failure(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say_prefix(red);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

void report_warning(const char *text) {
    say_prefix(yellow);
    fprintf(stderr, "warning: %s\n", text);
}

void report_tuned(void) {
    feeler_error error = {0};
    char text[sizeof error.source + sizeof error.text + 64];
    if (feeler_tuned_check(&error) == 0)
        return;
    feeler_error_format(&error, text, sizeof text);
    say_prefix(yellow);
    fprintf(stderr, "warning: %s; the work groups that are kept there are not used\n", text);
}

void report_note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say_prefix(cyan);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

void report_usage(const char *command, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say_prefix(red);
    if (command)
        fprintf(stderr, "%s: ", command);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\nTry 'feeler %s%s--help'.\n", command ? command : "", command ? " " : "");
    va_end(arguments);
}

const char *plural(long long count) {
    return count == 1 ? "" : "s";
}

int report_json(char *text) {
    puts(text);
    feeler_free(text);
    return EXIT_DONE;
}
