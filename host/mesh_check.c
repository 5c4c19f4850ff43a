/* mesh_check.c - whether a mesh file is all there, before assimp reads it.
 *
 * assimp 5.2 takes a PLY file that was cut short, repeats its last line or reads beyond its end, and says nothing; a text
 * STL file that was cut short makes it leak. The walk over a PLY file here knows only how long each element is, from the
 * header. What the texts of OBJ and STL say of numbers is for mesh_text.c.
 */
#include "mesh_file.h"
#include "schema.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { MOST_ELEMENTS = 16, MOST_PROPERTIES = 64 };

typedef struct property {
    unsigned size;       /* of one value, bytes */
    unsigned count_size; /* of a list's count; 0: a single value */
    bool whole;          /* of an integer type */
} property;

typedef struct element {
    char name[32];
    unsigned long long count;
    int property_count;
    property properties[MOST_PROPERTIES];
} element;

typedef struct ply {
    FILE *file;
    bool begins; /* as a PLY file does */
    enum { ASCII, LITTLE_ENDIAN_BINARY, BIG_ENDIAN_BINARY } format;
    int element_count;
    element elements[MOST_ELEMENTS];
    mesh_fault *fault;
    int line, column;           /* of the next character */
    int word_line, word_column; /* of the last word */
} ply;

bool mesh_ends_with(const char *path, const char *ending) {
    size_t length = strlen(path), tail = strlen(ending);
    return length >= tail && strcasecmp(path + length - tail, ending) == 0;
}

/* ---- the header ---- */

