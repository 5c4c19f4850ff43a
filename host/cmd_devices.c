/* cmd_devices.c - feeler devices: what could render here. */
#include "cmd.h"
#include "options.h"

#include <stdio.h>

static void print_device(const json_t *device) {
    const char *name = "", *type = "", *version = "", *driver = "";
    json_int_t index = 0, memory = 0, group = 0;
    int chosen = 0, units = 0, clock = 0, has_double = 0;
    (void)json_unpack((json_t *)device, "{s:I, s:s, s:s, s:b, s:i, s:i, s:I, s:I, s:b, s:s, s:s}", "index", &index,
                      "name", &name, "type", &type, "default", &chosen, "compute_units", &units, "clock_mhz", &clock,
                      "memory_bytes", &memory, "max_work_group", &group, "double", &has_double, "version", &version,
                      "driver", &driver);
    printf("%s %2" JSON_INTEGER_FORMAT "  %s\n", chosen ? "*" : " ", index, name);
    printf("      %s, %d compute units, %d MHz, %.1f GiB, work groups up to %" JSON_INTEGER_FORMAT ", %s\n", type,
           units, clock, (double)memory / 1073741824.0, group, has_double ? "double" : "no double");
    printf("      %s, driver %s\n", version, driver);
}

static void print_platforms(const json_t *platforms) {
    size_t i, k;
    json_t *platform, *device;
    json_array_foreach(platforms, i, platform) {
        const char *name = "", *version = "";
        json_t *devices = NULL;
        (void)json_unpack(platform, "{s:s, s:s, s:o}", "name", &name, "version", &version, "devices", &devices);
        printf("%s (%s)\n", name, version);
        json_array_foreach(devices, k, device) print_device(device);
    }
    puts("\n* is the default. Choose another with --device, by its number or a part of its name.");
}

int cmd_devices(int argc, char **argv) {
    bool as_json = false;
    int count;
    const option options[] = {{"json", 0, OPTION_FLAG, &as_json, NULL, NULL, "as JSON", 0, 0}, {0}};
    const command devices = {"devices", "", "Lists OpenCL platforms and devices.", options, 0, 0, NULL};
    options_result parsed = options_parse(&devices, argc, argv, &count);
    if (parsed != OPTIONS_GO)
        return parsed == OPTIONS_HELPED ? EXIT_DONE : EXIT_USAGE;

    feeler_error error = {0};
    char *text = feeler_devices_json(&error);
    if (!text)
        return report_error(&error);
    if (as_json)
        return report_json(text);
    json_t *root = json_loads(text, 0, NULL);
    feeler_free(text);
    if (!root) {
        report_failure("out of memory");
        return EXIT_FAILED;
    }
    print_platforms(json_object_get(root, "platforms"));
    json_decref(root);
    return EXIT_DONE;
}
