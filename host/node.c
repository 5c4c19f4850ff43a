/* node.c - see node.h, and feeler.h for what callers may build. */
#include "node.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- pool ---- */

struct pool_block {
    struct pool_block *next;
    size_t used, size;
    max_align_t bytes[];
};

static void *pool_take(node_pool *pool, size_t size) {
    enum { BLOCK = 1 << 20, ALIGNMENT = sizeof(void *) };
    size = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    struct pool_block *block = pool->blocks;
    if (!block || block->size - block->used < size) {
        size_t room = size > BLOCK ? size : BLOCK;
        block = malloc(sizeof *block + room);
        if (!block)
            return NULL;
        *block = (struct pool_block){pool->blocks, 0, room};
        pool->blocks = block;
    }
    void *taken = (char *)block->bytes + block->used;
    block->used += size;
    return taken;
}

feeler_node *node_pool_new(node_pool *pool, node_kind kind) {
    feeler_node *node = pool_take(pool, sizeof *node);
    if (node) {
        memset(node, 0, sizeof *node);
        node->kind = (uint8_t)kind;
    }
    return node;
}

const char *node_pool_text(node_pool *pool, const char *text, size_t length) {
    char *copy = pool_take(pool, length + 1);
    if (!copy)
        return NULL;
    memcpy(copy, text, length);
    copy[length] = '\0';
    return copy;
}

const char *node_pool_key(node_pool *pool, const char *text, size_t length) {
    size_t slots = sizeof pool->recent_keys / sizeof *pool->recent_keys;
    size_t slot = length ? (length * 7 + (unsigned char)text[0] * 31 + (unsigned char)text[length - 1]) % slots : 0;
    const char *recent = pool->recent_keys[slot];
    if (recent && strlen(recent) == length && memcmp(recent, text, length) == 0)
        return recent;
    return pool->recent_keys[slot] = node_pool_text(pool, text, length);
}

void node_pool_free(node_pool *pool) {
    while (pool->blocks) {
        struct pool_block *next = pool->blocks->next;
        free(pool->blocks);
        pool->blocks = next;
    }
    memset(pool, 0, sizeof *pool);
}

/* ---- what callers build ---- */

static feeler_node *new_node(node_kind kind) {
    feeler_node *node = calloc(1, sizeof *node);
    if (node)
        node->kind = (uint8_t)kind;
    return node;
}

feeler_node *feeler_node_map(void) {
    return new_node(NODE_MAP);
}

feeler_node *feeler_node_list(void) {
    return new_node(NODE_LIST);
}

feeler_node *feeler_node_text(const char *text) {
    feeler_node *node = text ? new_node(NODE_TEXT) : NULL;
    if (!node)
        return NULL;
    node->quoted = true;
    node->text = strdup(text);
    if (!node->text) {
        free(node);
        return NULL;
    }
    return node;
}

feeler_node *feeler_node_number(double value) {
    feeler_node *node = new_node(NODE_NUMBER);
    if (node)
        node->number = value;
    return node;
}

feeler_node *feeler_node_array(const double *values, size_t rows, size_t columns) {
    if (columns && rows > SIZE_MAX / sizeof *values / columns)
        return NULL;
    size_t size = rows * columns * sizeof *values;
    if (size && !values)
        return NULL;
    feeler_node *node = new_node(NODE_ARRAY);
    if (!node)
        return NULL;
    node->array.values = malloc(size ? size : 1);
    if (!node->array.values) {
        free(node);
        return NULL;
    }
    if (size)
        memcpy(node->array.values, values, size);
    node->array.rows = rows;
    node->array.columns = columns;
    return node;
}

void node_append(feeler_node *parent, feeler_node *child) {
    child->parent = parent;
    child->index = (uint32_t)parent->children.count++;
    if (parent->children.last)
        parent->children.last->next = child;
    else
        parent->children.first = child;
    parent->children.last = child;
}

static bool is_within(const feeler_node *node, const feeler_node *tree) {
    while (node && node != tree)
        node = node->parent;
    return node == tree;
}

int feeler_node_add(feeler_node *parent, const char *key, feeler_node *child) {
    if (!child)
        return -1;
    bool map = parent && parent->kind == NODE_MAP;
    bool list = parent && parent->kind == NODE_LIST;
    if (child->parent || is_within(parent, child)) /* it belongs to a tree already, which frees it */
        return -1;
    if ((!map && !list) || (map && !key) || parent->children.count == UINT32_MAX) {
        feeler_node_free(child);
        return -1;
    }
    if (map) {
        child->key = strdup(key);
        if (!child->key) {
            feeler_node_free(child);
            return -1;
        }
    }
    node_append(parent, child);
    return 0;
}

static void free_one(feeler_node *node) {
    free((char *)node->key);
    if (node->kind == NODE_TEXT)
        free((char *)node->text);
    else if (node->kind == NODE_ARRAY)
        free(node->array.values);
    free(node);
}

/* Without recursion: a caller's tree may be deeper than the stack. */
void feeler_node_free(feeler_node *root) {
    feeler_node *node = root;
    while (node) {
        bool parent = (node->kind == NODE_MAP || node->kind == NODE_LIST) && node->children.first;
        if (parent) {
            feeler_node *child = node->children.first;
            node->children.first = child->next;
            node = child;
        } else {
            feeler_node *above = node == root ? NULL : node->parent;
            free_one(node);
            node = above;
        }
    }
}

/* ---- questions ---- */

size_t node_count(const feeler_node *node) {
    if (node->kind == NODE_MAP || node->kind == NODE_LIST)
        return node->children.count;
    if (node->kind == NODE_ARRAY)
        return node->array.rows == 1 || node->array.columns == 1 ? node->array.rows * node->array.columns
                                                                 : node->array.rows;
    return 0;
}

const char *node_kind_name(const feeler_node *node) {
    static const char *const names[] = {"a map", "a list", "a text", "a number", "an array"};
    if (node->kind == NODE_TEXT && !node->quoted && !node->text[0])
        return "nothing";
    return names[node->kind];
}

/* Writes the path's pieces from the last to the first, before `end`; what does not fit is left out at the front. */
static place path_place(const feeler_node *node, char buffer[NODE_PATH_SIZE]) {
    char *start = buffer + NODE_PATH_SIZE - 1;
    *start = '\0';
    for (; node->parent; node = node->parent) {
        char piece[NODE_PATH_SIZE];
        bool top = !node->parent->parent;
        if (node->key)
            snprintf(piece, sizeof piece, "%s%s", top ? "" : ".", node->key);
        else
            snprintf(piece, sizeof piece, "[%u]", (unsigned)node->index);
        size_t length = strlen(piece);
        if (length > (size_t)(start - buffer))
            break;
        start -= length;
        memcpy(start, piece, length);
    }
    return (place){*start ? start : "scene", 0, 0};
}

static place text_place(const feeler_node *node, uint32_t line, uint32_t column) {
    while (node->parent)
        node = node->parent;
    return (place){node->source, (int)line, (int)column};
}

place node_place(const feeler_node *node, char buffer[NODE_PATH_SIZE]) {
    return node->line ? text_place(node, node->line, node->column) : path_place(node, buffer);
}

place node_key_place(const feeler_node *node, char buffer[NODE_PATH_SIZE]) {
    return node->key_line ? text_place(node, node->key_line, node->key_column) : node_place(node, buffer);
}
