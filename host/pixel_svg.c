/* pixel_svg.c - the ray tree of a pixel as a drawing, from its JSON: a box for each ray, from the eye on the left. */
#include "pixel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    WIDTH_OF_BOX = 272,
    HEIGHT_OF_BOX = 104,
    STEP = 330,
    ROW = 116,
    MARGIN = 24,
    HEAD = 40,
    LINE = 16,
    LETTERS = 40
};

/* The drawing grows while it is written, so that its size is known last. */
typedef struct drawing {
    FILE *out;
    double y;  /* where the next leaf goes: the top of its box */
    int depth; /* greatest level so far */
} drawing;

/* Up to so many letters, with what XML asks for. */
static void print_escaped(FILE *out, const char *text, int letters) {
    for (; *text; text++) {
        const bool continues = ((unsigned char)*text & 0xc0) == 0x80;
        if (!continues && letters-- == 0) {
            fputs("…", out);
            return;
        }
        switch (*text) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        default:
            fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
        }
    }
}

static void print_text(FILE *out, double x, double y, const char *class, const char *text, int letters) {
    fprintf(out, "<text x='%g' y='%g' class='%s'>", x, y, class);
    print_escaped(out, text, letters);
    fputs("</text>\n", out);
}

/* What a function prints about a value, as a text. */
static void print_about(FILE *out, double x, double y, const char *class, const char *before, const json_t *value,
                        void (*print)(FILE *, const json_t *)) {
    char *text = NULL;
    size_t size;
    FILE *into = open_memstream(&text, &size);
    if (!into)
        return;
    fputs(before, into);
    print(into, value);
    if (fclose(into) == 0)
        print_text(out, x, y, class, text, LETTERS);
    free(text);
}

static void print_hit_object(FILE *out, const json_t *hit) {
    print_object(out, hit, false);
}

/* A channel in 8 bits of sRGB (IEC 61966-2-1). */
static int srgb(const json_t *colour, size_t index) {
    const double c = fmin(fmax(json_number_value(json_array_get(colour, index)), 0), 1);
    return (int)lrint(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055));
}

/* ---- a ray's box ---- */

/* One mark for each light: what its feeler met. */
static void print_lights(FILE *out, double x, double y, const json_t *lights) {
    size_t i;
    json_t *light;
    json_array_foreach(lights, i, light) {
        const json_t *feeler = json_object_get(light, "feeler"), *blocker = json_object_get(feeler, "blocked_by");
        const bool adds = !is_zero(json_object_get(light, "colour"));
        const char *class = json_is_object(blocker) ? "blocked" : adds ? "lit" : "unlit";
        if (i == 12) {
            print_text(out, x, y + 4, "small", "…", 1);
            return;
        }
        fprintf(out, "<circle cx='%g' cy='%g' r='7' class='%s'/><text x='%g' y='%g' class='mark %s'>%d</text>\n", x, y,
                class, x, y + 3.5, class, whole_of(light, "light"));
        x += 19;
    }
}

/* "not sent: reflection (depth), transmission (weight)" */
static void print_unsent(FILE *out, double x, double y, const json_t *ray) {
    static const char *const ways[] = {"reflection", "transmission"};
    char text[120] = "";
    for (size_t i = 0; i < 2; i++) {
        const char *code = text_of(json_object_get(ray, ways[i]), "unsent");
        const size_t used = strlen(text);
        if (*code && strcmp(code, "coefficients") != 0)
            snprintf(text + used, sizeof text - used, "%s%s (%s)", used ? ", " : "not sent: ", ways[i], code);
    }
    if (*text)
        print_text(out, x, y, "small", text, LETTERS + 6);
}

