/* node.h - the tree that scenes are read from: maps, lists, texts, numbers and arrays that know where they stand.
 *
 * A tree comes from YAML text (nodes have line and column; they live in a pool) or from a caller of feeler_node_* (nodes
 * have a path of keys; each is allocated by itself).
 */
#ifndef FEELER_NODE_H
#define FEELER_NODE_H

#include "scene.h"

typedef enum node_kind { NODE_MAP, NODE_LIST, NODE_TEXT, NODE_NUMBER, NODE_ARRAY, NODE_ALIAS } node_kind;

struct feeler_node {
    uint8_t kind;          /* node_kind */
    bool quoted;           /* NODE_TEXT: never a number or a bool */
    uint32_t index;        /* position among its parent's children */
    uint32_t line, column; /* of the value, from 1; 0: not from a text */
    uint32_t key_line, key_column;
    feeler_node *parent;
    feeler_node *next;  /* sibling */
    const char *key;    /* in a map, else NULL */
    const char *source; /* the root's only: the text's name */
    union {
        struct {
            feeler_node *first, *last;
            size_t count;
        } children;
        const char *text;
        double number;
        struct {
            double *values;
            size_t rows, columns;
        } array;
        feeler_node *target; /* NODE_ALIAS: what the anchor stands on; a node of the same tree, never an alias */
    };
};

/* Memory that is freed in one go. Zero-initialise. */
typedef struct node_pool {
    struct pool_block *blocks; /* the newest first */
    const char *recent_keys[64];
} node_pool;

/* A zeroed node of the pool, or NULL. */
feeler_node *node_pool_new(node_pool *pool, node_kind kind);
/* The pool's copy of `length` bytes, terminated, or NULL. */
const char *node_pool_text(node_pool *pool, const char *text, size_t length);
/* As node_pool_text, but the few keys that a scene repeats are stored once. */
const char *node_pool_key(node_pool *pool, const char *text, size_t length);
void node_pool_free(node_pool *pool);

/* Appends without taking or checking: for builders that own the nodes. */
void node_append(feeler_node *parent, feeler_node *child);

/* The node itself, or what an alias stands for. */
static inline const feeler_node *node_value(const feeler_node *node) {
    return node->kind == NODE_ALIAS ? node->target : node;
}

/* What a list, map or array holds: children, or rows (elements where one side is 1). 0 for the rest. */
size_t node_count(const feeler_node *node);
/* "a list", "a number", … for messages. */
const char *node_kind_name(const feeler_node *node);

/* The place of a value, or of its key. For a tree without a text the source is the path of keys, written to `buffer`. */
enum { NODE_PATH_SIZE = 512 };
place node_place(const feeler_node *node, char buffer[NODE_PATH_SIZE]);
place node_key_place(const feeler_node *node, char buffer[NODE_PATH_SIZE]);

#endif
