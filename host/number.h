/* number.h - numbers as text, the same in every locale. */
#ifndef FEELER_NUMBER_H
#define FEELER_NUMBER_H

typedef enum number_result { NUMBER_OK, NUMBER_MALFORMED, NUMBER_NOT_FINITE } number_result;

/* Reads the whole of `text` as a decimal number: [+-] digits [. digits] [e [+-] digits], at least one digit before the
 * exponent, nothing before or after. Correctly rounded; one too small for a double becomes the nearest, 0 among them. On
 * failure `value` is untouched. NUMBER_NOT_FINITE: too large for a double, or a spelling of infinity or not-a-number. */
number_result number_read(const char *text, double *value);
/* The same without the value, which takes most of the time. */
number_result number_check(const char *text);

#endif