static void print_box(FILE *out, double x, double y, const json_t *ray) {
    const json_t *hit = json_object_get(ray, "hit"), *colour = json_object_get(ray, "colour");
    const bool met = json_is_object(hit);
    char title[80];
    fprintf(out, "<rect x='%g' y='%g' width='%d' height='%d' rx='5' class='%s%s'/>\n", x, y, WIDTH_OF_BOX,
            HEIGHT_OF_BOX, text_of(ray, "kind"), met ? "" : " missed");
    fprintf(out, "<rect x='%g' y='%g' width='20' height='%d' class='swatch' fill='rgb(%d,%d,%d)'/>\n", x + 6, y + 6,
            HEIGHT_OF_BOX - 12, srgb(colour, 0), srgb(colour, 1), srgb(colour, 2));
    x += 34;
    if (whole_of(ray, "level") == 1)
        snprintf(title, sizeof title, "eye ray %d, sample %d", whole_of(ray, "number"), whole_of(ray, "sample"));
    else
        snprintf(title, sizeof title, "%s ray %d", text_of(ray, "kind"), whole_of(ray, "number"));
    print_text(out, x, y + 17, "title", title, LETTERS);
    print_about(out, x, y + 33, "plain", "weight ", json_object_get(ray, "weight"), print_colour);
    if (!met) {
        print_text(out, x, y + 48, "plain", "meets nothing", LETTERS);
        print_about(out, x, y + 63, "plain", "background ", json_object_get(ray, "background"), print_colour);
        return;
    }
    const json_t *local = json_object_get(ray, "local");
    print_about(out, x, y + 48, "plain", "", hit, print_hit_object);
    print_about(out, x, y + 63, "plain", "I_local ", json_object_get(local, "colour"), print_colour);
    print_unsent(out, x, y + 78, ray);
    print_lights(out, x + 7, y + HEIGHT_OF_BOX - 12, json_object_get(local, "lights"));
}

/* ---- the tree ---- */

static void print_edge(FILE *out, double x, double y, const json_t *way, double to) {
    const double from = x + WIDTH_OF_BOX, end = x + STEP, middle = (from + end) / 2;
    fprintf(out, "<path d='M%g %gC%g %g %g %g %g %g' class='edge %s'/>\n", from, y, middle, y, middle, to, end, to,
            text_of(json_object_get(way, "ray"), "kind"));
}

/* Draws what a ray sends, then itself at their middle; returns the height of its own middle. */
static double draw_ray(drawing *d, const json_t *ray, int level) {
    static const char *const ways[] = {"reflection", "transmission"};
    const double x = MARGIN + (level - 1.0) * STEP;
    double middles[2], sum = 0;
    int count = 0;
    if (level > d->depth)
        d->depth = level;
    for (size_t i = 0; i < 2; i++) {
        const json_t *next = json_object_get(json_object_get(ray, ways[i]), "ray");
        middles[i] = json_is_object(next) ? draw_ray(d, next, level + 1) : -1;
        sum += fmax(middles[i], 0);
        count += middles[i] >= 0;
    }
    double y = count ? sum / count : d->y + HEIGHT_OF_BOX / 2.0;
    if (!count)
        d->y += ROW;
    for (size_t i = 0; i < 2; i++)
        if (middles[i] >= 0)
            print_edge(d->out, x, y, json_object_get(ray, ways[i]), middles[i]);
    print_box(d->out, x, y - HEIGHT_OF_BOX / 2.0, ray);
    return y;
}

/* What colours and marks mean. */
static void draw_key(drawing *d) {
    static const struct {
        const char *class, *text;
    } marks[] = {
        {"lit", "light arrives"}, {"blocked", "its feeler is blocked"}, {"unlit", "no feeler, or nothing left"}};
    double x = MARGIN + 7, y = d->y + 10;
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++) {
        fprintf(d->out, "<circle cx='%g' cy='%g' r='7' class='%s'/>\n", x, y, marks[i].class);
        print_text(d->out, x + 13, y + 4, "small", marks[i].text, LETTERS);
        x += 30 + 7 * (double)strlen(marks[i].text);
    }
    d->y = y + 16;
}

/* A line of words; what has no room on it goes on below. */
static void draw_words(drawing *d, const char *line) {
    enum { ROOM = 140 }; /* letters */
    double x = MARGIN + (*line == ' ' ? 12 : 0);
    for (line += strspn(line, " "); *line; line += strspn(line, " "), x = MARGIN + 24) {
        size_t length = strlen(line);
        if (length > ROOM)
            for (length = ROOM; length > 1 && line[length] != ' ';)
                length--;
        if (length == 1) /* a word that is longer than a line */
            length = strcspn(line, " ");
        char *piece = strndup(line, length);
        if (!piece)
            return;
        d->y += LINE;
        print_text(d->out, x, d->y, "plain", piece, ROOM);
        free(piece);
        line += length;
    }
}

