/* pixel_text.c - the ray tree of a pixel as an indented text, from its JSON. */
#include "pixel.h"

#include <stdlib.h>
#include <string.h>

/* Where a line begins: what leads to its ray, and the bars of those that are still to come. */
typedef struct sheet {
    FILE *out;
    char *indent;
    size_t length, size;
} sheet;

static double number_of(const json_t *object, const char *key) {
    return json_number_value(json_object_get(object, key));
}

/* -0 is printed as 0, which the sum with 0 is. */
static void print_vector(FILE *out, const char *label, const json_t *vector) {
    fprintf(out, "%s(%.6g, %.6g, %.6g)", label, json_number_value(json_array_get(vector, 0)) + 0,
            json_number_value(json_array_get(vector, 1)) + 0, json_number_value(json_array_get(vector, 2)) + 0);
}

static void begin_line(const sheet *s) {
    fwrite(s->indent, 1, s->length, s->out);
}

static void print_list(FILE *out, const json_t *names) {
    size_t i;
    json_t *name;
    if (json_array_size(names) == 0)
        fputs("no medium", out);
    json_array_foreach(names, i, name) fprintf(out, "%s%s", i ? " > " : "", json_string_value(name));
}

/* ---- lights ---- */

static void print_term(FILE *out, const json_t *light, const char *key, const char *factor, double value) {
    if (is_zero(json_object_get(light, key)))
        return;
    fputs("  ", out);
    print_key(out, key);
    fputc(' ', out);
    print_colour(out, json_object_get(light, key));
    fprintf(out, " (%s %.4g)", factor, value);
}

/* What ends the feeler has been told. */
static void print_crossed(const sheet *s, const json_t *crossed, const json_t *blocker) {
    size_t i;
    json_t *one;
    json_array_foreach(crossed, i, one) {
        if (is_zero(json_object_get(one, "share")) && json_is_object(blocker))
            break;
        begin_line(s);
        fputs("    through ", s->out);
        print_object(s->out, one, true);
        fprintf(s->out, " at %.6g, leaves ", number_of(one, "distance"));
        print_colour(s->out, json_object_get(one, "share"));
        fputc('\n', s->out);
    }
}

static void print_blocker(FILE *out, const json_t *feeler, const json_t *blocker) {
    const json_t *length = json_object_get(feeler, "length");
    fputs("  blocked by ", out);
    print_object(out, blocker, true);
    fprintf(out, " at %.6g", number_of(blocker, "distance"));
    if (json_is_number(length))
        fprintf(out, " of %.6g", json_number_value(length));
}

static void print_light(const sheet *s, const json_t *light) {
    const json_t *feeler = json_object_get(light, "feeler"), *blocker = json_object_get(feeler, "blocked_by");
    const bool back = strcmp(text_of(light, "side"), "back") == 0;
    begin_line(s);
    fprintf(s->out, "lights[%d]", whole_of(light, "light"));
    if (json_is_object(blocker)) {
        print_blocker(s->out, feeler, blocker);
    } else {
        const double cosine = number_of(light, "cosine"), highlight = number_of(light, "highlight");
        print_term(s->out, light, back ? "diffuse_transmission" : "diffuse", "cosine", back ? -cosine : cosine);
        print_term(s->out, light, back ? "specular_transmission" : "specular", "highlight", highlight);
        if (!json_is_object(feeler))
            fputs("  without a feeler", s->out);
    }
    fputc('\n', s->out);
    print_crossed(s, json_object_get(feeler, "crossed"), blocker);
}

/* Those that add nothing and are not blocked follow on one line for each reason. */
static void print_lights(const sheet *s, const json_t *lights) {
    size_t i;
    json_t *light, *numbers, *idle = json_object();
    const char *reason;
    json_array_foreach(lights, i, light) {
        const json_t *feeler = json_object_get(light, "feeler");
        if (!is_zero(json_object_get(light, "colour")) || json_is_object(json_object_get(feeler, "blocked_by"))) {
            print_light(s, light);
            continue;
        }
        reason = json_array_size(json_object_get(feeler, "crossed")) ? "filtered, nothing is left"
                 : json_is_object(feeler)                            ? "its highlight is not here"
                                                                     : text_of(light, "no_feeler");
        const char *before = json_string_value(json_object_get(idle, reason));
        json_object_set_new(idle, reason,
                            json_sprintf("%s%s%d", before ? before : "", before ? "," : "", whole_of(light, "light")));
    }
    json_object_foreach(idle, reason, numbers) {
        begin_line(s);
        fprintf(s->out, "lights[%s]  nothing: %s\n", json_string_value(numbers), reason);
    }
    json_decref(idle);
}

