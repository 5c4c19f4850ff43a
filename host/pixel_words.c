/* pixel_words.c - why a pixel has its colour, in words: what it is made of or, where it is black, what each ray lacks. */
#include "pixel.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_LINES = 8 };

/* Below this a channel is 0 in 8 bits of sRGB. */
static const double darkest = 0.5 / 255 / 12.92;

int whole_of(const json_t *object, const char *key) {
    return (int)json_integer_value(json_object_get(object, key));
}

const char *text_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static double channel(const json_t *colour, size_t index) {
    return json_number_value(json_array_get(colour, index));
}

bool is_zero(const json_t *colour) {
    return channel(colour, 0) == 0 && channel(colour, 1) == 0 && channel(colour, 2) == 0;
}

void print_colour(FILE *out, const json_t *colour) {
    const double r = channel(colour, 0), g = channel(colour, 1), b = channel(colour, 2);
    if (r == g && g == b)
        fprintf(out, "%.4g", r);
    else
        fprintf(out, "%.4g %.4g %.4g", r, g, b);
}

void print_key(FILE *out, const char *key) {
    for (; *key; key++)
        fputc(*key == '_' ? ' ' : *key, out);
}

/* The file without its folder; a path of keys would repeat the object's number. */
static void print_place(FILE *out, const json_t *object) {
    const char *place = text_of(object, "place"), *slash = strrchr(place, '/');
    if (*place && strncmp(place, "objects[", 8) != 0)
        fprintf(out, " (%s)", slash ? slash + 1 : place);
}

static void print_one(FILE *out, const json_t *object, const char *list, bool with_place) {
    const json_t *triangle = json_object_get(object, "triangle");
    fprintf(out, "%s[%d] %s", list, whole_of(object, "number"), text_of(object, "shape"));
    if (triangle)
        fprintf(out, ", triangle %" JSON_INTEGER_FORMAT, json_integer_value(triangle));
    if (with_place)
        print_place(out, object);
}

void print_object(FILE *out, const json_t *hit, bool with_place) {
    const json_t *object = json_object_get(hit, "object"), *inside = json_object_get(object, "inside");
    print_one(out, object, "objects", with_place);
    if (inside) {
        fputs(" of ", out);
        print_one(out, inside, "", with_place);
    }
    fprintf(out, " '%s'", text_of(hit, "material"));
}

/* ---- what it is made of ---- */

static void print_ray(FILE *out, const char *kind, int level, bool first) {
    if (strcmp(kind, "eye") == 0)
        fprintf(out, "%s eye ray", first ? "the" : "by the");
    else
        fprintf(out, "%s %s ray of level %d", first ? "a" : "by a", kind, level);
}

static void print_part(FILE *out, const json_t *part) {
    const char *term = text_of(part, "term"), *kind = text_of(part, "ray");
    const json_t *light = json_object_get(part, "light");
    fprintf(out, "%5.1f %%  ", 100 * json_number_value(json_object_get(part, "share")));
    print_key(out, term);
    if (light)
        fprintf(out, " of lights[%d]", (int)json_integer_value(light));
    if (json_object_get(part, "object")) {
        fputs(" on ", out);
        print_object(out, part, false);
    }
    fputs(", ", out);
    print_ray(out, kind, whole_of(part, "level"), false);
}

/* ---- what is missing ---- */

/* Why a light adds nothing, by its code; what follows "lights[0] ". */
static const char *reason_of(const char *code) {
    static const char *const reasons[][2] = {
        {"black light", "black itself"},
        {"at the light", "at the point itself"},
        {"grazing", "grazing the surface, on neither of its sides"},
        {"behind", "behind the surface, where the material transmits no light"},
        {"total reflection", "behind the surface, which reflects totally"},
        {"outside the highlight", "outside the highlight, and there is no diffuse"},
        {"coefficients", "of no effect, for the material's coefficients are 0"},
        {"no common term", "of colours of which the material returns nothing"},
    };
    for (size_t i = 0; i < sizeof reasons / sizeof *reasons; i++)
        if (strcmp(code, reasons[i][0]) == 0)
            return reasons[i][1];
    return "where nothing is left of its highlight";
}

static bool is_blocked(const json_t *light) {
    return json_is_object(json_object_get(json_object_get(light, "feeler"), "blocked_by"));
}

static void print_reason(FILE *out, const json_t *light) {
    const json_t *feeler = json_object_get(light, "feeler");
    if (is_blocked(light)) {
        fputs("blocked by ", out);
        print_object(out, json_object_get(feeler, "blocked_by"), false);
    } else if (json_array_size(json_object_get(feeler, "crossed"))) {
        fputs("filtered, and nothing of it is left", out);
    } else {
        fputs(reason_of(text_of(light, "no_feeler")), out);
    }
}