/* The tree stands in a group of its own, moved down by the heading. */
static void draw_pixel(drawing *d, const json_t *pixel) {
    size_t i;
    json_t *one;
    json_array_foreach(json_object_get(pixel, "trees"), i, one) draw_ray(d, one, 1);
    draw_key(d);
    json_array_foreach(json_object_get(pixel, "words"), i, one) draw_words(d, json_string_value(one));
}

static const char style[] =
    "<style>text{font-family:'DejaVu Sans',Verdana,sans-serif;font-size:11px;fill:#111}"
    ".title{font-weight:bold;font-size:12px}.head{font-size:14px}.small{font-size:10px;fill:#444}"
    ".mark{text-anchor:middle;font-size:9px}text.blocked{fill:#fff}"
    "rect{stroke-width:1.5}rect.eye{fill:#f2f2f2;stroke:#444}rect.reflection{fill:#e8f0fb;stroke:#2a62b8}"
    "rect.transmission{fill:#e9f6ec;stroke:#22803c}rect.missed{stroke-dasharray:5 "
    "3}.swatch{stroke:#777;stroke-width:.7}"
    "circle{stroke:#444}circle.lit{fill:#ffe066}circle.blocked{fill:#333}circle.unlit{fill:#fff;stroke-dasharray:2 2}"
    ".edge{fill:none;stroke-width:1.8}.edge.reflection{stroke:#2a62b8}.edge.transmission{stroke:#22803c}</style>\n";

static void print_drawing(FILE *out, const json_t *pixel, const drawing *d, const char *body) {
    const json_t *at = json_object_get(pixel, "pixel"), *colour = json_object_get(pixel, "colour");
    const int x = (int)json_integer_value(json_array_get(at, 0)), y = (int)json_integer_value(json_array_get(at, 1));
    const double width = fmax(2 * MARGIN + (d->depth - 1.0) * STEP + WIDTH_OF_BOX, 960), height = HEAD + d->y + MARGIN;
    fprintf(out, "<svg xmlns='http://www.w3.org/2000/svg' width='%g' height='%g' viewBox='0 0 %g %g'>\n", width, height,
            width, height);
    fprintf(out, "%s<rect width='100%%' height='100%%' fill='#fff'/>\n", style);
    fprintf(out, "<rect x='%d' y='12' width='20' height='20' class='swatch' fill='rgb(%d,%d,%d)'/>\n", MARGIN,
            srgb(colour, 0), srgb(colour, 1), srgb(colour, 2));
    fprintf(out, "<text x='%d' y='27' class='head'>pixel %d,%d of ", MARGIN + 28, x, y);
    print_escaped(out, text_of(pixel, "scene"), 80);
    fputs(": colour ", out);
    print_colour(out, colour);
    fprintf(out, "</text>\n<g transform='translate(0,%d)'>\n%s</g>\n</svg>", HEAD, body);
}

/* With a body that was drawn the whole can be printed. NULL: out of memory. */
static char *draw(const json_t *pixel) {
    char *body = NULL, *text = NULL;
    size_t size;
    drawing d = {.out = open_memstream(&body, &size), .depth = 1};
    if (!d.out)
        return NULL;
    draw_pixel(&d, pixel);
    FILE *out = fclose(d.out) == 0 ? open_memstream(&text, &size) : NULL;
    if (out)
        print_drawing(out, pixel, &d, body);
    if (out && fclose(out) != 0) {
        free(text);
        text = NULL;
    }
    free(body);
    return text;
}

char *feeler_pixel_svg(const char *pixel_json, feeler_error *error) {
    json_t *pixel = json_loads(pixel_json, 0, NULL);
    char *text = NULL;
    if (!json_is_array(json_object_get(pixel, "trees")))
        fail(error, FEELER_BAD_USAGE, "not the JSON of a pixel");
    else if (!(text = draw(pixel)))
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
    json_decref(pixel);
    return text;
}
