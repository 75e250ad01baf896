/* Calls of a UMAT in a shared library, as Abaqus/Standard calls it. Each process has one UMAT, which it opens once.
 *
 * All arguments lie in one block, with guards between them and pages without access around it: what a routine writes
 * outside its arguments, or reads beyond them, is found. What is wrong ends the process with the reason. */
#define _GNU_SOURCE
#include "umat_worker.h"
#include <dlfcn.h>
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Arguments in their order: name, size, and where the values are that umat_call passes. */
// clang-format off
#define ARGUMENTS(X)                                                                                                   \
  X(STRESS, ntens, stress) X(STATEV, nstatv, statev) X(DDSDDE, ntens * ntens, entry) X(SSE, 1, energies)               \
  X(SPD, 1, energies + 1) X(SCD, 1, energies + 2) X(RPL, 1, zeros) X(DDSDDT, ntens, zeros) X(DRPLDE, ntens, zeros)     \
  X(DRPLDT, 1, zeros) X(STRAN, ntens, stran) X(DSTRAN, ntens, dstran) X(TIME, 2, time) X(DTIME, 1, &dtime)             \
  X(TEMP, 1, zeros) X(DTEMP, 1, zeros) X(PREDEF, 1, zeros) X(DPRED, 1, zeros) X(CMNAME, 10, name)                      \
  X(NDI, 1, integers[0]) X(NSHR, 1, integers[1]) X(NTENS, 1, integers[2]) X(NSTATV, 1, integers[3])                    \
  X(PROPS, nprops, props) X(NPROPS, 1, integers[4]) X(COORDS, 3, zeros) X(DROT, 9, unit) X(PNEWDT, 1, unit)            \
  X(CELENT, 1, unit) X(DFGRD0, 9, unit) X(DFGRD1, 9, unit) X(NOEL, 1, integers[5]) X(NPT, 1, integers[5])              \
  X(LAYER, 1, integers[5]) X(KSPT, 1, integers[5]) X(KSTEP, 2, integers[6]) X(KINC, 1, integers[7])
#define NAME(name, size, values) name,
#define TEXT(name, size, values) #name,
#define TYPE(name, size, values) void *,
#define SIZE(name, size, values) size,
#define VALUES(name, size, values) values,
#define AT(name, size, values) at(name),
enum { ARGUMENTS(NAME) COUNT };
static const char *const names[] = {ARGUMENTS(TEXT)};
typedef void umat_routine(ARGUMENTS(TYPE) size_t cmname_length);
// clang-format on

/* Numbers between two arguments, and bytes without access on either side of the block. */
enum { GUARD = 64, REACH = 1 << 28 };

/* What DDSDDE has at entry where each number of it must be written; else it has negative zeros. */
static const double MARK = 1.2345678901234567e7;

void umat_(void); /* that of this project, which is called without a library */

/* The UMAT, and how it is called. */
static umat_routine *routine;
static int checks;           /* requests for smaller increments are not obeyed */
static int strict;           /* arguments that are the host's must not change */
static int marks;            /* DDSDDE has other numbers at entry, and each of them must be written */
static double fill;          /* what the guards have */
static double intact[GUARD]; /* a guard to which nothing was written */
static int absent = -1;      /* the argument that is NULL */
static char job[81];         /* the name of the job in Abaqus, here of the case */

/* The arguments of a thread. */
typedef struct {
  double *block;
  int attempt;                       /* at an increment */
  int size[COUNT], place[COUNT + 1]; /* the last place is the end */
} arguments_type;
static _Thread_local arguments_type own = {.attempt = -1};

/* Utility of Abaqus: ends the analysis. */
void xit_(void) { umat_worker_fail("it called XIT, which ends the analysis"); }

/* Utility of Abaqus: a message; an error (level -2, -3) ends the analysis. */
void stdb_abqerr_(const int *level, const char *text, const int *integers, const double *reals, const char *words,
                  size_t text_length, size_t words_length) {
  char said[600];
  (void)integers, (void)reals, (void)words, (void)words_length;
  snprintf(said, sizeof said, "it called STDB_ABQERR: %.*s", (int)(text_length < 500 ? text_length : 500), text);
  if (*level < -1) umat_worker_fail(said);
  fprintf(stderr, "%s\n", said);
}

/* A text of C into one of Fortran; its length. */
static void to_fortran(const char *text, char *name, int *length, size_t room) {
  const size_t n = strlen(text) < room ? strlen(text) : room;
  memset(name, ' ', room);
  memcpy(name, text, n);
  *length = (int)n;
}

/* Utilities of Abaqus: folder of the results, name of the job, number of processes and the number of this one. */
void getoutdir_(char *name, int *length, size_t room) {
  char folder[4096] = "";
  to_fortran(getcwd(folder, sizeof folder) != NULL ? folder : ".", name, length, room);
}
void getjobname_(char *name, int *length, size_t room) { to_fortran(job, name, length, room); }
void getnumcpus_(int *number) { *number = 1; }
void getrank_(int *rank) { *rank = 0; }

