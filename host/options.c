/* options.c - reads a command's options and writes its help, both from one table. */
#include "options.h"

#include "cmd.h"
#include "edits.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- suggestions ---- */

const char *options_nearest(const char *typed, const char *const *words) {
    const char *nearest = NULL;
    size_t smallest = SIZE_MAX, length = strlen(typed);
    for (; *words; words++) {
        bool begins = length >= 3 && strncmp(typed, *words, length) == 0;
        size_t edits = begins ? 0 : edits_between(typed, *words);
        if (edits < smallest) {
            smallest = edits;
            nearest = *words;
        }
    }
    return smallest <= (length < 4 ? 1 : length / 3) ? nearest : NULL;
}

/* ---- help ---- */

static void print_row(const option *o) {
    char left[80];
    const char *value = o->value && o->kind != OPTION_FLAG ? o->value : "";
    const char *more = o->kind == OPTION_LIST ? ",..." : "";
    if (o->letter)
        snprintf(left, sizeof left, "-%c, --%s%s%s%s", o->letter, o->name, *value ? " " : "", value, more);
    else
        snprintf(left, sizeof left, "    --%s%s%s%s", o->name, *value ? " " : "", value, more);
    /* A long left side gets a line of its own. */
    if (strlen(left) > 24)
        printf("  %s\n  %-24s  %s", left, "", o->text);
    else
        printf("  %-24s  %s", left, o->text);
    if (o->fallback)
        printf(" (default: %s)", o->fallback);
    printf("\n");
}

static const option help_row = {"help", 'h', OPTION_HELP, NULL, NULL, NULL, "show this text", 0, 0};

static void print_help(const command *c) {
    printf("Usage: feeler %s %s%s[OPTION…]\n\n%s\n\nOptions:\n", c->name, c->operands, *c->operands ? " " : "",
           c->summary);
    for (const option *o = c->options; o->name; o++)
        print_row(o);
    print_row(&help_row);
    if (c->notes)
        printf("\n%s\n", c->notes);
}

/* ---- values ---- */

/* Reads one number at *text and moves it behind; plain decimal notation only, so no hexadecimal, infinity or nan. */
static bool read_number(const char **text, double *value) {
    static const char allowed[] = "0123456789+-.eE";
    char copy[64], *end;
    size_t length = strspn(*text, allowed);
    if (length == 0 || length >= sizeof copy)
        return false;
    memcpy(copy, *text, length);
    copy[length] = '\0';
    *value = strtod(copy, &end);
    *text += length;
    return *end == '\0' && end != copy && isfinite(*value);
}

static bool read_whole(const char **text, double low, double high, int *value) {
    size_t sign = **text == '-' || **text == '+';
    size_t length = sign + strspn(*text + sign, "0123456789");
    if (length == sign)
        return false;
    errno = 0;
    long number = strtol(*text, NULL, 10);
    *text += length;
    if (errno || number < INT_MIN || number > INT_MAX || (double)number < low || (double)number > high)
        return false;
    *value = (int)number;
    return true;
}

static bool read_size(const char *text, const option *o) {
    int size[2];
    if (!read_whole(&text, o->low, o->high, &size[0]))
        return false;
    if (*text != 'x' && *text != 'X')
        return false;
    text++;
    if (!read_whole(&text, o->low, o->high, &size[1]) || *text)
        return false;
    memcpy(o->target, size, sizeof size);
    return true;
}

static bool read_region(const char *text, const option *o) {
    int region[4];
    for (int i = 0; i < 4; i++) {
        if (i > 0 && *text++ != ',')
            return false;
        if (!read_whole(&text, 0, INT_MAX, &region[i]))
            return false;
    }
    if (*text || region[0] >= region[2] || region[1] >= region[3])
        return false;
    memcpy(o->target, region, sizeof region);
    return true;
}

static bool read_choice(const char *text, const option *o) {
    const char *word = o->value;
    for (int i = 0; *word; i++) {
        size_t length = strcspn(word, "|");
        if (strlen(text) == length && strncmp(text, word, length) == 0) {
            *(int *)o->target = i;
            return true;
        }
        word += length + (word[length] == '|');
    }
    return false;
}

static bool read_value(const char *text, const option *o);

void options_list_free(option_list *list) {
    free(list->numbers);
    free(list->texts);
    free(list->copy);
}

static bool read_list(const char *text, const option *o) {
    option_list *list = o->target, read = {.kind = list->kind, .copy = strdup(text)};
    size_t most = strlen(text) + 1; /* values, with room to spare */
    read.numbers = malloc(2 * most * sizeof *read.numbers);
    read.texts = malloc(most * sizeof *read.texts);
    bool good = read.copy && read.numbers && read.texts;
    for (char *at = read.copy, *next; good && at; at = next, read.count++) {
        next = strchr(at, ',');
        if (next)
            *next++ = '\0';
        option one = *o;
        one.kind = list->kind;
        one.target = &read.numbers[read.count * (list->kind == OPTION_SIZE ? 2 : 1)];
        if (list->kind == OPTION_TEXT)
            one.target = &read.texts[read.count];
        good = read_value(at, &one);
    }
    options_list_free(good ? list : &read);
    if (good)
        *list = read;
    return good;
}

static bool read_value(const char *text, const option *o) {
    double number;
    int whole;
    switch (o->kind) {
    case OPTION_WHOLE:
        if (!read_whole(&text, o->low, o->high, &whole) || *text)
            return false;
        *(int *)o->target = whole;
        return true;
    case OPTION_NUMBER:
        if (!read_number(&text, &number) || *text || number < o->low || number > o->high)
            return false;
        *(double *)o->target = number;
        return true;
    case OPTION_TEXT:
        *(const char **)o->target = text;
        return *text != '\0';
    case OPTION_SIZE:
        return read_size(text, o);
    case OPTION_REGION:
        return read_region(text, o);
    case OPTION_CHOICE:
        return read_choice(text, o);
    case OPTION_LIST:
        return read_list(text, o);
    case OPTION_FLAG:
    case OPTION_HELP:
        break;
    }
    return false;
}

