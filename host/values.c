/* values.c - single values from nodes, and errors at a node's place. */
#include "number.h"
#include "schema.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 512 };

int fail_node(const reader *reader, const feeler_node *node, const char *format, ...) {
    char path[NODE_PATH_SIZE], message[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return fail_at(reader->error, FEELER_BAD_INPUT, node_place(node, path), "%s", message);
}

int fail_key(const reader *reader, const feeler_node *node, const char *format, ...) {
    char path[NODE_PATH_SIZE], message[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return fail_at(reader->error, FEELER_BAD_INPUT, node_key_place(node, path), "%s", message);
}

/* The child at `item`, or NULL. Only for messages: it walks. */
static const feeler_node *child_at(const feeler_node *node, size_t item) {
    const feeler_node *child = node->kind == NODE_LIST || node->kind == NODE_MAP ? node->children.first : NULL;
    while (child && item-- > 0)
        child = child->next;
    return child;
}

int fail_item(const reader *reader, const feeler_node *node, size_t item, const char *format, ...) {
    char path[NODE_PATH_SIZE], source[NODE_PATH_SIZE + 32], message[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    const feeler_node *child = child_at(node, item);
    place at = node_place(child ? node_value(child) : node, path);
    if (!child && at.line == 0) {
        snprintf(source, sizeof source, "%s[%zu]", at.source, item);
        at.source = source;
    }
    return fail_at(reader->error, FEELER_BAD_INPUT, at, "%s", message);
}

int fail_memory(const reader *reader) {
    return fail(reader->error, FEELER_OUT_OF_MEMORY, "out of memory");
}

int keep_place(const reader *reader, const feeler_node *node, place *kept) {
    char path[NODE_PATH_SIZE];
    *kept = node_key_place(node, path);
    if (kept->source == path || kept->line == 0) /* a path of keys: its own for every node */
        kept->source = scene_add_source(reader->scene, kept->source, reader->error);
    return kept->source ? 0 : -1;
}

static int fail_type(const reader *reader, const feeler_node *node, const char *wanted) {
    char text[SHOWN_SIZE];
    /* A caller's bools are texts. */
    if (node->kind == NODE_TEXT && !node->line && (!strcmp(node->text, "true") || !strcmp(node->text, "false")))
        return fail_node(reader, node, "expected %s, not %s", wanted, node->text);
    if (node->kind == NODE_TEXT && node->text[0])
        return fail_node(reader, node, "expected %s, not %s'%s'", wanted, node->quoted ? "the text " : "",
                         shown(node->text, text));
    return fail_node(reader, node, "expected %s, not %s", wanted, node_kind_name(node));
}

static int read_number_text(const reader *reader, const feeler_node *node, double *value) {
    char text[SHOWN_SIZE];
    if (node->quoted || !node->text[0])
        return fail_type(reader, node, "a number");
    switch (number_read(node->text, value)) {
    case NUMBER_OK:
        return 0;
    case NUMBER_NOT_FINITE:
        return fail_node(reader, node, "'%s' is not a finite number", shown(node->text, text));
    default:
        return fail_node(reader, node, "'%s' is not a number", shown(node->text, text));
    }
}

int read_number(const reader *reader, const feeler_node *node, double *value) {
    node = node_value(node);
    if (node->kind == NODE_TEXT)
        return read_number_text(reader, node, value);
    if (node->kind == NODE_ARRAY && node->array.rows == 1 && node->array.columns == 1)
        return read_numbers(reader, node, 1, value);
    if (node->kind != NODE_NUMBER)
        return fail_type(reader, node, "a number");
    if (!isfinite(node->number))
        return fail_node(reader, node, "the number is not finite");
    *value = node->number;
    return 0;
}

int read_integer(const reader *reader, const feeler_node *node, double low, double high, const char *name, int *value) {
    double number;
    if (read_number(reader, node, &number) != 0)
        return -1;
    if (number != floor(number))
        return fail_node(reader, node_value(node), "%s must be a whole number, not %.9g", name, number);
    if (number < low || number > high)
        return fail_node(reader, node_value(node), "%s is %.9g, but must be %.0f to %.0f", name, number, low, high);
    *value = (int)number;
    return 0;
}

int read_bool(const reader *reader, const feeler_node *node, bool *value) {
    node = node_value(node);
    /* A caller's tree has no plain texts, so that its quoted ones count. */
    bool text = node->kind == NODE_TEXT && (!node->quoted || !node->line);
    bool number = node->kind == NODE_NUMBER && (node->number == 0 || node->number == 1);
    if (number || (text && strcmp(node->text, "true") == 0) || (text && strcmp(node->text, "false") == 0)) {
        *value = number ? node->number == 1 : node->text[0] == 't';
        return 0;
    }
    return fail_type(reader, node, "true or false");
}

int read_text(const reader *reader, const feeler_node *node, const char **value) {
    node = node_value(node);
    if (node->kind != NODE_TEXT || !node->text[0])
        return fail_type(reader, node, "a text");
    *value = node->text;
    return 0;
}

int read_choice(const reader *reader, const feeler_node *node, const char *const *choices, int *value) {
    char known[128] = "", name[SHOWN_SIZE], hint[SUGGESTION_SIZE];
    const char *text = "";
    if (read_text(reader, node, &text) != 0)
        return -1;
    suggestion nearest = suggest_for(text);
    for (int i = 0; choices[i]; i++) {
        if (strcmp(text, choices[i]) == 0) {
            *value = i;
            return 0;
        }
        suggest_candidate(&nearest, choices[i]);
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", choices[i]);
    }
    return fail_node(reader, node_value(node), "'%s' is none of %s%s", shown(text, name), known,
                     suggest_text(&nearest, hint));
}

int read_numbers(const reader *reader, const feeler_node *node, size_t count, double *values) {
    node = node_value(node);
    bool array = node->kind == NODE_ARRAY && (node->array.rows == 1 || node->array.columns == 1);
    if (!array && node->kind != NODE_LIST) {
        char wanted[64];
        snprintf(wanted, sizeof wanted, "a list of %zu numbers", count);
        return fail_type(reader, node, wanted);
    }
    if (node_count(node) != count)
        return fail_node(reader, node, "expected %zu numbers, not %zu", count, node_count(node));
    if (!array) {
        for (const feeler_node *child = node->children.first; child; child = child->next)
            if (read_number(reader, child, values++) != 0)
                return -1;
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        values[i] = node->array.values[i];
        if (!isfinite(values[i]))
            return fail_item(reader, node, i, "the number is not finite");
    }
    return 0;
}

int read_vector(const reader *reader, const feeler_node *node, vec3 *value) {
    double numbers[3];
    if (read_numbers(reader, node, 3, numbers) != 0)
        return -1;
    *value = (vec3){numbers[0], numbers[1], numbers[2]};
    return 0;
}

int read_colour(const reader *reader, const feeler_node *node, vec3 *value) {
    const feeler_node *real = node_value(node);
    if (real->kind == NODE_LIST || (real->kind == NODE_ARRAY && node_count(real) != 1))
        return read_vector(reader, node, value);
    if (real->kind == NODE_MAP || (real->kind == NODE_TEXT && (real->quoted || !real->text[0])))
        return fail_type(reader, real, "a number or a list of 3 numbers");
    double grey;
    if (read_number(reader, node, &grey) != 0)
        return -1;
    *value = (vec3){grey, grey, grey};
    return 0;
}

static int read_array_vectors(const reader *reader, const feeler_node *node, vec3 *values) {
    const double *from = node->array.values;
    for (size_t i = 0; i < node->array.rows; i++, from += 3) {
        values[i] = (vec3){from[0], from[1], from[2]};
        if (!isfinite(from[0]) || !isfinite(from[1]) || !isfinite(from[2]))
            return fail_item(reader, node, i, "a number is not finite");
    }
    return 0;
}

static int read_list_vectors(const reader *reader, const feeler_node *node, vec3 *values) {
    for (const feeler_node *child = node->children.first; child; child = child->next)
        if (read_vector(reader, child, values++) != 0)
            return -1;
    return 0;
}

int read_vectors(const reader *reader, const feeler_node *node, vec3 **values, size_t *count) {
    node = node_value(node);
    bool array = node->kind == NODE_ARRAY;
    if (!array && node->kind != NODE_LIST)
        return fail_type(reader, node, "a list of lists of 3 numbers");
    if (array && node->array.columns != 3 && node->array.rows * node->array.columns > 0)
        return fail_node(reader, node, "expected rows of 3 numbers, not of %zu", node->array.columns);
    size_t length = array ? node->array.columns == 3 ? node->array.rows : 0 : node->children.count;
    if (length > SIZE_MAX / sizeof(vec3) - 1)
        return fail_memory(reader);
    vec3 *made = malloc((length + !length) * sizeof *made);
    if (!made)
        return fail_memory(reader);
    if ((array ? read_array_vectors : read_list_vectors)(reader, node, made) != 0) {
        free(made);
        return -1;
    }
    *values = made;
    *count = length;
    return 0;
}
