/* Commit adapter: a UMAT that stores the state of Kratos' interface elements and calls the UMAT of libasperity.
 *
 * The elements Geo_U*InterfaceElement* of GeoMechanicsApplication 10.4 never commit a step. They pass STRAN = 0, the
 * total separation in DSTRAN, and the initial STRESS and STATEV at every call of every step. The adapter has a record
 * of the last committed state of each integration point. The first call with another KSTEP commits the result of the
 * last call of the previous step. Thus the law gets the arguments that the UMAT interface specifies. The adapter
 * repairs an error of this host and is not a part of the library.
 *
 * Kratos' step number arrives as KSTEP, and the number of the iteration as KINC. The law gets 1 and the number of the
 * step: steps of Kratos are increments of one step, in which IMPL-EX extrapolates from one to the next.
 *
 * A script must raise ProcessInfo[STEP] with every step, and build the strategy with compute_reactions, so that the
 * last call of a step is at the converged displacements. A step that is solved again with the same number starts from
 * the same committed state. A smaller number, or another initial STRESS or STATEV, starts another analysis.
 *
 * A point is identified by the address of STRESS, which does not change for a law object (the address of STATEV does;
 * NOEL and NPT are 0). Threads may call the adapter for different points at once: the table is locked, and each record
 * belongs to one point. */
#define _GNU_SOURCE
#include <asperity.h>
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct record {
  struct record *next; /* next record of the bucket */
  const double *key;   /* address of STRESS */
  size_t values;       /* number of values of each state below */
  size_t errors;       /* place of the two errors of IMPL-EX in a state below; 0: the law has none */
  int step;            /* KSTEP of the trial state; NONE: no call yet */
  double *committed;   /* STRESS, strain, STATEV at the start of the step; owns the memory of all three states */
  double *trial;       /* the same after the last call */
  double *initial;     /* STRESS, strain, STATEV of the first call; Kratos passes them at every call */
} record;

enum {
  BUCKETS = 1 << 16,
  ADDRESS_BITS = 4, /* low bits that are 0 in an aligned address */
  MOST = 6,         /* largest number of components */
  IMPLEX = 24,      /* place of the tolerance of IMPL-EX in PROPS, from 0 */
  MOST_PROPS = 292, /* constants of a law of 65 listed planes; further ones are not read */
  NO_PLANE = 5,     /* state variables of IMPL-EX before those of the planes */
  NONE = -1
};