/* Bytes of a type; 0 when unknown. */
static unsigned type_size(const char *name) {
    static const struct {
        const char *name;
        unsigned size;
    } types[] = {
        {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},   {"short", 2}, {"ushort", 2},
        {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},    {"int32", 4}, {"uint32", 4},
        {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(types[i].name, name) == 0)
            return types[i].size;
    return 0;
}

static bool read_property(ply *p, const char *line) {
    char count_type[32], type[32];
    if (p->element_count == 0)
        return false;
    element *e = &p->elements[p->element_count - 1];
    if (e->property_count == MOST_PROPERTIES)
        return false;
    property *one = &e->properties[e->property_count++];
    if (sscanf(line, "property list %31s %31s", count_type, type) == 2) {
        *one = (property){type_size(type), type_size(count_type), !strpbrk(type, "fd")}; /* float, double */
        return one->size > 0 && one->count_size > 0;
    }
    *one = (property){0};
    if (sscanf(line, "property %31s", type) == 1)
        one->size = type_size(type);
    return one->size > 0;
}

static bool read_format(ply *p, const char *line) {
    char name[32];
    if (sscanf(line, "format %31s", name) != 1)
        return false;
    p->format = strcmp(name, "ascii") == 0                  ? ASCII
                : strcmp(name, "binary_little_endian") == 0 ? LITTLE_ENDIAN_BINARY
                                                            : BIG_ENDIAN_BINARY;
    return true;
}

/* Reads to the header's end. False where it is not as the format has it: assimp then finds the words for that. */
static bool read_header(ply *p) {
    char line[1024], word[32];
    while (fgets(line, sizeof line, p->file)) {
        p->line += strchr(line, '\n') != NULL;
        p->begins = p->begins || strncmp(line, "ply", 3) == 0;
        if (sscanf(line, "%31s", word) != 1)
            continue;
        if (strcmp(word, "end_header") == 0)
            return true;
        if (strcmp(word, "format") == 0 && !read_format(p, line))
            return false;
        if (strcmp(word, "property") == 0 && !read_property(p, line))
            return false;
        if (strcmp(word, "element") == 0) {
            if (p->element_count == MOST_ELEMENTS)
                return false;
            element *e = &p->elements[p->element_count++];
            if (sscanf(line, "element %31s %llu", e->name, &e->count) != 2)
                return false;
        }
    }
    return false;
}

/* ---- the elements ---- */

static bool skip_bytes(ply *p, unsigned long long count) {
    for (; count; count--)
        if (getc_unlocked(p->file) == EOF)
            return false;
    return true;
}

static int next_character(ply *p) {
    int c = getc_unlocked(p->file);
    p->column++;
    if (c == '\n') {
        p->line++;
        p->column = 1;
    }
    return c;
}

static bool is_space(int c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* A word of the text, cut to fit. */
static bool read_word(ply *p, char *word, size_t size) {
    int c;
    size_t length = 0;
    do {
        p->word_line = p->line;
        p->word_column = p->column;
        c = next_character(p);
    } while (is_space(c));
    for (; c != EOF && !is_space(c); c = next_character(p))
        if (length + 1 < size)
            word[length++] = (char)c;
    word[length] = 0;
    return length > 0;
}

/* False, with the fault, where the last word is none of what it should be. */
static bool expect(ply *p, bool right, const char *word, const char *what) {
    char text[SHOWN_SIZE];
    if (right)
        return true;
    p->fault->line = p->word_line;
    p->fault->column = p->word_column;
    snprintf(p->fault->text, sizeof p->fault->text, "'%s' is not %s", shown(word, text), what);
    return false;
}

static bool read_count(ply *p, unsigned size, unsigned long long *count) {
    char word[32];
    *count = 0;
    if (p->format == ASCII) {
        bool found = read_word(p, word, sizeof word);
        *count = strtoull(word, NULL, 10);
        return found && expect(p, word[strspn(word, "0123456789")] == 0, word, "a count");
    }
    for (unsigned i = 0; i < size; i++) {
        int byte = getc_unlocked(p->file);
        if (byte == EOF)
            return false;
        *count |= (unsigned long long)byte << 8 * (p->format == LITTLE_ENDIAN_BINARY ? i : size - 1 - i);
    }
    return true;
}

/* A value of the text. Whether it is finite is only asked of what is read: see mesh_file.c. */
static bool skip_word(ply *p, const property *one) {
    char word[512];
    if (!read_word(p, word, sizeof word))
        return false;
    if (one->count_size && one->whole)
        return expect(p, word[0] && !word[strspn(word, "+-0123456789")], word, "a whole number");
    bool cut = strlen(word) == sizeof word - 1;
    return expect(p, cut || mesh_check_number(word, false, (char[128]){0}, 128) == FEELER_OK, word, "a number");
}

static bool skip_property(ply *p, const property *one) {
    unsigned long long count = 1;
    if (one->count_size && !read_count(p, one->count_size, &count))
        return false;
    if (p->format != ASCII)
        return count <= UINT32_MAX && skip_bytes(p, count * one->size);
    for (; count; count--)
        if (!skip_word(p, one))
            return false;
    return true;
}

static bool skip_item(ply *p, const element *e) {
    for (int i = 0; i < e->property_count; i++)
        if (!skip_property(p, &e->properties[i]))
            return false;
    return true;
}

static int check_ply(FILE *file, mesh_fault *fault) {
    ply *p = calloc(1, sizeof *p);
    if (!p) {
        snprintf(fault->text, sizeof fault->text, "out of memory");
        return FEELER_OUT_OF_MEMORY;
    }
    p->file = file;
    p->fault = fault;
    p->line = p->column = 1;
    int elements = read_header(p) ? p->element_count : 0, code = FEELER_OK;
    if (!elements && feof(file) && p->begins) { /* assimp would look for it for ever */
        snprintf(fault->text, sizeof fault->text, "is cut short: its header has no end");
        code = FEELER_BAD_INPUT;
    }
    for (int k = 0; k < elements && code == FEELER_OK; k++) {
        const element *e = &p->elements[k];
        unsigned long long whole = 0;
        while (e->property_count && whole < e->count && skip_item(p, e))
            whole++;
        if (fault->line)
            code = FEELER_BAD_INPUT;
        else if (e->property_count && whole < e->count) {
            snprintf(fault->text, sizeof fault->text, "is cut short: it ends after %llu of %llu elements '%s'", whole,
                     e->count, e->name);
            code = FEELER_BAD_INPUT;
        }
    }
    free(p);
    return code;
}

/* ---- STL ---- */

/* Binary STL says how many triangles of 50 bytes follow its header of 84 bytes; text begins with "solid" and ends with
 * "endsolid" and perhaps a name. */
static int check_stl(FILE *file, unsigned long long length, mesh_fault *fault) {
    unsigned char head[84] = {0};
    char tail[1025] = "";
    size_t got = fread(head, 1, sizeof head, file);
    unsigned long long count =
        head[80] | head[81] << 8 | (unsigned long long)head[82] << 16 | (unsigned long long)head[83] << 24;
    if (got == sizeof head && length == sizeof head + 50 * count)
        return FEELER_OK;
    if (memcmp(head, "solid", 5) != 0) {
        if (got < sizeof head)
            snprintf(fault->text, sizeof fault->text, "is cut short: it ends within the header");
        else
            snprintf(fault->text, sizeof fault->text,
                     "is cut short or no STL file: %llu triangles need %llu bytes, but it has %llu", count,
                     sizeof head + 50 * count, length);
        return FEELER_BAD_INPUT;
    }
    if (length > sizeof tail - 1 && fseek(file, -(long)(sizeof tail - 1), SEEK_END))
        return FEELER_OK;
    if (length <= sizeof tail - 1)
        rewind(file);
    got = fread(tail, 1, sizeof tail - 1, file);
    tail[got] = 0;
    if (strlen(tail) == got && !strstr(tail, "endsolid")) {
        snprintf(fault->text, sizeof fault->text, "is cut short: it ends without 'endsolid'");
        return FEELER_BAD_INPUT;
    }
    return mesh_check_stl_text(file, length, fault);
}

int mesh_check_file(const char *path, mesh_fault *fault) {
    struct stat about;
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), &about)) {
        snprintf(fault->text, sizeof fault->text, "cannot be opened: %s", strerror(errno));
        if (file)
            fclose(file);
        return FEELER_IO;
    }
    int code = FEELER_BAD_INPUT;
    if (S_ISDIR(about.st_mode))
        snprintf(fault->text, sizeof fault->text, "is a folder, not a mesh file");
    else if (S_ISREG(about.st_mode) && about.st_size == 0)
        snprintf(fault->text, sizeof fault->text, "is empty");
    else if (mesh_ends_with(path, ".ply"))
        code = check_ply(file, fault);
    else if (mesh_ends_with(path, ".stl") && S_ISREG(about.st_mode))
        code = check_stl(file, (unsigned long long)about.st_size, fault);
    else if (mesh_ends_with(path, ".obj") && S_ISREG(about.st_mode))
        code = mesh_check_obj(file, (size_t)about.st_size, fault);
    else
        code = FEELER_OK;
    fclose(file);
    return code;
}