/* ---- rays ---- */

static void print_hit(const sheet *s, const json_t *hit) {
    const json_t *indices = json_object_get(hit, "indices");
    size_t i;
    json_t *one;
    begin_line(s);
    fputs("meets ", s->out);
    print_object(s->out, hit, true);
    fprintf(s->out, " at %.6g, %s\n", number_of(hit, "distance"),
            json_is_true(json_object_get(hit, "entering")) ? "from its front" : "from its back");
    begin_line(s);
    print_vector(s->out, "at ", json_object_get(hit, "point"));
    print_vector(s->out, ", normal ", json_object_get(hit, "normal"));
    if (!json_equal(json_object_get(hit, "normal"), json_object_get(hit, "shading")))
        print_vector(s->out, ", shading normal ", json_object_get(hit, "shading"));
    fputc('\n', s->out);
    json_array_foreach(json_object_get(hit, "touching"), i, one) {
        begin_line(s);
        fputs("and at the same place ", s->out);
        print_object(s->out, one, true);
        fputc('\n', s->out);
    }
    if (!json_is_array(indices))
        return;
    begin_line(s);
    fprintf(s->out, "refractive indices %.6g to %.6g", json_number_value(json_array_get(indices, 0)),
            json_number_value(json_array_get(indices, 1)));
    if (json_object_get(hit, "media_behind")) {
        fputs(", behind it ", s->out);
        print_list(s->out, json_object_get(hit, "media_behind"));
    }
    fputs(json_is_true(json_object_get(hit, "total_reflection")) ? ", total internal reflection\n" : "\n", s->out);
}

static void print_local(const sheet *s, const json_t *local) {
    static const char *const own[] = {"ambient", "emission"};
    for (size_t k = 0; k < 2; k++) {
        if (is_zero(json_object_get(local, own[k])))
            continue;
        begin_line(s);
        fprintf(s->out, "%s  ", own[k]);
        print_colour(s->out, json_object_get(local, own[k]));
        fputc('\n', s->out);
    }
    print_lights(s, json_object_get(local, "lights"));
    begin_line(s);
    fputs("I_local  ", s->out);
    print_colour(s->out, json_object_get(local, "colour"));
    fputc('\n', s->out);
}

static void print_way(const sheet *s, const json_t *ray) {
    size_t i;
    json_t *one;
    begin_line(s);
    print_vector(s->out, "from ", json_object_get(ray, "origin"));
    print_vector(s->out, " along ", json_object_get(ray, "direction"));
    if (json_array_size(json_object_get(ray, "media"))) {
        fputs(" in ", s->out);
        print_list(s->out, json_object_get(ray, "media"));
    }
    fputc('\n', s->out);
    json_array_foreach(json_object_get(ray, "passed"), i, one) {
        begin_line(s);
        fputs("passes a hidden boundary of ", s->out);
        print_object(s->out, one, true);
        fprintf(s->out, " at %.6g\n", number_of(one, "distance"));
    }
}

static void print_ray(sheet *s, const json_t *ray, const char *branch, const char *bar);

/* What is said of a ray that is not sent; NULL where there is nothing to say. */
static const char *unsent_text(const json_t *way) {
    static const char *const said[][2] = {{"depth", "not sent: beyond the greatest depth"},
                                          {"cutoff", "not sent: its weight is below the cutoff"},
                                          {"weight", "not sent: it weighs nothing"},
                                          {"total reflection", "none: total internal reflection"}};
    for (size_t i = 0; i < sizeof said / sizeof *said; i++)
        if (strcmp(text_of(way, "unsent"), said[i][0]) == 0)
            return said[i][1];
    return NULL;
}

static void print_unsent(const sheet *s, const char *name, const json_t *way, const char *branch) {
    begin_line(s);
    fprintf(s->out, "%s%s %s", branch, name, unsent_text(way));
    if (!is_zero(json_object_get(way, "weight"))) {
        fputs(", weight ", s->out);
        print_colour(s->out, json_object_get(way, "weight"));
    }
    fputc('\n', s->out);
}

static const char *const names[] = {"reflection", "transmission"};

/* Whether there is something to tell of what a ray sends on. */
static bool is_told(const json_t *ray, int way) {
    const json_t *sent = json_object_get(ray, names[way]);
    return json_is_object(json_object_get(sent, "ray")) || unsent_text(sent);
}

