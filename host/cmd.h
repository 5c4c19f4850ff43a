/* cmd.h - the program's commands, and how they speak to their user. They use only what feeler.h declares. */
#ifndef FEELER_CMD_H
#define FEELER_CMD_H

#include "feeler.h"

#include <jansson.h>
#include <stdbool.h>

enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2, EXIT_INTERRUPTED = 130 };

/* Each is given its name as argv[0] and returns the program's exit code. */
int cmd_render(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_pixel(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_chart(int argc, char **argv);
int cmd_devices(int argc, char **argv);
int cmd_doctor(int argc, char **argv);

/* ---- cmd_report.c: stderr ---- */

/* True where stderr is a terminal that moves its cursor. */
bool report_on_terminal(void);
/* "feeler: file:line:column: what", and a kernel's build log below it. Returns the exit code that fits. */
int report_error(const feeler_error *error);
void report_failure(const char *format, ...) __attribute__((format(printf, 1, 2)));
void report_warning(const char *text);
/* Warns of a file of work groups that cannot be used. */
void report_tuned(void);
/* Something the user should know that is neither a failure nor a warning. */
void report_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* A wrong call of a command (NULL: of the program itself), with a pointer to its help. */
void report_usage(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The end of a noun after a number: "" or "s". */
const char *plural(long long count);
/* Takes a text from the library and prints it as it is. Returns EXIT_DONE. */
int report_json(char *text);

/* ---- cmd_output.c: names and files ---- */

/* The scene's name: its file's, without folder and ending. To be freed; NULL: out of memory. */
char *output_scene_name(const char *scene_path);
/* `pattern` with every {name} replaced. To be freed; NULL: out of memory. */
char *output_expand(const char *pattern, const char *name);
/* "a.exr" becomes "a.partial.exr". To be freed; NULL: out of memory. */
char *output_partial(const char *path);
/* Whether a file's name has this ending, such as ".svg", in letters of either case. */
bool output_ends_in(const char *path, const char *ending);
/* Whether two names are one file's. What is not there is no file yet. */
bool output_is_file(const char *path, const char *other);
/* 0 if a text file can be made there, which must not be the scene's, else -1 and said on stderr. "-" is stdout, here and
 * below. */
int output_check_text(const char *path, const char *scene);
/* Writes a text and a final newline, under this name only when it is whole; a pipe or device is written directly.
 * 0, or -1 and said on stderr. */
int output_write_text(const char *path, const char *text);

/* ---- cmd_summary.c: what is said after a render ---- */

void summary_print(const char *scene_path, const char *out, const char *stats_json);
/* Says where a tolerance is not reached. Returns an exit code. */
int summary_judge(const char *out, const char *stats_json);

#endif
