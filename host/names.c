/* names.c - material names to indices: open addressing, at most half full. */
#include "schema.h"

#include <stdlib.h>
#include <string.h>

/* FNV-1a, 64 bit. */
static uint64_t hash_text(const char *text) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
    return hash;
}

/* The name's slot, or the empty one where it would go. */
static struct name_slot *slot_of(const name_table *table, const char *name) {
    size_t at = (size_t)hash_text(name) & (table->capacity - 1);
    while (table->slots[at].name && strcmp(table->slots[at].name, name) != 0)
        at = (at + 1) & (table->capacity - 1);
    return &table->slots[at];
}

static int enlarge(name_table *table) {
    name_table bigger = {NULL, table->count, table->capacity ? table->capacity * 2 : 16};
    bigger.slots = calloc(bigger.capacity, sizeof *bigger.slots);
    if (!bigger.slots)
        return -1;
    for (size_t i = 0; i < table->capacity; i++)
        if (table->slots[i].name)
            *slot_of(&bigger, table->slots[i].name) = table->slots[i];
    free(table->slots);
    *table = bigger;
    return 0;
}

int name_add(name_table *table, const char *name, int index) {
    if ((table->count + 1) * 2 > table->capacity && enlarge(table) != 0)
        return -1;
    struct name_slot *slot = slot_of(table, name);
    if (slot->name)
        return 1;
    *slot = (struct name_slot){name, index};
    table->count++;
    return 0;
}

int name_find(const name_table *table, const char *name) {
    if (!table->capacity)
        return -1;
    const struct name_slot *slot = slot_of(table, name);
    return slot->name ? slot->index : -1;
}

void name_table_free(name_table *table) {
    free(table->slots);
    *table = (name_table){NULL, 0, 0};
}