static void print_children(sheet *s, const json_t *ray) {
    const json_t *ways[] = {json_object_get(ray, "reflection"), json_object_get(ray, "transmission")};
    for (int i = 0; i < 2; i++) {
        const bool last = i == 1 || !is_told(ray, 1);
        const json_t *next = json_object_get(ways[i], "ray");
        if (!is_told(ray, i))
            continue;
        if (json_is_object(next))
            print_ray(s, next, last ? "└ " : "├ ", last ? "  " : "│ ");
        else
            print_unsent(s, names[i], ways[i], last ? "└ " : "├ ");
    }
}

static bool deepen(sheet *s, const char *bar) {
    const size_t more = strlen(bar);
    if (s->length + more > s->size) {
        char *longer = realloc(s->indent, 2 * s->size + more);
        if (!longer)
            return false;
        s->indent = longer;
        s->size = 2 * s->size + more;
    }
    memcpy(s->indent + s->length, bar, more);
    s->length += more;
    return true;
}

/* `branch` leads to the ray's first line, `bar` to the others. */
static void print_ray(sheet *s, const json_t *ray, const char *branch, const char *bar) {
    const size_t length = s->length;
    begin_line(s);
    fprintf(s->out, "%s%s ray %d, level %d, weight ", branch, text_of(ray, "kind"), whole_of(ray, "number"),
            whole_of(ray, "level"));
    print_colour(s->out, json_object_get(ray, "weight"));
    fputs(", brings ", s->out);
    print_colour(s->out, json_object_get(ray, "colour"));
    fputc('\n', s->out);
    if (!deepen(s, bar))
        return;
    const size_t inner = s->length;
    const json_t *hit = json_object_get(ray, "hit");
    if (!deepen(s, is_told(ray, 0) || is_told(ray, 1) ? "│ " : "  "))
        return;
    print_way(s, ray);
    if (json_is_object(hit)) {
        print_hit(s, hit);
        print_local(s, json_object_get(ray, "local"));
    } else {
        begin_line(s);
        fputs("meets nothing: background ", s->out);
        print_colour(s->out, json_object_get(ray, "background"));
        fputc('\n', s->out);
    }
    s->length = inner;
    print_children(s, ray);
    s->length = length;
}

/* ---- the pixel ---- */

static void print_heading(FILE *out, const json_t *pixel) {
    const json_t *size = json_object_get(pixel, "size"), *at = json_object_get(pixel, "pixel"),
                 *rays = json_object_get(pixel, "rays");
    const int samples = whole_of(pixel, "samples");
    fprintf(out, "pixel %d,%d of %s, %dx%d, %d sample%s, depth %d, %s\n",
            (int)json_integer_value(json_array_get(at, 0)), (int)json_integer_value(json_array_get(at, 1)),
            text_of(pixel, "scene"), (int)json_integer_value(json_array_get(size, 0)),
            (int)json_integer_value(json_array_get(size, 1)), samples, samples == 1 ? "" : "s",
            whole_of(pixel, "depth"), text_of(pixel, "level"));
    fputs("colour ", out);
    print_colour(out, json_object_get(pixel, "colour"));
    fprintf(out, "; rays: %d eye, %d reflection, %d transmission, %d shadow\n", whole_of(rays, "eye"),
            whole_of(rays, "reflection"), whole_of(rays, "transmission"), whole_of(rays, "shadow"));
}

static void print_pixel(sheet *s, const json_t *pixel) {
    size_t i;
    json_t *tree, *line;
    const size_t samples = json_array_size(json_object_get(pixel, "trees"));
    print_heading(s->out, pixel);
    json_array_foreach(json_object_get(pixel, "trees"), i, tree) {
        fputc('\n', s->out);
        if (samples > 1 || json_is_integer(json_object_get(pixel, "sample")))
            fprintf(s->out, "sample %d\n", whole_of(tree, "sample"));
        print_ray(s, tree, "", "");
    }
    fputc('\n', s->out);
    json_array_foreach(json_object_get(pixel, "words"), i, line) fprintf(s->out, "%s\n", json_string_value(line));
}

char *feeler_pixel_text(const char *pixel_json, feeler_error *error) {
    json_t *pixel = json_loads(pixel_json, 0, NULL);
    char *text = NULL;
    size_t size;
    sheet s = {.indent = malloc(64), .size = 64};
    if (!json_is_array(json_object_get(pixel, "trees"))) {
        fail(error, FEELER_BAD_USAGE, "not the JSON of a pixel");
    } else if (!s.indent || !(s.out = open_memstream(&text, &size))) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    } else {
        print_pixel(&s, pixel);
        if (fclose(s.out) != 0) {
            fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
            free(text);
            text = NULL;
        } else if (size && text[size - 1] == '\n') {
            text[size - 1] = '\0'; /* who prints it ends the last line */
        }
    }
    json_decref(pixel);
    free(s.indent);
    return text;
}
