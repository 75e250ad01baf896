/* Windows, which has no fork: a UMAT of others is not run, and a check of one neither. The first call says so in place of
 * a path; the others are never reached. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "umat_worker.h"

void umat_worker_start(void (*work)(void *), void *data, double limit) { (void)work, (void)data, (void)limit; }
int umat_worker_receive(double *numbers, int n) { return (void)numbers, (void)n, 0; }
void umat_worker_end(double *notes, int n, char *text, char *reason, int length) {
  memset(notes, 0, (size_t)n * sizeof *notes);
  text[0] = '\0';
  snprintf(reason, (size_t)length, "&umat and --check on Windows: expected Linux, where each runs in a forked process");
}

void umat_worker_send(const double *numbers, int n) { (void)numbers, (void)n, abort(); }
void umat_worker_note(const double *numbers, int n, const char *text) { (void)numbers, (void)n, (void)text, abort(); }
void umat_worker_begin(int step, int increment) { (void)step, (void)increment, abort(); }
void umat_worker_end_copies(void) { abort(); }
_Noreturn void umat_worker_fail(const char *reason) { (void)reason, abort(); }
void umat_open(void) { abort(); }
void umat_call(void) { abort(); }
void umat_threads(void (*work)(int, void *), void *data) { (void)work, (void)data, abort(); }

/* The Fortran side asks for the whole path of a library by the name that POSIX gives. */
char *realpath(const char *path, char *whole) { return _fullpath(whole, path, _MAX_PATH); }
