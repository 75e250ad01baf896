/* Comparison of eight threads with one thread, to the last bit: threads [POINTS]. It calls UMAT, VUMAT and C API
 * with viscous damage and requests for smaller increments, the C API also from initial tractions and with bad states.
 *
 * Each round applies random increments to at most ROUND points, first by one thread, then by all threads. */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "asperity.h"

enum { THREADS = 8, ROUND = 40000, STEPS = 3, NSTATV = 8 + 3 * 5, NPROPS = 14, ENTRIES = 4, BLOCK = 137 };
/* Table 2 of the paper, RP-4, 30 degrees, turned; tau_v = 0.5, dalpha = 0.05 */
static const double props[NPROPS] = {3.0, 0.3, 0.9, 0.5, 30.0, 4.0, 1.0 / 3.0, 10.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.05};
static const double dt = 0.1;
static const char *const names[ENTRIES] = {"umat", "vumat", "asperity_update", "rejected calls"};

/* Results of every point of a round; the stress of a VUMAT has its own order of components. */
typedef struct {
  double state[NSTATV][ROUND]; /* in the order of a VUMAT */
  double rows[ROUND][NSTATV];  /* in the order of a UMAT */
  double stress[ROUND][3], tangent[ROUND][9], pnewdt[ROUND];
  char message[ROUND][64];
} result_type;

static double strain[STEPS][ROUND][3];
static result_type serial, parallel;

/* A task: points first..last - 1 by one of the entries. */
typedef struct {
  int entry, first, last;
  result_type *out;
} work_type;

/* xorshift64: a number from -1 to 1. */
static double draw(uint64_t *x) {
  *x ^= *x << 13;
  *x ^= *x >> 7;
  *x ^= *x << 17;
  return (double)(*x >> 11) * 0x1p-52 - 1.0;
}

static void by_umat(int p, result_type *out) {
  double from[3] = {0}, sse, spd, scd;
  const int ndi = 1, nshr = 2, ntens = 3, nstatv = NSTATV, nprops = NPROPS;
  memset(out->rows[p], 0, sizeof out->rows[p]);
  for (int step = 0; step < STEPS; step++) {
    out->pnewdt[p] = 1.0;
    umat_(out->stress[p], out->rows[p], out->tangent[p], &sse, &spd, &scd, NULL, NULL, NULL, NULL, from,
          strain[step][p], NULL, &dt, NULL, NULL, NULL, NULL, "A", &ndi, &nshr, &ntens, &nstatv, props, &nprops, NULL,
          NULL, &out->pnewdt[p], NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL);
    for (int i = 0; i < 3; i++) from[i] += strain[step][p][i];
  }
}

static void by_vumat(int first, int last, result_type *out) {
  const double zero[9 * BLOCK] = {0};
  const int nblock = last - first, ndir = 1, nshr = 2, nstatev = NSTATV, nfieldv = 0, nprops = NPROPS, lanneal = 0;
  const double total = 1.0;
  double state_old[NSTATV * BLOCK] = {0}, state_new[NSTATV * BLOCK], inc[3 * BLOCK], s_new[3 * BLOCK], e[2][BLOCK];
  for (int step = 0; step < STEPS; step++) {
    for (int i = 0; i < 3; i++)
      for (int p = 0; p < nblock; p++) inc[i * nblock + p] = strain[step][first + p][i];
    vumat_(&nblock, &ndir, &nshr, &nstatev, &nfieldv, &nprops, &lanneal, &total, &total, &dt, "A", zero, zero, props,
           zero, inc, zero, zero, zero, zero, zero, zero, state_old, zero, zero, zero, zero, zero, zero, s_new,
           state_new, e[0], e[1]);
    memcpy(state_old, state_new, sizeof state_old);
  }
  for (int j = 0; j < NSTATV; j++)
    for (int p = 0; p < nblock; p++) out->state[j][first + p] = state_new[j * nblock + p];
  for (int i = 0; i < 3; i++)
    for (int p = 0; p < nblock; p++) out->stress[first + p][i] = s_new[i * nblock + p];
}

