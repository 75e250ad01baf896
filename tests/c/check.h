/* Checks and their count. A test is a function that returns the number of its failed checks. */
#ifndef CHECK_H
#define CHECK_H

#include <math.h>
#include <stdio.h>

/* STATEV counts from 0 (docs/reference/contract.md): sizes, index of the status, index of the first offset. */
enum { POINT_STATEV = 8, PLANE_STATEV = 3, STATUS = 4, OFFSET = 5 };

/* The value is 1, with a line on standard error, if the condition is false. */
#define FAILS(condition)                                                                           \
  ((condition) ? 0 : (fprintf(stderr, "%s:%d: expected %s\n", __FILE__, __LINE__, #condition), 1))

/* The value is 1, with both values on standard error, unless |value - expected| <= tolerance (also 1 for NaN). */
#define DIFFERS(expected, value, tolerance) check_differs(__FILE__, __LINE__, #value, expected, value, tolerance)

static inline int check_differs(const char *file, int line, const char *name, double expected, double value,
                                double tolerance) {
  if (fabs(value - expected) <= tolerance) return 0;
  fprintf(stderr, "%s:%d: %s = %.17g, expected %.17g +- %.1g\n", file, line, name, value, expected, tolerance);
  return 1;
}

/* Run the tests and print the closing line. The result is the exit status of main. */
static inline int check_run(int count, int (*const tests[])(void)) {
  int failed = 0;
  for (int i = 0; i < count; i++) failed += tests[i]() != 0;
  printf("%d passed, %d failed\n", count - failed, failed);
  return failed != 0;
}

#endif
