/* yaml_lines.c - see yaml_lines.h. The grammar is a part of YAML on which there are no two opinions:
 *
 *   line   = spaces "- " (flow | word ": " flow)
 *   flow   = "{" word ": " value {"," value} "}" | "[" value {"," value} "]", spaces allowed around , and inside brackets
 *   value  = flow | word
 *   word   = letters, digits, and _ . + -, beginning so that it cannot be anything else
 */
#include "yaml_lines.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHORTEST_RUN = 64, LONGEST_LINE = 500, DEEPEST = 8 };

typedef struct cursor {
    const char *at, *start; /* of the line */
    uint32_t line;
    node_pool *pool;
    size_t weight; /* nodes made */
} cursor;

static bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

static void skip_spaces(cursor *c) {
    while (*c->at == ' ')
        c->at++;
}

/* The length of the word here, 0 where there is none. */
static size_t word_length(const char *at) {
    const char *end = at;
    if (!is_letter(*at) && !is_digit(*at) && !((*at == '-' || *at == '.') && is_digit(at[1])))
        return 0;
    while (is_letter(*end) || is_digit(*end) || *end == '.' || *end == '+' || *end == '-')
        end++;
    return (size_t)(end - at);
}

static feeler_node *new_node(cursor *c, node_kind kind) {
    feeler_node *node = node_pool_new(c->pool, kind);
    if (node) {
        node->line = c->line;
        node->column = (uint32_t)(c->at - c->start) + 1;
        c->weight++;
    }
    return node;
}

static feeler_node *read_flow(cursor *c, int depth);

static feeler_node *read_value(cursor *c, int depth) {
    if (*c->at == '{' || *c->at == '[')
        return depth < DEEPEST ? read_flow(c, depth + 1) : NULL;
    size_t length = word_length(c->at);
    feeler_node *node = length ? new_node(c, NODE_TEXT) : NULL;
    if (!node || !(node->text = node_pool_text(c->pool, c->at, length)))
        return NULL;
    c->at += length;
    return node;
}

/* A key, its value, and both into the map. */
static bool read_pair(cursor *c, feeler_node *map, int depth) {
    size_t length = word_length(c->at);
    uint32_t column = (uint32_t)(c->at - c->start) + 1;
    const char *key = c->at;
    if (!length || key[length] != ':' || key[length + 1] != ' ')
        return false;
    c->at += length + 1;
    skip_spaces(c);
    feeler_node *value = read_value(c, depth);
    if (!value || !(value->key = node_pool_key(c->pool, key, length)))
        return false;
    value->key_line = c->line;
    value->key_column = column;
    node_append(map, value);
    return true;
}

static bool read_item(cursor *c, feeler_node *parent, int depth) {
    if (parent->kind == NODE_MAP)
        return read_pair(c, parent, depth);
    feeler_node *item = read_value(c, depth);
    if (item)
        node_append(parent, item);
    return item != NULL;
}

static feeler_node *read_flow(cursor *c, int depth) {
    bool map = *c->at == '{';
    feeler_node *node = new_node(c, map ? NODE_MAP : NODE_LIST);
    if (!node)
        return NULL;
    do {
        c->at++;
        skip_spaces(c);
        if (!read_item(c, node, depth))
            return NULL;
        skip_spaces(c);
    } while (*c->at == ',');
    return *c->at++ == (map ? '}' : ']') ? node : NULL;
}

/* The item of a line whose "- " the cursor is behind; NULL where it is not plain enough. */
static feeler_node *read_line(cursor *c) {
    feeler_node *node = NULL;
    if (*c->at == '{' || *c->at == '[') {
        node = read_flow(c, 0);
    } else {
        node = new_node(c, NODE_MAP);
        size_t length = word_length(c->at);
        const char *value = c->at + length;
        while (*value == ':' || *value == ' ')
            value++;
        if (!node || (*value != '{' && *value != '[') || !read_pair(c, node, 0))
            return NULL;
    }
    return *c->at == '\n' ? node : NULL;
}

/* Spaces before "- " at the line's start, or -1 where it does not begin so. */
static int indent_of(const char *line) {
    const char *at = line;
    while (*at == ' ')
        at++;
    return at[0] == '-' && at[1] == ' ' && at - line < 64 ? (int)(at - line) : -1;
}

