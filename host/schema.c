/* schema.c - the tables of keys.c against nodes and against values. */
#include "schema.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { RANGE_SIZE = 160 };

static bool in_range(const schema_key *key, double value) {
    bool low = key->flags & KEY_ABOVE_LOW ? value > key->low : value >= key->low;
    bool high = key->flags & KEY_BELOW_HIGH ? value < key->high : value <= key->high;
    return isfinite(value) && low && high;
}

/* "is 1.5, but must be 0 to 1". */
static void range_message(const schema_key *key, double value, char message[RANGE_SIZE]) {
    char low[64];
    if (key->flags & KEY_ABOVE_LOW)
        snprintf(low, sizeof low, "more than %g and %s %g", key->low,
                 key->flags & KEY_BELOW_HIGH ? "less than" : "at most", key->high);
    else
        snprintf(low, sizeof low, "%g to %g", key->low, key->high);
    snprintf(message, RANGE_SIZE, "is %.9g, but must be %s", value, low);
}

void schema_set_defaults(const schema_key *keys, void *target) {
    for (const schema_key *key = keys; key->name; key++) {
        void *field = (char *)target + (key->type == KEY_NODE ? 0 : key->offset);
        switch (key->type) {
        case KEY_NUMBER:
            *(double *)field = key->standard[0];
            break;
        case KEY_INTEGER:
        case KEY_CHOICE:
            *(int *)field = (int)key->standard[0];
            break;
        case KEY_BOOL:
            *(bool *)field = key->standard[0] != 0;
            break;
        case KEY_POINT:
        case KEY_DIRECTION:
        case KEY_COLOUR:
            *(vec3 *)field = (vec3){key->standard[0], key->standard[1], key->standard[2]};
            break;
        case KEY_NODE:
            break;
        }
    }
}

/* The first component of a row's value that is out of its range, or NULL. */
static const double *bad_component(const schema_key *key, const void *target, double *integer) {
    const void *field = (const char *)target + (key->type == KEY_NODE ? 0 : key->offset);
    const vec3 *vector = field;
    switch (key->type) {
    case KEY_NUMBER:
        return in_range(key, *(const double *)field) ? NULL : field;
    case KEY_INTEGER:
        *integer = *(const int *)field;
        return in_range(key, *integer) ? NULL : integer;
    case KEY_POINT:
    case KEY_DIRECTION:
    case KEY_COLOUR:
        return !in_range(key, vector->x)   ? &vector->x
               : !in_range(key, vector->y) ? &vector->y
               : !in_range(key, vector->z) ? &vector->z
                                           : NULL;
    default:
        return NULL;
    }
}

int schema_check(const schema_key *keys, const void *target, place place, const char *what, feeler_error *error) {
    for (const schema_key *key = keys; key->name; key++) {
        double integer;
        const double *bad = bad_component(key, target, &integer);
        if (bad) {
            char message[RANGE_SIZE];
            range_message(key, *bad, message);
            return fail_at(error, FEELER_BAD_INPUT, place, "%s: '%s' %s", what, key->name, message);
        }
    }
    return 0;
}

/* Whether a number other than 0 was written that is 0 as a double. */
static bool vanished(const feeler_node *value) {
    return value->kind == NODE_TEXT && strcspn(value->text, "123456789") < strcspn(value->text, "eE");
}

static int check_read(const reader *reader, const feeler_node *node, const schema_key *key, const void *target) {
    double unused;
    const double *bad = bad_component(key, target, &unused);
    const vec3 *vector = (const void *)((const char *)target + key->offset);
    if (bad) {
        char message[RANGE_SIZE], text[SHOWN_SIZE];
        range_message(key, *bad, message);
        const feeler_node *value = node_value(node);
        if (*bad == 0 && vanished(value))
            return fail_node(reader, value, "'%s' is %s, which is too small a number", key->name,
                             shown(value->text, text));
        bool list = value->kind == NODE_LIST || value->kind == NODE_ARRAY;
        if (list && key->type >= KEY_POINT)
            return fail_item(reader, value, (size_t)(bad - &vector->x), "'%s' %s", key->name, message);
        return fail_node(reader, value, "'%s' %s", key->name, message);
    }
    if (key->type == KEY_DIRECTION && vector->x == 0 && vector->y == 0 && vector->z == 0)
        return fail_node(reader, node_value(node), "'%s' has length zero", key->name);
    return 0;
}