static void say_bad_value(const command *c, const option *o, const char *text) {
    char range[80] = "";
    const bool list = o->kind == OPTION_LIST;
    const option_kind kind = list ? ((const option_list *)o->target)->kind : o->kind;
    if (kind == OPTION_WHOLE || kind == OPTION_SIZE) {
        const char *what = kind == OPTION_SIZE ? ", whole numbers" : "a whole number";
        if (o->high < INT_MAX)
            snprintf(range, sizeof range, "%s from %g to %g", what, o->low, o->high);
        else
            snprintf(range, sizeof range, "%s from %g", what, o->low);
    } else if (kind == OPTION_NUMBER) {
        snprintf(range, sizeof range, "a number from %g to %g", o->low, o->high);
    } else if (kind == OPTION_REGION) {
        snprintf(range, sizeof range, ", whole pixels, X0 < X1 and Y0 < Y1");
    }
    bool form = kind == OPTION_SIZE || kind == OPTION_REGION || kind == OPTION_CHOICE || kind == OPTION_TEXT;
    report_usage(c->name, "--%s: '%s' is wrong; it takes %s%s%s", o->name, text, form ? o->value : "", range,
                 list ? "; several have commas between them" : "");
}

/* ---- parsing ---- */

static const option *find_long(const command *c, const char *name, size_t length) {
    for (const option *o = c->options; o->name; o++)
        if (strlen(o->name) == length && strncmp(o->name, name, length) == 0)
            return o;
    return length == 4 && strncmp(name, "help", 4) == 0 ? &help_row : NULL;
}

static const option *find_short(const command *c, char letter) {
    for (const option *o = c->options; o->name; o++)
        if (o->letter == letter)
            return o;
    return letter == 'h' ? &help_row : NULL;
}

static void say_unknown(const command *c, const char *typed, size_t length) {
    const char *names[64] = {0};
    char name[LONGEST_WORD + 1] = "";
    size_t count = 0;
    for (const option *o = c->options; o->name && count < 62; o++)
        names[count++] = o->name;
    names[count] = "help";
    if (length <= LONGEST_WORD)
        memcpy(name, typed, length);
    const char *nearest = *name ? options_nearest(name, names) : NULL;
    if (nearest)
        report_usage(c->name, "unknown option '--%.*s' (did you mean '--%s'?)", (int)length, typed, nearest);
    else
        report_usage(c->name, "unknown option '--%.*s'", (int)length, typed);
}

/* Applies one option; `value` is what is joined to it, else NULL. Moves *index past a value of its own. */
static options_result apply(const command *c, const option *o, const char *value, int argc, char **argv, int *index) {
    if (o->kind == OPTION_HELP || o->kind == OPTION_FLAG) {
        if (value) {
            report_usage(c->name, "--%s takes no value", o->name);
            return OPTIONS_WRONG;
        }
        if (o->kind == OPTION_FLAG) {
            *(bool *)o->target = true;
            return OPTIONS_GO;
        }
        print_help(c);
        return OPTIONS_HELPED;
    }
    if (!value && *index + 1 < argc)
        value = argv[++*index];
    if (!value) {
        report_usage(c->name, "--%s needs a value: %s", o->name, o->value);
        return OPTIONS_WRONG;
    }
    if (read_value(value, o))
        return OPTIONS_GO;
    say_bad_value(c, o, value);
    return OPTIONS_WRONG;
}

static options_result parse_one(const command *c, int argc, char **argv, int *index) {
    const char *word = argv[*index];
    if (word[1] == '-') {
        const char *name = word + 2;
        size_t length = strcspn(name, "=");
        const option *o = find_long(c, name, length);
        if (o)
            return apply(c, o, name[length] ? name + length + 1 : NULL, argc, argv, index);
        say_unknown(c, name, length);
        return OPTIONS_WRONG;
    }
    const option *o = find_short(c, word[1]);
    if (o)
        return apply(c, o, word[2] ? word + 2 + (word[2] == '=') : NULL, argc, argv, index);
    report_usage(c->name, "unknown option '%s'", word);
    return OPTIONS_WRONG;
}

/* What begins with "-" is none, but for "-" alone and, where each operand has its place, for numbers. */
static bool is_operand(const command *c, const char *word) {
    return word[0] != '-' || word[1] == '\0' || (c->least == c->most && isdigit((unsigned char)word[1]));
}

options_result options_parse(const command *c, int argc, char **argv, int *operand_count) {
    int count = 0;
    bool only_operands = false;
    for (int i = 1; i < argc; i++) {
        if (only_operands || is_operand(c, argv[i])) {
            argv[count++] = argv[i]; /* count < i: overwrites only what is read */
        } else if (strcmp(argv[i], "--") == 0) {
            only_operands = true;
        } else {
            options_result result = parse_one(c, argc, argv, &i);
            if (result != OPTIONS_GO)
                return result;
        }
    }
    *operand_count = count;
    if (count < c->least) {
        report_usage(c->name, "%s is missing", c->operands);
        return OPTIONS_WRONG;
    }
    if (count > c->most) {
        report_usage(c->name, c->most == 0 ? "'%s' is too much: it takes only options" : "'%s' is too much",
                     argv[c->most]);
        return OPTIONS_WRONG;
    }
    return OPTIONS_GO;
}
