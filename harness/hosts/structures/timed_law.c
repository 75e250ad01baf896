/* Library between a host and the law, which measures the time that the law takes.
 *
 * It is linked with the library that the host would load: libasperity_kratos.so (UMAT) or libasperity_generic.so, whose
 * other symbols a host still finds. structure_study.py compiles it. At the end of the process it prints the time, for
 * hosts that run as a program. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <time.h>

static double seconds;
static long calls;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Time of the law since the last call of this function. */
double law_seconds(void) {
  const double found = seconds;
  seconds = 0.0;
  calls = 0;
  return found;
}

static __attribute__((destructor)) void print(void) {
  if (calls > 0) printf("law: %.6f s in %ld calls\n", seconds, calls);
}

#ifdef HOST_UMAT
typedef void umat_type(void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *,
                       void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *,
                       void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *, void *,
                       void *);

void umat_(void *a, void *b, void *c, void *d, void *e, void *f, void *g, void *h, void *i, void *j, void *k, void *l,
           void *m, void *n, void *o, void *p, void *q, void *r, void *s, void *t, void *u, void *v, void *w, void *x,
           void *y, void *z, void *a2, void *b2, void *c2, void *d2, void *e2, void *f2, void *g2, void *h2, void *i2,
           void *j2, void *k2) {
  static umat_type *law;
  if (law == NULL) *(void **)&law = dlsym(RTLD_NEXT, "umat_");
  const double start = now();
  law(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, x, y, z, a2, b2, c2, d2, e2, f2, g2, h2, i2,
      j2, k2);
  seconds += now() - start;
  calls++;
}
#else
/* Behaviours of the layer in three dimensions. */
#define BEHAVIOUR(n)                                                                       \
  int AsperityLayer##n##_Tridimensional(void *data) {                                      \
    static int (*law)(void *);                                                             \
    if (law == NULL) *(void **)&law = dlsym(RTLD_NEXT, "AsperityLayer" #n "_Tridimensional"); \
    const double start = now();                                                            \
    const int status = law(data);                                                          \
    seconds += now() - start;                                                              \
    calls++;                                                                               \
    return status;                                                                         \
  }
BEHAVIOUR(1) BEHAVIOUR(3) BEHAVIOUR(4) BEHAVIOUR(5) BEHAVIOUR(6) BEHAVIOUR(7) BEHAVIOUR(8) BEHAVIOUR(9)
BEHAVIOUR(10) BEHAVIOUR(11) BEHAVIOUR(12) BEHAVIOUR(13) BEHAVIOUR(14) BEHAVIOUR(15) BEHAVIOUR(16) BEHAVIOUR(17)
BEHAVIOUR(18) BEHAVIOUR(19) BEHAVIOUR(20) BEHAVIOUR(21) BEHAVIOUR(22) BEHAVIOUR(23) BEHAVIOUR(24) BEHAVIOUR(25)
BEHAVIOUR(26) BEHAVIOUR(27) BEHAVIOUR(28) BEHAVIOUR(29) BEHAVIOUR(30) BEHAVIOUR(31) BEHAVIOUR(32) BEHAVIOUR(33)
#endif