static int read_value(const reader *reader, const feeler_node *node, const schema_key *key, void *target,
                      const feeler_node **nodes) {
    if (key->type == KEY_NODE) {
        nodes[key->offset] = node;
        return 0;
    }
    void *field = (char *)target + key->offset;
    char name[64];
    int status = -1;
    switch (key->type) {
    case KEY_NUMBER:
        status = read_number(reader, node, field);
        break;
    case KEY_INTEGER:
        snprintf(name, sizeof name, "'%s'", key->name);
        return read_integer(reader, node, key->low, key->high, name, field);
    case KEY_BOOL:
        return read_bool(reader, node, field);
    case KEY_CHOICE:
        return read_choice(reader, node, key->choices, field);
    case KEY_POINT:
    case KEY_DIRECTION:
        status = read_vector(reader, node, field);
        break;
    case KEY_COLOUR:
        status = read_colour(reader, node, field);
        break;
    case KEY_NODE:
        break;
    }
    return status == 0 ? check_read(reader, node, key, target) : -1;
}

static void list_keys(const schema_key *keys, char *text, size_t size) {
    text[0] = '\0';
    for (const schema_key *key = keys; key->name; key++) {
        size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s", key == keys ? "" : ", ", key->name);
    }
}

static int fail_unknown(const reader *reader, const feeler_node *node, const schema_key *keys) {
    char name[SHOWN_SIZE], hint[SUGGESTION_SIZE], known[300];
    suggestion nearest = suggest_for(node->key);
    for (const schema_key *key = keys; key->name; key++)
        suggest_candidate(&nearest, key->name);
    if (nearest.best)
        return fail_key(reader, node, "unknown key '%s'%s", shown(node->key, name), suggest_text(&nearest, hint));
    list_keys(keys, known, sizeof known);
    return fail_key(reader, node, "unknown key '%s' (known: %s)", shown(node->key, name), known);
}

static int check_required(const reader *reader, const feeler_node *node, const schema_key *keys, uint32_t seen) {
    for (int i = 0; keys[i].name; i++)
        if (keys[i].flags & KEY_REQUIRED && !(seen >> i & 1))
            return fail_node(reader, node, "the key '%s' is missing", keys[i].name);
    return 0;
}

int schema_read(const reader *reader, const feeler_node *node, const schema_key *keys, void *target,
                const feeler_node **nodes) {
    node = node_value(node);
    if (node->kind != NODE_MAP) {
        char known[300];
        list_keys(keys, known, sizeof known);
        return fail_node(reader, node, "expected a map with keys among %s, not %s", known, node_kind_name(node));
    }
    uint32_t seen = 0;
    for (const feeler_node *child = node->children.first; child; child = child->next) {
        int row = 0;
        while (keys[row].name && strcmp(keys[row].name, child->key) != 0)
            row++;
        if (!keys[row].name)
            return fail_unknown(reader, child, keys);
        if (seen >> row & 1)
            return fail_key(reader, child, "the key '%s' is given twice", child->key);
        seen |= UINT32_C(1) << row;
        if (read_value(reader, child, &keys[row], target, nodes) != 0)
            return -1;
    }
    return check_required(reader, node, keys, seen);
}

int schema_read_one(const reader *reader, const feeler_node *node, const schema_key *key, void *target) {
    return read_value(reader, node, key, target, NULL);
}

bool schema_has(const schema_key *keys, const char *name) {
    while (keys->name && strcmp(keys->name, name) != 0)
        keys++;
    return keys->name != NULL;
}
