/* options.h - one table per command drives both the parsing and the help. */
#ifndef FEELER_OPTIONS_H
#define FEELER_OPTIONS_H

#include <stdbool.h>

typedef enum option_kind {
    OPTION_FLAG,   /* bool *target */
    OPTION_WHOLE,  /* int *target, within low … high */
    OPTION_NUMBER, /* double *target, within low … high; finite */
    OPTION_TEXT,   /* const char **target, not empty */
    OPTION_SIZE,   /* int target[2] as AxB, each within low … high */
    OPTION_REGION, /* int target[4] as X0,Y0,X1,Y1, not empty */
    OPTION_CHOICE, /* int *target, the place of the word in `value`, which is "first|second|third" */
    OPTION_LIST,   /* option_list *target, replaced by values with commas between them */
    OPTION_HELP    /* prints the help */
} option_kind;

/* Values of one kind; zero-initialise but for the kind. */
typedef struct option_list {
    option_kind kind; /* of each: WHOLE, SIZE, CHOICE or TEXT */
    int count;
    int *numbers;       /* one for each value, two for a size; owned, freed by options_list_free */
    const char **texts; /* instead of numbers, for TEXT; into `copy` */
    char *copy;
} option_list;

/* One row: everything that parsing and help know of an option. */
typedef struct option {
    const char *name; /* without the dashes */
    char letter;      /* the short form, 0: none */
    option_kind kind;
    void *target;         /* left alone unless the option is given */
    const char *value;    /* how the help writes its value */
    const char *fallback; /* the default as the help writes it; NULL: not worth telling */
    const char *text;
    double low, high;
} option;

typedef struct command {
    const char *name;
    const char *operands; /* as the help writes them */
    const char *summary;
    const option *options; /* ends with a row without name */
    int least, most;       /* number of operands */
    const char *notes;     /* paragraphs below the options; NULL: none */
} command;

typedef enum options_result { OPTIONS_GO, OPTIONS_HELPED, OPTIONS_WRONG } options_result;

/* Reads argv[1 …] of a command. Operands are moved to argv[0 …] and counted. What is wrong is said on stderr, help on
 * stdout. */
options_result options_parse(const command *command, int argc, char **argv, int *operand_count);

void options_list_free(option_list *list);

/* The word of `words` (ends with NULL) that is nearest to `typed`, or NULL where none is near. */
const char *options_nearest(const char *typed, const char *const *words);

#endif