static record *table[BUCKETS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static __typeof__(&umat_) law;

/* Find the UMAT of the next library in the search order: libasperity, with which this library is linked. */
static __attribute__((constructor)) void find_law(void) { *(void **)&law = dlsym(RTLD_NEXT, "umat_"); }

/* Delete the records of all points. This is necessary before an analysis whose step numbers continue those of another
 * one, and saves memory between many analyses in one process. It must not be called during an analysis. */
void asperity_kratos_reset(void) {
  pthread_mutex_lock(&lock);
  for (int i = 0; i < BUCKETS; i++) {
    for (record *r = table[i], *next; r != NULL; r = next) {
      next = r->next;
      free(r->committed); /* with the two states after it */
      free(r);
    }
    table[i] = NULL;
  }
  pthread_mutex_unlock(&lock);
}

/* Largest errors of IMPL-EX of all points, of damage and traction, in their last calls. */
void asperity_kratos_errors(double errors[2]) {
  errors[0] = errors[1] = 0.0;
  pthread_mutex_lock(&lock);
  for (int i = 0; i < BUCKETS; i++) {
    for (const record *r = table[i]; r != NULL; r = r->next) {
      for (int k = 0; k < 2 && r->errors > 0; k++) errors[k] = fmax(errors[k], r->trial[r->errors + (size_t)k]);
    }
  }
  pthread_mutex_unlock(&lock);
}

/* Find or create the record of a point with the given number of values; NULL: no memory. */
static record *find(const double *key, size_t values) {
  record **bucket = &table[((uintptr_t)key >> ADDRESS_BITS) % BUCKETS], *r;
  pthread_mutex_lock(&lock);
  for (r = *bucket; r != NULL && r->key != key; r = r->next) continue;
  if (r == NULL && (r = calloc(1, sizeof *r)) != NULL) {
    r->key = key;
    r->step = NONE;
    r->next = *bucket;
    *bucket = r;
  }
  if (r != NULL && r->values != values) { /* a new record, or another law at the same address */
    double *room = realloc(r->committed, 3 * values * sizeof *room);
    if (room == NULL) {
      r = NULL;
    } else {
      r->committed = room;
      r->trial = room + values;
      r->initial = room + 2 * values;
      r->values = values;
      r->step = NONE;
    }
  }
  pthread_mutex_unlock(&lock);
  return r;
}

/* Place of the errors of IMPL-EX among m state variables, from 0: after those of the law, of a point and of the planes.
 * A host may pass more state variables than the UMAT needs.  0: none. */
static size_t place_of_errors(const double *props, int nprops, size_t m) {
  const int read = nprops < MOST_PROPS ? nprops : MOST_PROPS;
  if (read <= IMPLEX || !(props[IMPLEX] > 0.0)) return 0;
  double implicit[MOST_PROPS], none;
  memcpy(implicit, props, (size_t)read * sizeof *props);
  implicit[IMPLEX] = 0.0; /* asperity_nstatv refuses another value */
  const int of_law = asperity_nstatv(implicit, read, NULL, 0);
  const size_t place = (size_t)of_law + NO_PLANE + (size_t)asperity_planes(implicit, read, 0, &none, &none);
  return of_law > 0 && m >= place + 2 ? place : 0;
}

void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, const double *stran, const double *dstran,
           const double *time, const double *dtime, const double *temp, const double *dtemp, const double *predef,
           const double *dpred, const char *cmname, const int *ndi, const int *nshr, const int *ntens,
           const int *nstatv, const double *props, const int *nprops, const double *coords, const double *drot,
           double *pnewdt, const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
           const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc) {
  const size_t n = (size_t)*ntens, m = (size_t)*nstatv, values = 2 * n + m;
  record *r = law == NULL || n > MOST ? NULL : find(stress, values);
  if (r == NULL) {
    for (size_t i = 0; i < n; i++) stress[i] = NAN; /* NaN stops the solver */
    return;
  }
  if (r->step == NONE || *kstep < r->step || memcmp(r->initial, stress, n * sizeof *stress) != 0 ||
      memcmp(r->initial + 2 * n, statev, m * sizeof *statev) != 0) {
    memcpy(r->initial, stress, n * sizeof *stress);
    memcpy(r->initial + n, stran, n * sizeof *stran);
    memcpy(r->initial + 2 * n, statev, m * sizeof *statev);
    memcpy(r->committed, r->initial, values * sizeof *r->initial);
    const size_t place = place_of_errors(props, *nprops, m);
    r->errors = place > 0 ? 2 * n + place : 0;
  } else if (*kstep > r->step) {
    memcpy(r->committed, r->trial, values * sizeof *r->trial);
  }
  r->step = *kstep;

  (void)kinc;
  const int only = 1;
  double increment[MOST];
  for (size_t i = 0; i < n; i++) increment[i] = stran[i] + dstran[i] - r->committed[n + i];
  memcpy(stress, r->committed, n * sizeof *stress);
  memcpy(statev, r->committed + 2 * n, m * sizeof *statev);
  law(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, r->committed + n, increment, time, dtime,
      temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0,
      dfgrd1, noel, npt, layer, kspt, &only, kstep);
  memcpy(r->trial, stress, n * sizeof *stress);
  for (size_t i = 0; i < n; i++) r->trial[n + i] = stran[i] + dstran[i];
  memcpy(r->trial + 2 * n, statev, m * sizeof *statev);
}