/* The numbers of the lights that add nothing by each reason, as in "0,2,3". NULL: out of memory. */
static json_t *group_by_reason(const json_t *lights, bool only_blocked) {
    json_t *light, *groups = json_object();
    size_t i;
    json_array_foreach(lights, i, light) {
        char *reason = NULL;
        size_t size;
        if (!is_zero(json_object_get(light, "colour")) || (only_blocked && !is_blocked(light)))
            continue;
        FILE *out = open_memstream(&reason, &size);
        if (!out)
            break;
        print_reason(out, light);
        if (fclose(out) == 0) {
            const char *before = json_string_value(json_object_get(groups, reason));
            json_object_set_new(
                groups, reason,
                json_sprintf("%s%s%d", before ? before : "", before ? "," : "", whole_of(light, "light")));
        }
        free(reason);
    }
    return groups;
}

/* What separates a clause from what comes before it: the subject or another clause. */
static const char *comma(bool *some) {
    const char *mark = *some ? "; " : ": ";
    *some = true;
    return mark;
}

static void print_missing_lights(FILE *out, const json_t *ray, bool only_blocked, bool *some) {
    const char *reason;
    json_t *numbers, *groups = group_by_reason(json_object_get(json_object_get(ray, "local"), "lights"), only_blocked);
    json_object_foreach(groups, reason, numbers) {
        const char *list = json_string_value(numbers);
        fprintf(out, "%slights[%s] %s %s", comma(some), list, strchr(list, ',') ? "are" : "is", reason);
    }
    json_decref(groups);
}

/* What light there is, and what its weight leaves of it. */
static void print_rest(FILE *out, const json_t *ray, const json_t *light, bool *some) {
    if (is_zero(light))
        return;
    fprintf(out, "%sits light is ", comma(some));
    print_colour(out, light);
    fputs(", its weight ", out);
    print_colour(out, json_object_get(ray, "weight"));
    fputs(", so that it adds ", out);
    print_colour(out, json_object_get(ray, "adds"));
}

/* Why nothing more is sent on. */
static void print_unsent(FILE *out, const json_t *pixel, const json_t *ray, bool *some) {
    const char *ways[] = {"reflection", "transmission"};
    bool nothing = true;
    for (size_t i = 0; i < 2; i++) {
        const json_t *way = json_object_get(ray, ways[i]);
        const char *code = text_of(way, "unsent");
        nothing &= strcmp(code, "coefficients") == 0;
        if (strcmp(code, "depth") == 0)
            fprintf(out, "%sthe %s is beyond depth %d", comma(some), ways[i], whole_of(pixel, "depth"));
        else if (strcmp(code, "cutoff") == 0)
            fprintf(out, "%sthe %s weighs less than the cutoff", comma(some), ways[i]);
        else if (strcmp(code, "weight") == 0)
            fprintf(out, "%sthe %s weighs nothing", comma(some), ways[i]);
        else if (strcmp(code, "total reflection") == 0)
            fprintf(out, "%sit reflects totally", comma(some));
    }
    if (nothing)
        fprintf(out, "%sit neither reflects nor transmits", comma(some));
}

/* Of a ray that meets nothing. */
static void print_nothing(FILE *out, const json_t *pixel, const json_t *ray) {
    const json_t *seen = json_object_get(ray, "background");
    bool some = false;
    fputs(" meets nothing", out);
    if (is_zero(json_object_get(pixel, "background")))
        fputs(", and the background is black", out);
    else if (is_zero(seen))
        fputs(", and the background is left out", out);
    print_rest(out, ray, seen, &some);
}

/* A sentence on what one ray lacks. */
static void print_lack(FILE *out, const json_t *pixel, const json_t *ray) {
    const json_t *hit = json_object_get(ray, "hit"), *local = json_object_get(ray, "local");
    bool some = false;
    print_ray(out, text_of(ray, "kind"), whole_of(ray, "level"), true);
    if (!json_is_object(hit)) {
        print_nothing(out, pixel, ray);
        return;
    }
    fputs(" meets ", out);
    print_object(out, hit, false);
    print_rest(out, ray, json_object_get(local, "colour"), &some);
    if (is_zero(json_object_get(pixel, "ambient")))
        fprintf(out, "%sthere is no ambient light", comma(&some));
    else if (is_zero(json_object_get(local, "ambient")))
        fprintf(out, "%sit returns no ambient light", comma(&some));
    if (json_array_size(json_object_get(pixel, "lights")) == 0)
        fprintf(out, "%sthe scene has no lights", comma(&some));
    print_missing_lights(out, ray, false, &some);
    print_unsent(out, pixel, ray, &some);
}

