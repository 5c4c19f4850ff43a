/* number.c - see number.h. strtod alone would take hexadecimal, "nan" and a decimal comma where the locale has one. */
#include "number.h"

#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* What the text spells: mantissa * 10^exponent, exact while `digits` (leading zeros aside) stays within 19. */
typedef struct decimal {
    bool negative;
    uint64_t mantissa;
    int digits;
    int exponent;
} decimal;

static const char *read_digits(const char *at, decimal *number, int shift) {
    for (; *at >= '0' && *at <= '9'; at++) {
        if (number->mantissa || *at != '0')
            number->digits++;
        if (number->digits <= 19)
            number->mantissa = number->mantissa * 10 + (uint64_t)(*at - '0');
        number->exponent += shift;
    }
    return at;
}

/* Past "e-12", or `at` itself where there is no exponent; NULL where it has no digits. */
static const char *read_exponent(const char *at, decimal *number) {
    if (*at != 'e' && *at != 'E')
        return at;
    at++;
    bool negative = *at == '-';
    if (*at == '-' || *at == '+')
        at++;
    if (*at < '0' || *at > '9')
        return NULL;
    int value = 0;
    for (; *at >= '0' && *at <= '9'; at++)
        value = value < 100000 ? value * 10 + (*at - '0') : value;
    number->exponent += negative ? -value : value;
    return at;
}

static bool read_decimal(const char *text, decimal *number) {
    *number = (decimal){.negative = *text == '-'};
    const char *start = *text == '-' || *text == '+' ? text + 1 : text;
    const char *end = read_digits(start, number, 0);
    long count = end - start;
    if (*end == '.') {
        const char *fraction = end + 1;
        end = read_digits(fraction, number, -1);
        count += end - fraction;
    }
    if (count == 0)
        return false;
    end = read_exponent(end, number);
    return end && *end == '\0';
}

static bool spells_not_finite(const char *text) {
    static const char *const names[] = {"nan", ".nan", "inf", ".inf", "infinity"};
    if (*text == '-' || *text == '+')
        text++;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcasecmp(text, names[i]) == 0)
            return true;
    return false;
}

/* strtod with a decimal point, whatever the thread's locale. NaN when out of memory. */
static double strtod_c(const char *text) {
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return NAN;
    locale_t before = uselocale(plain);
    double value = strtod(text, NULL);
    uselocale(before);
    freelocale(plain);
    return value;
}

number_result number_check(const char *text) {
    decimal number;
    double value;
    if (read_decimal(text, &number) && number.digits + (long)number.exponent <= 308) /* below 10^308 */
        return NUMBER_OK;
    return number_read(text, &value);
}

number_result number_read(const char *text, double *value) {
    static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    decimal number;
    if (!read_decimal(text, &number))
        return spells_not_finite(text) ? NUMBER_NOT_FINITE : NUMBER_MALFORMED;
    double result;
    if (number.digits <= 19 && number.mantissa <= (UINT64_C(1) << 53) && abs(number.exponent) <= 22) {
        /* Both factors are exact in double, so that one operation rounds once (Clinger 1990, "How to read floating point
         * numbers accurately"). */
        double mantissa = (double)number.mantissa;
        result = number.exponent < 0 ? mantissa / powers[-number.exponent] : mantissa * powers[number.exponent];
        result = number.negative ? -result : result;
    } else {
        result = strtod_c(text);
    }
    if (!isfinite(result))
        return NUMBER_NOT_FINITE;
    *value = result;
    return NUMBER_OK;
}