static void by_points(int first, int last, result_type *out) {
  memset(out->rows[first], 0, sizeof out->rows[0] * (size_t)(last - first));
  for (int p = first; p < last; p++) {
    const double traction[3] = {-3.0 + strain[0][p][0], 0.5, 0.25};
    if (p % 97 == 0) asperity_initial_state(props, NPROPS, 1, traction, NSTATV, out->rows[p], NULL, 0);
  }
  for (int step = 0; step < STEPS; step++)
    asperity_update(props, NPROPS, dt, last - first, NULL, strain[step][first], NULL, NULL, NSTATV, out->rows[first],
                    out->stress[first], out->tangent[first], NULL, 0);
}

/* Messages of different length, whose numbers are those of the point. */
static void by_rejected(int first, int last, result_type *out) {
  for (int p = first; p < last; p++) {
    double state[NSTATV] = {0};
    for (int i = 8; i < 8 + p % (NSTATV - 8); i++) state[i] = 1e300 * strain[0][p][0];
    out->rows[p][0] = asperity_update(props, NPROPS, p % 2 ? dt : -1.0, 1, NULL, strain[0][p], NULL, NULL, NSTATV,
                                      state, out->stress[p], NULL, out->message[p], sizeof out->message[p]);
  }
}

static void *work(void *argument) {
  const work_type *w = argument;
  if (w->entry == 2) by_points(w->first, w->last, w->out);
  if (w->entry == 3) by_rejected(w->first, w->last, w->out);
  for (int p = w->first; p < w->last && w->entry < 2; p += w->entry == 0 ? 1 : BLOCK) {
    int end = p + BLOCK < w->last ? p + BLOCK : w->last;
    if (w->entry == 0)
      by_umat(p, w->out);
    else
      by_vumat(p, end, w->out);
  }
  return NULL;
}

int main(int argc, char **argv) {
  const long wanted = argc > 1 ? atol(argv[1]) : 10000000;
  uint64_t seed = 20150917;
  long differences = 0, done[ENTRIES] = {0};
  int failed = 0;
  if (wanted < 1) {
    fprintf(stderr, "threads: POINTS = %s: expected a whole number >= 1\n", argv[1]);
    return 1;
  }
  for (int entry = 0; entry < ENTRIES; entry++) {
    /* messages of rejected calls take a thousand times as long as updates */
    const long most = entry < 3 ? wanted : wanted / 100 + 1;
    const int round = most < ROUND ? (int)most : ROUND;
    long before = differences;
    while (done[entry] < most) {
      for (int step = 0; step < STEPS; step++)
        for (int p = 0; p < round; p++)
          for (int i = 0; i < 3; i++) strain[step][p][i] = 0.15 * draw(&seed);
      memset(&serial, 0, sizeof serial);
      memset(&parallel, 0, sizeof parallel);
      work_type alone = {entry, 0, round, &serial}, share[THREADS];
      pthread_t thread[THREADS];
      work(&alone);
      for (int k = 0; k < THREADS; k++) {
        share[k] = (work_type){entry, round * k / THREADS, round * (k + 1) / THREADS, &parallel};
        if (pthread_create(&thread[k], NULL, work, &share[k]) != 0) {
          puts("threads: a thread could not be started");
          return 1;
        }
      }
      for (int k = 0; k < THREADS; k++) pthread_join(thread[k], NULL);
      differences += memcmp(&serial, &parallel, sizeof serial) != 0;
      done[entry] += round;
    }
    double damaged = 0.0;
    for (int p = 0; p < round; p++) damaged += entry == 1 ? serial.state[0][p] : serial.rows[p][0];
    printf("threads %s: %ld points by %d threads, mean damage %.3f, rounds that differ from one thread: %ld\n",
           names[entry], done[entry], THREADS, damaged / round, differences - before);
    failed +=
        differences > before || (entry < 3 ? !(damaged > 0.1 * round && damaged < 0.95 * round) : damaged < round);
  }
  printf("%d passed, %d failed\n", ENTRIES - failed, failed);
  return failed != 0;
}