/* Counts the sentence that was printed; takes the stream and its text. */
static void count_sentence(json_t *sentences, FILE *out, char **text) {
    if (fclose(out) == 0 && **text) {
        json_int_t before = json_integer_value(json_object_get(sentences, *text));
        json_object_set_new(sentences, *text, json_integer(before + 1));
    }
    free(*text);
    *text = NULL;
}

/* Of a black pixel what every ray lacks, else which lights the eye rays' hits lack. */
static void add_lacks(json_t *sentences, const json_t *pixel, const json_t *ray, bool black) {
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return;
    if (black) {
        print_lack(out, pixel, ray);
    } else if (json_is_object(json_object_get(ray, "hit"))) {
        char *lights = NULL;
        FILE *missing = open_memstream(&lights, &size);
        bool some = false;
        if (missing)
            print_missing_lights(missing, ray, true, &some);
        if (missing && fclose(missing) == 0 && some) {
            print_object(out, json_object_get(ray, "hit"), false);
            fputs(lights, out);
        }
        free(lights);
    }
    count_sentence(sentences, out, &text);
    for (int i = 0; i < 2 && black; i++) {
        const json_t *next = json_object_get(json_object_get(ray, i ? "transmission" : "reflection"), "ray");
        if (json_is_object(next))
            add_lacks(sentences, pixel, next, black);
    }
}

static void add_line(json_t *lines, const char *format, const char *text, json_int_t number) {
    json_array_append_new(lines, json_sprintf(format, text, number));
}

/* The sentences below a heading, and how many rays each is true of. */
static void add_sentences(json_t *lines, const char *heading, const json_t *sentences) {
    const char *text;
    json_t *count;
    size_t shown = 0, all = json_object_size(sentences);
    if (all)
        json_array_append_new(lines, json_string(heading));
    json_object_foreach((json_t *)sentences, text, count) {
        if (shown++ == MOST_LINES)
            break;
        if (json_integer_value(count) > 1)
            add_line(lines, "  %s (%" JSON_INTEGER_FORMAT " rays)", text, json_integer_value(count));
        else
            json_array_append_new(lines, json_sprintf("  %s", text));
    }
    if (all > MOST_LINES)
        json_array_append_new(lines, json_sprintf("  and %d more", (int)(all - MOST_LINES)));
}

static void add_parts(json_t *lines, const json_t *parts) {
    size_t i, all = json_array_size(parts);
    json_t *part;
    json_array_append_new(lines, json_string("made of"));
    json_array_foreach(parts, i, part) {
        char *text = NULL;
        size_t size;
        FILE *out = i < MOST_LINES ? open_memstream(&text, &size) : NULL;
        if (!out)
            break;
        print_part(out, part);
        if (fclose(out) == 0)
            json_array_append_new(lines, json_sprintf("  %s", text));
        free(text);
    }
    if (all > MOST_LINES)
        json_array_append_new(lines, json_sprintf("  and %d more", (int)(all - MOST_LINES)));
}

/* What more there might have been. */
static void add_unsent(json_t *lines, const json_t *pixel) {
    char *text = NULL;
    size_t size;
    const json_t *weight = json_object_get(pixel, "discarded_weight");
    FILE *out = is_zero(weight) ? NULL : open_memstream(&text, &size);
    if (!out)
        return;
    fputs("not sent, by depth or cutoff: rays that weigh ", out);
    print_colour(out, weight);
    fputs(" together", out);
    if (fclose(out) == 0)
        json_array_append_new(lines, json_string(text));
    free(text);
}

json_t *words_json(const json_t *pixel) {
    size_t i;
    json_t *one, *lines = json_array(), *sentences = json_object(), *parts = json_object_get(pixel, "made_of");
    double colour[3] = {0, 0, 0};
    json_array_foreach(parts, i, one) {
        for (size_t k = 0; k < 3; k++)
            colour[k] += channel(json_object_get(one, "colour"), k);
    }
    const bool black = colour[0] < darkest && colour[1] < darkest && colour[2] < darkest;
    json_array_foreach(json_object_get(pixel, "trees"), i, one) add_lacks(sentences, pixel, one, black);
    if (!black)
        add_parts(lines, parts);
    add_sentences(lines, black ? "black, because" : "in shadow", sentences);
    add_unsent(lines, pixel);
    json_decref(sentences);
    return lines;
}
