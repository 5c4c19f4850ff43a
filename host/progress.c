/* progress.c - the line that shows how far a render is, and Ctrl-C. */
#include "progress.h"
#include "clock.h"

#include "cmd.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* ---- signals ---- */

static volatile sig_atomic_t interruptions;

static void on_signal(int signal_number) {
    (void)signal_number;
    if (interruptions++)
        _exit(EXIT_INTERRUPTED);
}

void progress_catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART; /* writing a file must not fail halfway with EINTR */
    sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
}

bool progress_interrupted(void) {
    return interruptions != 0;
}

/* ---- the line ---- */

void progress_begin(progress *p, const char *name, bool shown) {
    *p = (progress){.name = name, .shown = shown && report_on_terminal(), .start = seconds_now()};
    p->last = p->start;
}

static void draw(const progress *p, double fraction, double now) {
    enum { WIDTH = 24 };
    char bar[WIDTH + 1], eta[32] = "";
    int filled = (int)(fraction * WIDTH);
    memset(bar, '-', WIDTH);
    memset(bar, '#', (size_t)filled);
    bar[WIDTH] = '\0';
    /* The first launches say little about the rest. */
    double elapsed = now - p->start;
    if (fraction > 0.005 && elapsed > 0.3) {
        double left = elapsed / fraction * (1 - fraction);
        long seconds = left < 3.6e6 ? (long)(left + 0.5) : 3600000;
        if (seconds >= 3600)
            snprintf(eta, sizeof eta, "  ETA %ld:%02ld:%02ld", seconds / 3600, seconds / 60 % 60, seconds % 60);
        else
            snprintf(eta, sizeof eta, "  ETA %ld:%02ld", seconds / 60, seconds % 60);
    }
    fprintf(stderr, "\r%.40s [%s] %3d %%%s\033[K", p->name, bar, (int)(100 * fraction), eta);
    fflush(stderr);
}

int progress_step(void *user, double fraction) {
    progress *p = user;
    double now = seconds_now();
    if (fraction < 0)
        fraction = 0;
    if (fraction > 1)
        fraction = 1;
    if (p->shown && now - p->last >= 0.1) {
        p->last = now;
        p->drawn = true;
        draw(p, fraction, now);
    }
    if (progress_interrupted())
        return 1;
    p->under_way = p->under_way || fraction > 0;
    return 0;
}

void progress_end(progress *p) {
    if (p->drawn)
        fputs("\r\033[K", stderr);
    p->drawn = false;
}
