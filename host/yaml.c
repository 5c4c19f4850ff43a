/* yaml.c - libyaml's events into nodes that keep their line and column. */
#include "yaml_lines.h"
#include "yaml_nodes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

enum {
    MAX_DEPTH = 64, /* a scene needs 7 */
    MAX_ANCHORS = 1000,
    MAX_EXPANSION =
        10000000 /* nodes that aliases may stand for in all, so that a short file cannot mean a huge scene */
};

typedef struct anchor {
    struct anchor *older;
    const char *name;
    feeler_node *node;
    size_t weight; /* nodes that it stands for */
} anchor;

/* A map or list that is not closed yet. */
typedef struct level {
    feeler_node *node;
    const char *key; /* of a map: read, its value still to come */
    uint32_t key_line, key_column;
    const char *anchor;
    size_t weight_before;
} level;

typedef struct builder {
    node_pool *pool;
    const char *source;
    feeler_error *error;
    feeler_node *root;
    level levels[MAX_DEPTH];
    int depth;
    anchor *anchors;
    int anchor_count;
    size_t weight;     /* nodes so far, aliases counted as what they stand for */
    size_t expanded;   /* of those, by aliases */
    yaml_lines *lines; /* what was read without libyaml, or NULL */
} builder;

static place mark_place(const builder *b, yaml_mark_t mark) {
    return (place){b->source, (int)mark.line + 1, (int)mark.column + 1};
}

static int out_of_memory(const builder *b) {
    return fail(b->error, FEELER_OUT_OF_MEMORY, "out of memory");
}

static int remember_anchor(builder *b, const char *name, feeler_node *node, size_t weight) {
    if (++b->anchor_count > MAX_ANCHORS)
        return fail_at(b->error, FEELER_BAD_INPUT, (place){b->source, (int)node->line, (int)node->column},
                       "more than %d anchors", MAX_ANCHORS);
    anchor *made = malloc(sizeof *made);
    if (!made)
        return out_of_memory(b);
    *made = (anchor){b->anchors, name, node, weight};
    b->anchors = made;
    return 0;
}

static void free_anchors(builder *b) {
    while (b->anchors) {
        anchor *older = b->anchors->older;
        free(b->anchors);
        b->anchors = older;
    }
}

/* Puts a finished or just opened value where it belongs: the root, a list's end, or under the waiting key. */
static void place_node(builder *b, feeler_node *node) {
    if (b->depth == 0) {
        node->source = b->source;
        b->root = node;
        return;
    }
    level *top = &b->levels[b->depth - 1];
    node->key = top->key;
    node->key_line = top->key_line;
    node->key_column = top->key_column;
    top->key = NULL;
    node_append(top->node, node);
}

static feeler_node *new_node(builder *b, node_kind kind, yaml_mark_t mark) {
    feeler_node *node = node_pool_new(b->pool, kind);
    if (!node) {
        out_of_memory(b);
        return NULL;
    }
    node->line = (uint32_t)mark.line + 1;
    node->column = (uint32_t)mark.column + 1;
    b->weight++;
    return node;
}

static bool awaits_key(const builder *b) {
    return b->depth > 0 && b->levels[b->depth - 1].node->kind == NODE_MAP && !b->levels[b->depth - 1].key;
}

static int check_tag(const builder *b, const yaml_char_t *tag, yaml_mark_t mark) {
    return tag ? fail_at(b->error, FEELER_BAD_INPUT, mark_place(b, mark), "tags such as '%.60s' are not supported",
                         (const char *)tag)
               : 0;
}

static int take_key(builder *b, const yaml_event_t *event) {
    const char *text = (const char *)event->data.scalar.value;
    level *top = &b->levels[b->depth - 1];
    top->key = node_pool_key(b->pool, text, strlen(text));
    top->key_line = (uint32_t)event->start_mark.line + 1;
    top->key_column = (uint32_t)event->start_mark.column + 1;
    return top->key ? 0 : out_of_memory(b);
}

static int take_scalar(builder *b, const yaml_event_t *event) {
    const char *text = (const char *)event->data.scalar.value;
    size_t length = event->data.scalar.length;
    if (check_tag(b, event->data.scalar.tag, event->start_mark) != 0)
        return -1;
    if (strlen(text) != length)
        return fail_at(b->error, FEELER_BAD_INPUT, mark_place(b, event->start_mark), "a text holds a zero byte");
    if (awaits_key(b))
        return take_key(b, event);
    feeler_node *node = new_node(b, NODE_TEXT, event->start_mark);
    if (!node)
        return -1;
    node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text = node_pool_text(b->pool, text, length);
    if (!node->text)
        return out_of_memory(b);
    place_node(b, node);
    const char *name = (const char *)event->data.scalar.anchor;
    if (!name)
        return 0;
    const char *copy = node_pool_text(b->pool, name, strlen(name));
    return copy ? remember_anchor(b, copy, node, 1) : out_of_memory(b);
}

