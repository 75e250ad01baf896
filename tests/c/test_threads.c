/* Two threads are compared with one, for accepted and rejected calls of the UMAT and the C API. */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "asperity.h"
#include "check.h"

enum { NSTATV = POINT_STATEV + 5 * PLANE_STATEV, STEPS = 200, REJECTED = 300, INITIAL = 20 };
static const double rp_4[] = {3.0, 0.3, 0.9, 0.5, 30.0, 4.0};

/* Path of one point. Every thread k has a separate path. */
typedef struct {
  int k;
  int wrong;               /* rejected calls with another message, initial states with other bits than expected */
  double umat[NSTATV];     /* STATEV at the end, through umat_ */
  double points[NSTATV];   /* STATEV at the end, through asperity_update */
} walk_type;

/* Initial traction of thread k. Its load path damages the planes and makes them slide. */
static const double start[2][3] = {{-20.0, 1.0, 0.5}, {-12.0, -0.5, 2.0}};

static void umat_call(double *statev, double *stress, const double *stran, const double *dstran) {
  double ddsdde[9], sse, spd, scd;
  const int ndi = 1, nshr = 2, ntens = 3, nstatv = NSTATV, nprops = 6;
  umat_(stress, statev, ddsdde, &sse, &spd, &scd, NULL, NULL, NULL, NULL, stran, dstran, NULL, NULL, NULL, NULL, NULL,
        NULL, "A", &ndi, &nshr, &ntens, &nstatv, rp_4, &nprops, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL,
        NULL, NULL, NULL);
}

static void *walk(void *argument) {
  walk_type *w = argument;
  double from[3] = {0}, to[3], step[3], stress[3], traction[3], again[NSTATV];
  memset(w->umat, 0, sizeof w->umat);
  memset(w->points, 0, sizeof w->points);
  memcpy(stress, start[w->k], sizeof stress);
  asperity_initial_state(rp_4, 6, 1, start[w->k], NSTATV, w->points, NULL, 0);
  for (int i = 0; i < INITIAL; i++) {
    memset(again, 0, sizeof again);
    asperity_initial_state(rp_4, 6, 1, start[w->k], NSTATV, again, NULL, 0);
    if (memcmp(again, w->points, sizeof again) != 0) w->wrong++;
  }
  for (int i = 1; i <= STEPS; i++) {
    to[0] = 0.03 * sin(0.011 * i * (w->k + 1)) - 0.01;
    to[1] = 0.2 * sin(0.007 * i);
    to[2] = 0.1 * sin(0.013 * i + w->k);
    for (int j = 0; j < 3; j++) step[j] = to[j] - from[j];
    umat_call(w->umat, stress, from, step);
    asperity_update(rp_4, 6, 0.0, 1, from, to, NSTATV, w->points, traction, NULL, NULL, 0);
    for (int j = 0; j < 3; j++) from[j] += step[j];
  }
  return NULL;
}

/* Two threads give the results of one thread, bit for bit. */
static int two_threads_get_what_one_gets(void) {
  walk_type alone[2] = {{.k = 0}, {.k = 1}}, both[2] = {{.k = 0}, {.k = 1}};
  pthread_t thread[2];
  int failures = 0;
  for (int k = 0; k < 2; k++) walk(&alone[k]);
  for (int k = 0; k < 2; k++) pthread_create(&thread[k], NULL, walk, &both[k]);
  for (int k = 0; k < 2; k++) pthread_join(thread[k], NULL);
  for (int k = 0; k < 2; k++) {
    failures += FAILS(memcmp(alone[k].umat, both[k].umat, sizeof alone[k].umat) == 0);
    failures += FAILS(memcmp(alone[k].points, both[k].points, sizeof alone[k].points) == 0);
    failures += FAILS(both[k].wrong == 0);
    failures += FAILS(alone[k].umat[0] > 0.5);
    /* Both start from the traction and continue from the same offset. */
    for (int j = OFFSET; j < OFFSET + 3; j++) {
      failures += FAILS(alone[k].umat[j] != 0.0);
      failures += FAILS(alone[k].umat[j] == alone[k].points[j]);
    }
  }
  return failures;
}

/* Calls of both entries are rejected: bad state or constants, by thread, give messages of different length. */
static void *be_rejected(void *argument) {
  walk_type *w = argument;
  double props[6], state[NSTATV] = {0}, s[3] = {0}, traction[3];
  char message[4096], expected[4096];
  memcpy(props, rp_4, sizeof props);
  if (w->k == 0) {
    for (int i = POINT_STATEV; i < NSTATV; i++) state[i] = -0.25 - 1000.0 * NAN;
  } else {
    props[2] = 1.5;
  }
  asperity_update(props, 6, 0.0, 1, NULL, s, NSTATV, state, traction, NULL, expected, sizeof expected);
  for (int i = 0; i < REJECTED; i++) {
    int status = asperity_update(props, 6, 0.0, 1, NULL, s, NSTATV, state, traction, NULL, message, sizeof message);
    if (status == ASPERITY_OK || strcmp(message, expected) != 0) w->wrong++;
  }
  return NULL;
}

/* The messages of two threads do not mix. */
static int two_threads_are_rejected_apart(void) {
  walk_type w[2] = {{.k = 0}, {.k = 1}};
  pthread_t thread[2];
  for (int k = 0; k < 2; k++) pthread_create(&thread[k], NULL, be_rejected, &w[k]);
  for (int k = 0; k < 2; k++) pthread_join(thread[k], NULL);
  return FAILS(w[0].wrong == 0) + FAILS(w[1].wrong == 0);
}

int main(void) {
  int (*const tests[])(void) = {two_threads_get_what_one_gets, two_threads_are_rejected_apart};
  return check_run(2, tests);
}
