/* cmd_bench_child.c - a render in a process of its own: a driver that crashes ends the child and not the sweep. */
#include "cmd_bench.h"

#include "clock.h"
#include "progress.h"

#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- in the child ---- */

/* FNV-1a. */
static uint64_t hash_pixels(const feeler_image *image) {
    size_t number = feeler_image_is_double(image) ? sizeof(double) : sizeof(float);
    size_t size = (size_t)feeler_image_width(image) * (size_t)feeler_image_height(image) * 4 * number;
    const unsigned char *bytes = feeler_image_pixels(image);
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static json_t *describe_render(const feeler_scene *scene, const feeler_settings *settings, feeler_device *device,
                               feeler_error *error) {
    char hash[17];
    feeler_image *image = feeler_render(scene, settings, device, NULL, NULL, error);
    const char *stats = image ? feeler_image_stats_json(image, error) : NULL;
    json_t *reply = NULL;
    if (stats) {
        snprintf(hash, sizeof hash, "%016" PRIx64, hash_pixels(image));
        reply = json_pack("{s:o, s:s}", "stats", json_loads(stats, 0, NULL), "pixels", hash);
    }
    feeler_image_free(image);
    return reply;
}

static json_t *describe_error(const feeler_error *error) {
    char text[sizeof error->source + sizeof error->text + 64];
    feeler_error_format(error, text, sizeof text);
    return json_pack("{s:{s:i, s:s, s:b}}", "error", "code", error->code, "text", text, "build", error->log[0] != '\0');
}

static int send_line(int socket, const json_t *reply) {
    char *text = reply ? json_dumps(reply, JSON_COMPACT | JSON_REAL_PRECISION(15)) : NULL;
    bool sent = text && dprintf(socket, "%s\n", text) > 0;
    free(text);
    return sent ? 0 : -1;
}

/* Renders for every byte that comes, until the parent has gone. */
static void serve(const feeler_scene *scene, const feeler_settings *settings, const char *select, int socket) {
    feeler_error error = {0};
    feeler_device *device = NULL;
    char request;
    while (read(socket, &request, 1) == 1) {
        json_t *reply = NULL;
        if (!device)
            device = feeler_device_open(select, &error);
        if (device)
            reply = describe_render(scene, settings, device, &error);
        if (!reply)
            reply = describe_error(&error);
        if (send_line(socket, reply))
            break;
        json_decref(reply);
    }
}

static _Noreturn void be_child(const feeler_scene *scene, const feeler_settings *settings, const char *select,
                               int socket) {
    const struct rlimit no_core = {0, 0};
    (void)setrlimit(RLIMIT_CORE, &no_core);
    /* Ctrl-C reaches the whole group of processes; the parent decides. */
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGTERM, SIG_DFL);
    (void)dup2(STDERR_FILENO, STDOUT_FILENO); /* what a driver prints is no result */
    serve(scene, settings, select, socket);
    _exit(EXIT_DONE);
}

/* ---- in the parent ---- */

int child_start(child *c, const feeler_scene *scene, const feeler_settings *settings, const char *select,
                double timeout_seconds, const child *others, int other_count) {
    int sockets[2];
    *c = (child){.limit = timeout_seconds, .left = timeout_seconds};
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets)) {
        report_failure("cannot start a process: %s", strerror(errno));
        return -1;
    }
    fflush(NULL); /* or the child would print what waits, too */
    c->pid = fork();
    if (c->pid == 0) {
        for (int i = 0; i < other_count; i++)
            if (others[i].pid)
                close(others[i].socket);
        close(sockets[0]);
        be_child(scene, settings, select, sockets[1]);
    }
    close(sockets[1]);
    c->socket = sockets[0];
    if (c->pid > 0)
        return 0;
    report_failure("cannot start a process: %s", strerror(errno));
    close(c->socket);
    c->pid = 0;
    return -1;
}

/* Ends it if it lives and returns what became of it. */
static int reap(child *c, bool alive) {
    int status = 0;
    if (alive)
        (void)kill(c->pid, SIGKILL);
    close(c->socket);
    while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR)
        ;
    c->pid = 0;
    return status;
}

void child_end(child *c) {
    if (c->pid)
        (void)reap(c, true);
}

static void tell_death(run *r, int status) {
    if (WIFSIGNALED(status))
        snprintf(r->detail, sizeof r->detail, "crashed: signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
    else
        snprintf(r->detail, sizeof r->detail, "ended by itself with code %d", WEXITSTATUS(status));
}

typedef enum arrival { ARRIVED, TOO_LATE, ENDED, INTERRUPTED } arrival;

static arrival wait_for(const child *c, double end) {
    for (;;) {
        struct pollfd wait = {.fd = c->socket, .events = POLLIN};
        double left = end - seconds_now();
        if (progress_interrupted())
            return INTERRUPTED;
        if (left <= 0)
            return TOO_LATE;
        int ready = poll(&wait, 1, left < 1e6 ? (int)(1000 * left) + 1 : 1000000000);
        if (ready > 0)
            return ARRIVED;
        if (ready < 0 && errno != EINTR)
            return ENDED;
    }
}

/* Reads one line, which is all that is sent, within the child's time. */
static arrival read_line(child *c, char *text, size_t size) {
    size_t used = 0;
    const double end = seconds_now() + c->left;
    do {
        arrival waited = wait_for(c, end);
        if (waited != ARRIVED)
            return waited;
        ssize_t got = read(c->socket, text + used, size - used);
        if (got <= 0)
            return ENDED;
        used += (size_t)got;
    } while (text[used - 1] != '\n' && used < size);
    c->left = end - seconds_now();
    text[used - 1] = '\0';
    return ARRIVED;
}

json_t *child_render(child *c, run *r) {
    char text[32768];
    arrival arrival = ENDED;
    if (send(c->socket, "", 1, MSG_NOSIGNAL) == 1)
        arrival = read_line(c, text, sizeof text);
    json_t *reply = arrival == ARRIVED ? json_loads(text, 0, NULL) : NULL;
    if (reply)
        return reply;
    int status = reap(c, arrival != ENDED);
    r->verdict = arrival == TOO_LATE ? VERDICT_TIMEOUT : VERDICT_RUNTIME;
    if (arrival == ENDED)
        tell_death(r, status);
    else if (arrival == TOO_LATE)
        snprintf(r->detail, sizeof r->detail, "time limit: took more than %g s", c->limit);
    else
        snprintf(r->detail, sizeof r->detail, arrival == ARRIVED ? "its answer cannot be read" : "interrupted");
    return NULL;
}