static int open_level(builder *b, const yaml_event_t *event, node_kind kind) {
    bool map = kind == NODE_MAP;
    const yaml_char_t *tag = map ? event->data.mapping_start.tag : event->data.sequence_start.tag;
    const char *name = (const char *)(map ? event->data.mapping_start.anchor : event->data.sequence_start.anchor);
    if (check_tag(b, tag, event->start_mark) != 0)
        return -1;
    if (awaits_key(b))
        return fail_at(b->error, FEELER_BAD_INPUT, mark_place(b, event->start_mark), "a key must be a text");
    if (b->depth == MAX_DEPTH)
        return fail_at(b->error, FEELER_BAD_INPUT, mark_place(b, event->start_mark), "nested deeper than %d levels",
                       MAX_DEPTH);
    size_t weight_before = b->weight;
    feeler_node *node = new_node(b, kind, event->start_mark);
    if (!node)
        return -1;
    const char *copy = name ? node_pool_text(b->pool, name, strlen(name)) : NULL;
    if (name && !copy)
        return out_of_memory(b);
    place_node(b, node);
    b->levels[b->depth++] = (level){.node = node, .anchor = copy, .weight_before = weight_before};
    return 0;
}

/* An anchor counts from here on, so that nothing can contain itself. */
static int close_level(builder *b) {
    level *top = &b->levels[--b->depth];
    return top->anchor ? remember_anchor(b, top->anchor, top->node, b->weight - top->weight_before) : 0;
}

/* Puts the items of lines that yaml_lines_read has read where their alias is: only a list has such items. */
static int take_run(builder *b, const yaml_run *run) {
    if (b->depth == 0 || b->levels[b->depth - 1].node->kind != NODE_LIST)
        return -1;
    for (feeler_node *node = run->first, *next; node; node = next) {
        next = node->next;
        node->next = NULL;
        place_node(b, node);
    }
    b->weight += run->weight;
    return 0;
}

static int take_alias(builder *b, const yaml_event_t *event) {
    const char *name = (const char *)event->data.alias.anchor;
    yaml_run run = b->lines ? yaml_lines_take(b->lines, name) : (yaml_run){NULL, 0};
    if (run.first)
        return take_run(b, &run);
    place here = mark_place(b, event->start_mark);
    if (awaits_key(b))
        return fail_at(b->error, FEELER_BAD_INPUT, here, "a key must be a text");
    const anchor *found = b->anchors;
    while (found && strcmp(found->name, name) != 0)
        found = found->older;
    if (!found)
        return fail_at(b->error, FEELER_BAD_INPUT, here, "unknown alias '*%.60s': no anchor '&%.60s' ends before it",
                       name, name);
    b->weight += found->weight;
    b->expanded += found->weight;
    if (b->expanded > MAX_EXPANSION)
        return fail_at(b->error, FEELER_BAD_INPUT, here, "the aliases stand for more than %d values", MAX_EXPANSION);
    feeler_node *node = new_node(b, NODE_ALIAS, event->start_mark);
    if (!node)
        return -1;
    node->target = found->node;
    place_node(b, node);
    return 0;
}

static int take_event(builder *b, const yaml_event_t *event) {
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        return b->root ? fail_at(b->error, FEELER_BAD_INPUT, mark_place(b, event->start_mark),
                                 "a second document begins; a scene is one")
                       : 0;
    case YAML_SCALAR_EVENT:
        return take_scalar(b, event);
    case YAML_MAPPING_START_EVENT:
        return open_level(b, event, NODE_MAP);
    case YAML_SEQUENCE_START_EVENT:
        return open_level(b, event, NODE_LIST);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        return close_level(b);
    case YAML_ALIAS_EVENT:
        return take_alias(b, event);
    default:
        return 0;
    }
}

/* The place of a byte; columns count characters. */
static place byte_place(const char *source, const char *text, size_t offset) {
    place at = {source, 1, 1};
    for (size_t i = 0; i < offset; i++) {
        if (text[i] == '\n') {
            at.line++;
            at.column = 1;
        } else if (((unsigned char)text[i] & 0xC0) != 0x80) {
            at.column++;
        }
    }
    return at;
}

