/* Resident memory over many calls of the UMAT and the C API, rejected calls among them: memory [CALLS].
 *
 * The peak must not grow after the first calls. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "asperity.h"

enum { ENOUGH = 64 };
static const double rp_4[] = {3.0, 0.3, 0.9, 0.5, 30.0, 4.0};

/* Calls before the first measurement of the memory, and calls from one rejected call to the next. */
static const long warm_up = 1000, rarely = 10;

/* Growth allowed, kB: a leak of 3 bytes a call at 100000 calls, of 26 bytes a rejected call. */
#ifdef __SANITIZE_ADDRESS__
static const long allowed = 300000; /* the sanitizer delays the release of freed memory, and finds leaks itself */
#else
static const long allowed = 256;
#endif

static long resident_kilobytes(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

static void umat_call(int nstatv, double *state, double *stress, const double *strain, const double *increment) {
  double tangent[9], sse, spd, scd;
  const int ndi = 1, nshr = 2, ntens = 3, nprops = 6;
  umat_(stress, state, tangent, &sse, &spd, &scd, NULL, NULL, NULL, NULL, strain, increment, NULL, NULL, NULL, NULL,
        NULL, NULL, "A", &ndi, &nshr, &ntens, &nstatv, rp_4, &nprops, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL,
        NULL, NULL, NULL, NULL);
}

int main(int argc, char **argv) {
  const long calls = argc > 1 ? atol(argv[1]) : 1000000;
  const double bad[] = {-3.0, 0.3, 0.9, 0.5, 30.0, 4.0}, zero[3] = {0};
  double state[ENOUGH] = {0}, s[3] = {0.01, 0.02, 0.0}, stress[3] = {0}, traction[3];
  const int nstatv = asperity_nstatv(rp_4, 6, NULL, 0);
  char message[256];
  long before = 0, rejected = 0;
  if (calls < 1) {
    fprintf(stderr, "memory: CALLS = %s: expected a whole number >= 1\n", argv[1]);
    return 1;
  }
  if (nstatv < 1 || nstatv > ENOUGH) {
    printf("memory: nstatv = %d: expected 1 to %d\n", nstatv, ENOUGH);
    return 1;
  }
  for (long i = 0; i < warm_up + calls; i++) {
    if (i == warm_up) before = resident_kilobytes();
    s[1] = 1e-4 * (double)(i % 1000);
    umat_call(nstatv, state, stress, zero, s);
    asperity_update(rp_4, 6, 0.0, 1, NULL, s, nstatv, state, traction, NULL, NULL, 0);
    if (i % rarely > 0) continue;
    int status = asperity_update(bad, 6, 0.0, 1, NULL, s, nstatv, state, traction, NULL, message, sizeof message);
    rejected += status != ASPERITY_OK;
  }
  const long growth = resident_kilobytes() - before;
  printf("memory: %ld calls of each entry, %ld rejected calls: %ld kB more, allowed %ld\n", calls, rejected, growth,
         allowed);
  const int failed = growth > allowed || rejected * rarely < calls;
  printf("%d passed, %d failed\n", 1 - failed, failed);
  return failed;
}
