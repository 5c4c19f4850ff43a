/* clock.h */
#ifndef FEELER_CLOCK_H
#define FEELER_CLOCK_H

/* Seconds since some moment; never goes back. */
double seconds_now(void);

#endif