static int parser_error(const builder *b, const yaml_parser_t *parser, const char *text, size_t size) {
    const char *problem = parser->problem ? parser->problem : "unreadable";
    if (parser->error == YAML_MEMORY_ERROR)
        return out_of_memory(b);
    if (parser->error == YAML_READER_ERROR) {
        size_t offset = parser->problem_offset < size ? parser->problem_offset : size;
        return fail_at(b->error, FEELER_BAD_INPUT, byte_place(b->source, text, offset), "not UTF-8 text: %s", problem);
    }
    place at = mark_place(b, parser->problem_mark), end = byte_place(b->source, text, size);
    if (at.line > end.line) /* libyaml imagines a last newline */
        at = end;
    if (parser->context)
        return fail_at(b->error, FEELER_BAD_INPUT, at, "not valid YAML: %s %s", problem, parser->context);
    return fail_at(b->error, FEELER_BAD_INPUT, at, "not valid YAML: %s", problem);
}

static int read_events(builder *b, yaml_parser_t *parser, const char *text, size_t size) {
    yaml_event_t event;
    bool done = false;
    while (!done) {
        if (!yaml_parser_parse(parser, &event))
            return parser_error(b, parser, text, size);
        done = event.type == YAML_STREAM_END_EVENT;
        int status = take_event(b, &event);
        yaml_event_delete(&event);
        if (status != 0)
            return -1;
    }
    return b->root
               ? 0
               : fail_at(b->error, FEELER_BAD_INPUT, (place){b->source, 0, 0}, "is empty; the smallest scene is '{}'");
}

/* A binary file is told as such: what a YAML parser finds wrong in it would mislead. */
static int check_text(const char *source, const char *text, size_t size, feeler_error *error) {
    for (size_t i = 0; i < size; i++) {
        unsigned char c = (unsigned char)text[i];
        if ((c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7F)
            return fail_at(error, FEELER_BAD_INPUT, byte_place(source, text, i),
                           "not a text file: it holds the byte 0x%02X", c);
    }
    return 0;
}

/* The whole file with a zero byte behind it, to be freed, or NULL. */
static char *read_file(const char *path, const char *source, size_t *size, feeler_error *error) {
    place at = {source, 0, 0};
    FILE *file = fopen(path, "rb");
    if (!file) {
        fail_at(error, FEELER_IO, at, "cannot be opened: %s", strerror(errno));
        return NULL;
    }
    char *text = NULL;
    size_t capacity = 0, used = 0, got;
    do {
        if (capacity - used < 2) {
            capacity = capacity ? capacity * 2 : 1 << 16;
            char *moved = realloc(text, capacity);
            if (!moved) {
                fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
                goto failed;
            }
            text = moved;
        }
        got = fread(text + used, 1, capacity - used - 1, file);
        used += got;
    } while (got > 0);
    if (ferror(file)) {
        fail_at(error, FEELER_IO, at, "cannot be read: %s", strerror(errno));
        goto failed;
    }
    fclose(file);
    text[used] = '\0';
    *size = used;
    return text;
failed:
    free(text);
    fclose(file);
    return NULL;
}

/* The root of a text, or NULL. */
static const feeler_node *build(const char *text, size_t size, yaml_lines *lines, const char *source, node_pool *pool,
                                feeler_error *error) {
    builder b = {.pool = pool, .source = source, .error = error, .lines = lines};
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) {
        out_of_memory(&b);
        return NULL;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    int status = read_events(&b, &parser, text, size);
    yaml_parser_delete(&parser);
    free_anchors(&b);
    return status == 0 ? b.root : NULL;
}

const feeler_node *yaml_read_file(const char *path, const char *source, node_pool *pool, feeler_error *error) {
    size_t size;
    char *text = read_file(path, source, &size, error);
    if (!text)
        return NULL;
    const feeler_node *root = NULL;
    yaml_lines lines;
    int status = check_text(source, text, size, error);
    if (status == 0 && yaml_lines_read(text, size, pool, &lines)) {
        root = build(lines.text, lines.size, &lines, source, pool, NULL);
        if (!yaml_lines_done(&lines))
            root = NULL;
        yaml_lines_free(&lines);
    }
    if (status == 0 && !root)
        root = build(text, size, NULL, source, pool, error);
    free(text);
    return root;
}