/* Utilities of Abaqus: locks, by their numbers from 1 to 100. */
static pthread_mutex_t locks[100];
static pthread_mutex_t *lock_of(const int *number) {
  if (*number < 1 || *number > 100) umat_worker_fail("it used a mutex whose number is not 1 to 100");
  return &locks[*number - 1];
}
void mutexinit_(const int *number) { pthread_mutex_init(lock_of(number), NULL); }
void mutexlock_(const int *number) { pthread_mutex_lock(lock_of(number)); }
void mutexunlock_(const int *number) { pthread_mutex_unlock(lock_of(number)); }

/* End the process if something was written outside the arguments: what lies nearer to the one before a guard is its. */
static void check_guards(void) {
  uint64_t expected, found;
  char reason[200];
  memcpy(&expected, &fill, sizeof expected);
  for (int k = 0; own.block != NULL && k <= COUNT; k++) {
    const double *const guard = own.block + own.place[k] - GUARD;
    int first = 0;
    if (memcmp(guard, intact, sizeof intact) == 0) continue;
    for (int i = GUARD - 1; i >= 0; i--) {
      memcpy(&found, guard + i, sizeof found);
      if (found != expected) first = i + 1;
    }
    if (first == 0) continue;
    const int before = k > 0 && (first <= GUARD / 2 || k == COUNT), l = before ? k - 1 : k;
    snprintf(reason, sizeof reason, "it wrote to %s(%d), of %d%s", names[l],
             before ? own.size[l] + first : first - GUARD, own.size[l],
             l == STATEV ? ": expected a larger nstatv" : "");
    umat_worker_fail(reason);
  }
}

/* A routine that goes far beyond its arguments may have written to the guards before. */
static void struck(int number) {
  signal(number, SIG_DFL);
  check_guards();
}

/* Open the UMAT of a library, or that of this project for an empty name, and set how it is called: `ones` fills the
 * guards with 1 instead of NaN, which_absent names an argument that is NULL, if it is one. */
void umat_open(const char *library, const char *symbol, const char *job_name, int checked, int strictly, int ones,
               int marked, const char *which_absent) {
  checks = checked;
  strict = strictly;
  marks = marked;
  snprintf(job, sizeof job, "%s", job_name);
  fill = ones ? 1.0 : nan("0x77");
  for (int i = 0; i < GUARD; i++) intact[i] = fill;
  for (int k = 0; k < COUNT; k++) {
    if (strcmp(names[k], which_absent) == 0) absent = k;
  }
  signal(SIGSEGV, struck);
  signal(SIGBUS, struck);
  routine = (umat_routine *)umat_;
  if (library[0] == '\0') return;
  void *const handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  void *const found = handle != NULL ? dlsym(handle, symbol) : NULL;
  if (found == NULL) umat_worker_fail(dlerror());
  memcpy(&routine, &found, sizeof found);
}

/* Place the arguments of this thread; the block ends where a page without access begins. */
static void place_arguments(int ntens, int nstatv, int nprops) {
  const int size[] = {ARGUMENTS(SIZE)};
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  size_t total = GUARD, reach = REACH;
  for (int k = 0; k < COUNT; k++) {
    own.size[k] = size[k];
    own.place[k] = (int)total;
    total += (size_t)size[k] + GUARD;
  }
  own.place[COUNT] = (int)total;
  const size_t bytes = (total * sizeof *own.block + page - 1) / page * page;
  char *memory = MAP_FAILED;
  for (; memory == MAP_FAILED && reach >= page; reach /= 2) {
    memory = mmap(NULL, bytes + 2 * reach, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory != MAP_FAILED) break;
  }
  if (memory == MAP_FAILED || mprotect(memory + reach, bytes, PROT_READ | PROT_WRITE) != 0) abort();
  own.block = (double *)(memory + reach + bytes) - total;
  for (size_t i = 0; i < total; i++) own.block[i] = fill;
}

/* Pointer to an argument; NULL if it is absent. */
static double *at(int k) { return k == absent ? NULL : own.block + own.place[k]; }

/* One call with new arguments. */
static void call_once(const void *const *input) {
  fenv_t floating;
  for (int k = 0; k < COUNT; k++) memcpy(own.block + own.place[k], input[k], (size_t)own.size[k] * sizeof *own.block);
  feholdexcept(&floating);
  routine(ARGUMENTS(AT) 80);
  fesetenv(&floating);
}

/* First result that is not finite, by the argument and its index from 1; 0: all are finite. */
static int not_finite(int *argument) {
  for (int k = STRESS; k <= SCD; k++) {
    for (int i = 0; i < own.size[k]; i++) {
      *argument = k;
      if (!isfinite(own.block[own.place[k] + i])) return i + 1;
    }
  }
  return 0;
}

/* End the process if DDSDDE has a number that it had at entry. Some hosts pass zeros, and others what was there before:
 * without marks, a part of DDSDDE may be left as it is. */