/* Lines that follow each other with the same indent, each wholly read. */
typedef struct stretch {
    const char *end; /* the line after them */
    uint32_t count;
    size_t weight;
    feeler_node *first;
} stretch;

/* Reads lines from `line` on while they are plain. The last line of a list may go on in the next ones, so that it is left
 * to libyaml. */
static stretch read_stretch(const char *line, const char *end, uint32_t number, node_pool *pool) {
    stretch s = {line, 0, 0, NULL};
    feeler_node *last = NULL;
    int indent = indent_of(line);
    for (;;) {
        const char *stop = memchr(s.end, '\n', (size_t)(end - s.end));
        if (indent < 0 || !stop || stop - s.end > LONGEST_LINE || indent_of(stop + 1) != indent)
            return s;
        cursor c = {.at = s.end + indent + 2, .start = s.end, .line = number + s.count, .pool = pool};
        skip_spaces(&c);
        feeler_node *node = read_line(&c);
        if (!node || c.at != stop)
            return s;
        if (last)
            last->next = node;
        else
            s.first = node;
        last = node;
        s.end = stop + 1;
        s.count++;
        s.weight += c.weight;
    }
}

static bool add_run(yaml_lines *lines, const stretch *s) {
    if (lines->count == lines->capacity) {
        size_t wanted = lines->capacity ? lines->capacity * 2 : 8;
        yaml_run *moved = realloc(lines->runs, wanted * sizeof *moved);
        if (!moved)
            return false;
        lines->runs = moved;
        lines->capacity = wanted;
    }
    lines->runs[lines->count++] = (yaml_run){s->first, s->weight};
    return true;
}

/* Copies the text, but runs. */
static void copy_without_runs(const char *text, size_t size, node_pool *pool, yaml_lines *lines) {
    const char *end = text + size;
    char *to = lines->text;
    uint32_t number = 1;
    for (const char *line = text; line < end;) {
        stretch s = read_stretch(line, end, number, pool);
        if (s.count >= SHORTEST_RUN && add_run(lines, &s)) {
            to += sprintf(to, "%*s- *" YAML_LINES_ALIAS "%zu", indent_of(line), "", lines->count - 1);
            memset(to, '\n', s.count);
            to += s.count;
        } else {
            if (s.count == 0) { /* this one line, then */
                const char *stop = memchr(line, '\n', (size_t)(end - line));
                s.end = stop ? stop + 1 : end;
                s.count = 1;
            }
            memcpy(to, line, (size_t)(s.end - line));
            to += s.end - line;
        }
        line = s.end;
        number += s.count;
    }
    lines->size = (size_t)(to - lines->text);
}

bool yaml_lines_read(const char *text, size_t size, node_pool *pool, yaml_lines *lines) {
    *lines = (yaml_lines){NULL, 0, NULL, 0, 0};
    if (size < 4096 || strstr(text, YAML_LINES_ALIAS))
        return false;
    lines->text = malloc(size + 1); /* an alias is shorter than the lines that it stands for */
    if (!lines->text)
        return false;
    copy_without_runs(text, size, pool, lines);
    if (lines->count > 0)
        return true;
    yaml_lines_free(lines);
    return false;
}

yaml_run yaml_lines_take(yaml_lines *lines, const char *alias) {
    size_t prefix = strlen(YAML_LINES_ALIAS), number = lines->count;
    if (strncmp(alias, YAML_LINES_ALIAS, prefix) == 0)
        number = strtoul(alias + prefix, NULL, 10);
    if (number >= lines->count)
        return (yaml_run){NULL, 0};
    yaml_run run = lines->runs[number];
    lines->runs[number].first = NULL;
    return run;
}

bool yaml_lines_done(const yaml_lines *lines) {
    for (size_t i = 0; i < lines->count; i++)
        if (lines->runs[i].first)
            return false;
    return true;
}

void yaml_lines_free(yaml_lines *lines) {
    free(lines->text);
    free(lines->runs);
    *lines = (yaml_lines){NULL, 0, NULL, 0, 0};
}