static void check_written(int ntens, const double *entry) {
  char reason[200] = "it does not write";
  int left = 0;
  for (int k = 0; k < ntens * ntens; k++) {
    if (memcmp(own.block + own.place[DDSDDE] + k, entry, sizeof *entry) != 0) continue;
    if (left++ > 2) continue;
    snprintf(reason + strlen(reason), sizeof reason - strlen(reason), "%s DDSDDE(%d,%d)", left > 1 ? "," : "",
             k % ntens + 1, k / ntens + 1);
  }
  if (left == ntens * ntens) umat_worker_fail("it does not write DDSDDE");
  if (left > 3) snprintf(reason + strlen(reason), sizeof reason - strlen(reason), " and %d more", left - 3);
  if (left > 0 && marks) umat_worker_fail(reason);
}

/* End the process as a result is not finite; what a guard of ones makes finite was read there. */
static void fail_for(int argument, int index, const void *const *input) {
  const int suspects[] = {PROPS, STATEV};
  char reason[300];
  int other, length = snprintf(reason, sizeof reason, "it returned no finite number in %s(%d)", names[argument], index);
  for (int i = 0; i < 2; i++) {
    double *const behind = own.block + own.place[suspects[i]] + own.size[suspects[i]];
    for (int j = 0; j < GUARD; j++) behind[j] = 1.0;
    call_once(input);
    if (not_finite(&other) == 0) {
      snprintf(reason + length, sizeof reason - (size_t)length, ", as it read more than the %d values of %s",
               own.size[suspects[i]], names[suspects[i]]);
      break;
    }
    for (int j = 0; j < GUARD; j++) behind[j] = fill;
  }
  umat_worker_fail(reason);
}

/* Call the UMAT from the values at the start of an increment. If it asks for a smaller one by PNEWDT, there are no
 * results, and `requested` is below 1; checks do not obey. */
void umat_call(int attempt, int ntens, int nstatv, int nprops, const double *props, const double *stran,
               const double *dstran, const double *time, double dtime, const int *counts, double *stress,
               double *statev, double *ddsdde, double *energies, double *requested) {
  static const double zeros[36] = {0.0}, unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  const int direct = ntens == 6 ? 3 : 1;
  /* KSTEP is the first of the four numbers of JSTEP; 1 is a static analysis */
  const int integers[][4] = {{direct}, {ntens - direct},     {ntens},    {nstatv}, {nprops},
                             {1},      {counts[0], 1, 0, 0}, {counts[1]}};
  char name[81], reason[100];
  double entry[36];
  for (int k = 0; k < 36; k++) entry[k] = marks ? MARK : -0.0;
  const void *const input[] = {ARGUMENTS(VALUES)};
  int argument;
  if (attempt != own.attempt) umat_worker_begin(counts[0], counts[1]);
  own.attempt = attempt;
  if (own.block == NULL) place_arguments(ntens, nstatv, nprops);
  snprintf(name, sizeof name, "%-80s", "INTERFACE");
  call_once(input);
  umat_worker_end_copies();
  check_guards();
  for (int k = STRAN; strict && k < COUNT; k++) {
    const size_t bytes = (size_t)own.size[k] * sizeof *own.block;
    if (k == PNEWDT || memcmp(own.block + own.place[k], input[k], bytes) == 0) continue;
    snprintf(reason, sizeof reason, "it wrote to %s, which is the host's", names[k]);
    umat_worker_fail(reason);
  }
  const double asked = absent == PNEWDT ? 1.0 : own.block[own.place[PNEWDT]];
  if (isnan(asked)) umat_worker_fail("it returned no number in PNEWDT");
  const int index = not_finite(&argument);
  if (index > 0 && !(asked < 1.0)) fail_for(argument, index, input);
  if (index > 0 && checks) umat_worker_fail("it returned no numbers, and asked for a smaller increment");
  *requested = checks ? 1.0 : fmin(asked, 1.0);
  if (*requested < 1.0) return;
  check_written(ntens, entry);
  memcpy(stress, own.block + own.place[STRESS], (size_t)ntens * sizeof *stress);
  memcpy(statev, own.block + own.place[STATEV], (size_t)nstatv * sizeof *statev);
  memcpy(ddsdde, own.block + own.place[DDSDDE], (size_t)(ntens * ntens) * sizeof *ddsdde);
  for (int i = 0; i < 3; i++) energies[i] = own.block[own.place[SSE + i]];
}

typedef struct {
  void (*work)(int, void *);
  void *data;
  int which;
} job_type;

static void *start(void *argument) {
  const job_type *const job = argument;
  job->work(job->which, job->data);
  return NULL;
}

/* Do two pieces of work, 1 and 2, at once. */
void umat_threads(void (*work)(int, void *), void *data) {
  job_type job[2] = {{work, data, 1}, {work, data, 2}};
  pthread_t thread;
  const int started = pthread_create(&thread, NULL, start, &job[0]) == 0;
  if (!started) start(&job[0]);
  start(&job[1]);
  if (started) pthread_join(thread, NULL);
}
