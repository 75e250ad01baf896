/* Calls of a UMAT in a shared library, as Abaqus/Standard calls it.
 *
 * All arguments lie in one block, with guards between them: what a routine writes outside its arguments, or reads
 * beyond them, is found. XIT and STDB_ABQERR end the call, not the program. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fenv.h>
#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

typedef void umat_routine(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd,
                          double *rpl, double *ddsddt, double *drplde, double *drpldt, double *stran, double *dstran,
                          double *time, double *dtime, double *temp, double *dtemp, double *predef, double *dpred,
                          char *cmname, int *ndi, int *nshr, int *ntens, int *nstatv, double *props, int *nprops,
                          double *coords, double *drot, double *pnewdt, double *celent, double *dfgrd0, double *dfgrd1,
                          int *noel, int *npt, int *layer, int *kspt, int *kstep, int *kinc, size_t cmname_length);

/* Arguments; those before STRAN may be written. */
enum {
  STRESS, STATEV, DDSDDE, SSE, SPD, SCD, RPL, DDSDDT, DRPLDE, DRPLDT, PNEWDT, STRAN, DSTRAN, TIME, DTIME, TEMP, DTEMP,
  PREDEF, DPRED, PROPS, COORDS, DROT, CELENT, DFGRD0, DFGRD1, NDI, NSHR, NTENS, NSTATV, NPROPS, NOEL, NPT, LAYER, KSPT,
  KSTEP, KINC, ARGUMENTS
};
static const char *const names[ARGUMENTS] = {
  "STRESS", "STATEV", "DDSDDE", "SSE", "SPD", "SCD", "RPL", "DDSDDT", "DRPLDE", "DRPLDT", "PNEWDT", "STRAN", "DSTRAN",
  "TIME", "DTIME", "TEMP", "DTEMP", "PREDEF", "DPRED", "PROPS", "COORDS", "DROT", "CELENT", "DFGRD0", "DFGRD1", "NDI",
  "NSHR", "NTENS", "NSTATV", "NPROPS", "NOEL", "NPT", "LAYER", "KSPT", "KSTEP", "KINC"
};

/* Numbers between two arguments, and how a caller fills them and treats the arguments. */
enum { GUARD = 64 };
enum { GUARD_NAN = -1, GUARD_ONE = -2 };

/* A routine, and what came of its calls; only one thread uses it. */
typedef struct routine {
  struct routine *earlier;
  umat_routine *call;
  void *handle;
  char library[PATH_MAX], symbol[128];
  char trouble[PATH_MAX + 1000]; /* why it has failed; empty: it has not */
  double pnewdt;      /* smallest request in this attempt at an increment */
  int attempt;
  int checks; /* 1: requests are not obeyed; 2: and arguments that may not be written are compared */
  int guard;  /* GUARD_NAN or GUARD_ONE, or the argument behind which the guard is 1 */
  int absent; /* which of those that `may_be_absent` is NULL, -1: none */
} routine_type;

/* Arguments of a call as the caller gives them. */
typedef struct {
  int size[ARGUMENTS];
  const double *input[ARGUMENTS];
} values_type;

void umat_(void); /* that of this project, which is called without a library */

static routine_type *opened;
static _Thread_local struct {
  jmp_buf back;
  routine_type *routine;
} current;

/* Arguments that hosts without temperatures, elements or orientations pass as NULL. */
static const int may_be_absent[] = {RPL, DDSDDT, DRPLDE, DRPLDT, TEMP, DTEMP, PREDEF, DPRED, COORDS, DROT, PNEWDT,
                                    CELENT, DFGRD0, DFGRD1, NOEL, NPT, LAYER, KSPT};
enum { MAY_BE_ABSENT = sizeof may_be_absent / sizeof may_be_absent[0] };

/* Note why a routine has failed; the first reason is kept. */
static void fail(routine_type *routine, const char *reason) {
  if (routine->trouble[0] != '\0') return;
  snprintf(routine->trouble, sizeof routine->trouble, "%s%s%s: %s", routine->symbol,
           routine->library[0] ? " of " : "", routine->library, reason);
}

/* Utility of Abaqus: ends the analysis. */
void xit_(void) {
  if (current.routine == NULL) exit(1);
  fail(current.routine, "it called XIT, which ends the analysis");
  longjmp(current.back, 1);
}

/* Utility of Abaqus: a message; an error (level -2, -3) ends the analysis. */
void stdb_abqerr_(const int *level, const char *text, const int *integers, const double *reals, const char *words,
                  size_t text_length, size_t words_length) {
  char said[600];
  (void)integers, (void)reals, (void)words, (void)words_length;
  snprintf(said, sizeof said, "it called STDB_ABQERR: %.*s", (int)(text_length < 500 ? text_length : 500), text);
  if (*level >= -1 || current.routine == NULL) {
    fprintf(stderr, "%s\n", said);
    return;
  }
  fail(current.routine, said);
  longjmp(current.back, 1);
}

/* What ends the program without its exit handlers; of a routine it ends the call, as the run would look complete. */
void _exit(int status) {
  if (current.routine != NULL) {
    fail(current.routine, "it ended the program by _exit");
    longjmp(current.back, 1);
  }
  syscall(SYS_exit_group, status);
  abort();
}
void _Exit(int status) { _exit(status); }

/* A routine that fails by a signal, as at a wrong address, ends its call. */
static void struck(int number) {
  char said[100];
  if (current.routine == NULL) {
    signal(number, SIG_DFL);
    raise(number);
    return;
  }
  snprintf(said, sizeof said, "it ended by signal %d (%s)", number, strsignal(number));
  fail(current.routine, said);
  longjmp(current.back, 1);
}

/* Signals by which routines fail, and what becomes of them. Their handler has a stack of its own, as large arrays
 * exhaust that of the program. */
static void treat_signals(void (*handler)(int)) {
  static const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
  static char memory[1 << 16];
  const stack_t stack = {.ss_sp = memory, .ss_size = sizeof memory};
  struct sigaction action = {.sa_handler = handler, .sa_flags = SA_NODEFER | SA_ONSTACK};
  sigaltstack(&stack, NULL);
  for (int i = 0; i < 5; i++) sigaction(signals[i], &action, NULL);
}

/* A routine that ends the program, as by STOP, ends it as an error; what it writes is in the files already. */
static void stopped(void) {
  if (current.routine == NULL) return;
  fail(current.routine, "it ended the program, as STOP does");
  fprintf(stderr, "rie_driver: %s\n", current.routine->trouble);
  current.routine = NULL;
  _exit(2);
}

/* Open a library and find its routine; its path becomes the whole one, as the file of a failed increment may lie
 * elsewhere, and an empty one is this program. NULL and a message: that failed. */
routine_type *umat_open(char *library, const char *symbol, char *message, int length) {
  routine_type *const routine = calloc(1, sizeof *routine);
  char path[PATH_MAX];
  if (routine == NULL) abort();
  if (library[0] != '\0' && realpath(library, path) != NULL) snprintf(library, (size_t)length, "%s", path);
  snprintf(routine->library, sizeof routine->library, "%s", library);
  snprintf(routine->symbol, sizeof routine->symbol, "%s", symbol);
  /* each is needed until the program ends */
  routine->earlier = opened;
  opened = routine;
  routine->absent = -1;
  routine->guard = GUARD_NAN;
  routine->pnewdt = 1.0;
  void *found = NULL;
  routine->call = (umat_routine *)umat_;
  if (library[0] == '\0') return routine;
  if (routine->earlier == NULL) {
    atexit(stopped);
    treat_signals(struck);
  }
  routine->handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
  if (routine->handle != NULL) found = dlsym(routine->handle, symbol);
  memcpy(&routine->call, &found, sizeof found);
  if (found != NULL) return routine;
  snprintf(message, (size_t)length, "%s", dlerror());
  return NULL;
}

/* A copy without trouble that is called in its own way; a fresh one has its library loaded again, with the static
 * variables of its start. The name is that of the absent argument. */
routine_type *umat_copy(const routine_type *from, int fresh, int checks, int guard, int absent, char *name,
                        int length) {
  routine_type *copy = NULL;
  char library[PATH_MAX];
  snprintf(library, sizeof library, "%s", from->library);
  /* a handle counts how often its library was opened */
  for (int i = 0; fresh && from->handle != NULL && i < 10000 && dlclose(from->handle) == 0; i++) {
    void *const still = dlopen(library, RTLD_NOW | RTLD_NOLOAD);
    if (still == NULL) break;
    dlclose(still);
  }
  if (fresh) copy = umat_open(library, from->symbol, library, sizeof library);
  if (copy == NULL) {
    copy = malloc(sizeof *copy);
    if (copy == NULL) abort();
    *copy = *from;
  }
  copy->trouble[0] = '\0';
  copy->pnewdt = 1.0;
  copy->checks = checks;
  copy->guard = guard;
  copy->absent = absent < MAY_BE_ABSENT ? absent : -1;
  snprintf(name, (size_t)length, "%s", copy->absent >= 0 ? names[may_be_absent[absent]] : "");
  return copy;
}

/* Share of the increment that the routine asks for: 1, less (PNEWDT), or 0 with the reason. */
void umat_ask(routine_type *routine, double *share, char *message, int length) {
  *share = routine->pnewdt < 1.0 ? fmax(routine->pnewdt, 1e-3) : 1.0;
  if (routine->trouble[0] != '\0') *share = 0.0;
  snprintf(message, (size_t)length, "%s", routine->trouble);
}

/* Pointer to an argument; NULL if it is absent. */
static double *at(const routine_type *routine, double *block, const int *place, int k) {
  return routine->absent >= 0 && may_be_absent[routine->absent] == k ? NULL : block + place[k];
}

/* One call with new arguments in a block of `total` numbers; false: the routine ended the analysis. */
static int call_once(routine_type *routine, const values_type *values, int guard, const int *place, int total,
                     double *block, double *before) {
  const double fill[2] = {nan("0x77"), 1.0};
  for (int i = 0; i < total; i++) block[i] = fill[guard == GUARD_ONE];
  for (int k = 0; k < ARGUMENTS; k++) {
    for (int i = 0; k == guard && i < GUARD; i++) block[place[k] + values->size[k] + i] = fill[1];
    memcpy(block + place[k], values->input[k], (size_t)values->size[k] * sizeof *block);
  }
  memcpy(before, block, (size_t)total * sizeof *block);
  char name[81];
  snprintf(name, sizeof name, "%-80s", "INTERFACE");
  fenv_t floating;
  feholdexcept(&floating);
  current.routine = routine;
  const int ended = setjmp(current.back);
#define D(k) at(routine, block, place, k)
#define I(k) (int *)at(routine, block, place, k)
  if (!ended) {
    routine->call(D(STRESS), D(STATEV), D(DDSDDE), D(SSE), D(SPD), D(SCD), D(RPL), D(DDSDDT), D(DRPLDE), D(DRPLDT),
                  D(STRAN), D(DSTRAN), D(TIME), D(DTIME), D(TEMP), D(DTEMP), D(PREDEF), D(DPRED), name, I(NDI), I(NSHR),
                  I(NTENS), I(NSTATV), D(PROPS), I(NPROPS), D(COORDS), D(DROT), D(PNEWDT), D(CELENT), D(DFGRD0),
                  D(DFGRD1), I(NOEL), I(NPT), I(LAYER), I(KSPT), I(KSTEP), I(KINC), 80);
  }
  current.routine = NULL;
  fesetenv(&floating);
  return !ended;
}

/* Note what a call wrote outside its arguments, and with `checks` 2 to arguments that are the host's. */
static void compare(routine_type *routine, const values_type *values, const int *place, const double *block,
                    const double *before) {
  char reason[200];
  for (int k = 0; k < ARGUMENTS; k++) {
    const int own = k < STRAN || routine->checks < 2;
    for (int i = -GUARD / 2; i < values->size[k] + GUARD / 2; i++) {
      if (own && i >= 0 && i < values->size[k]) continue;
      if (memcmp(block + place[k] + i, before + place[k] + i, sizeof *block) == 0) continue;
      if (i >= 0 && i < values->size[k]) {
        snprintf(reason, sizeof reason, "it wrote to %s, which is the host's", names[k]);
      } else {
        snprintf(reason, sizeof reason, "it wrote to %s(%d), of %d: expected a larger nstatv", names[k], i + 1,
                 values->size[k]);
        if (k != STATEV) *strrchr(reason, ':') = '\0';
      }
      fail(routine, reason);
      return;
    }
  }
}

/* First result that is not finite, by the argument and its index from 1; 0: all are finite. */
static int not_finite(const values_type *values, const int *place, const double *block, int *argument) {
  for (int k = STRESS; k <= SCD; k++) {
    for (int i = 0; i < values->size[k]; i++) {
      *argument = k;
      if (!isfinite(block[place[k] + i])) return i + 1;
    }
  }
  return 0;
}

/* Call a routine from the values at the start of an increment; results only if `good`. */
void umat_call(routine_type *routine, int attempt, int ntens, int nstatv, int nprops, const double *props,
               const double *stran, const double *dstran, const double *time, double dtime, const int *counts,
               double *stress, double *statev, double *ddsdde, double *energies, int *good) {
  static const double zeros[6] = {0.0}, one = 1.0, unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  const double tangent[36] = {0.0};
  *good = 0;
  if (attempt != routine->attempt) routine->pnewdt = 1.0;
  routine->attempt = attempt;
  if (routine->trouble[0] != '\0' || (routine->pnewdt < 1.0 && !routine->checks)) return;
  const int direct = ntens == 6 ? 3 : 1;
  /* KSTEP is the first of the four numbers of JSTEP; 1 is a static analysis */
  const int integers[][4] = {{direct}, {ntens - direct}, {ntens}, {nstatv}, {nprops}, {1}, {1}, {1}, {1},
                             {counts[0], 1, 0, 0}, {counts[1]}};
  values_type values;
  for (int k = 0; k < ARGUMENTS; k++) {
    values.size[k] = 1;
    values.input[k] = zeros;
  }
  const int of_ntens[] = {STRESS, DDSDDT, DRPLDE, STRAN, DSTRAN};
  for (int i = 0; i < 5; i++) values.size[of_ntens[i]] = ntens;
  values.size[DDSDDE] = ntens * ntens;
  values.size[STATEV] = nstatv;
  values.size[PROPS] = nprops;
  values.size[COORDS] = 3;
  values.size[TIME] = values.size[KSTEP] = 2;
  values.size[DROT] = values.size[DFGRD0] = values.size[DFGRD1] = 9;
  values.input[STRESS] = stress;
  values.input[STATEV] = statev;
  values.input[DDSDDE] = tangent;
  for (int i = 0; i < 3; i++) values.input[SSE + i] = energies + i;
  values.input[STRAN] = stran;
  values.input[DSTRAN] = dstran;
  values.input[TIME] = time;
  values.input[DTIME] = &dtime;
  values.input[PROPS] = props;
  values.input[PNEWDT] = values.input[CELENT] = &one;
  values.input[DROT] = values.input[DFGRD0] = values.input[DFGRD1] = unit;
  for (int k = NDI; k <= KINC; k++) values.input[k] = (const double *)integers[k - NDI];

  int place[ARGUMENTS], total = GUARD;
  for (int k = 0; k < ARGUMENTS; k++) {
    place[k] = total;
    total += values.size[k] + GUARD;
  }
  double *const block = malloc(2 * (size_t)total * sizeof *block);
  if (block == NULL) abort();
  int argument, index;
  if (call_once(routine, &values, routine->guard, place, total, block, block + total)) {
    compare(routine, &values, place, block, block + total);
    if (isnan(block[place[PNEWDT]])) fail(routine, "it returned no number in PNEWDT");
    routine->pnewdt = fmin(routine->pnewdt, block[place[PNEWDT]]);
    index = not_finite(&values, place, block, &argument);
    if (index > 0 && !(routine->pnewdt < 1.0)) {
      char reason[300];
      int length = snprintf(reason, sizeof reason, "it returned no finite number in %s(%d)", names[argument], index);
      const int suspects[] = {PROPS, STATEV};
      for (int i = 0; i < 2; i++) {
        int other;
        routine_type trial = *routine; /* a failure of which is none of the routine */
        if (!call_once(&trial, &values, suspects[i], place, total, block, block + total) ||
            not_finite(&values, place, block, &other) > 0) continue;
        snprintf(reason + length, sizeof reason - (size_t)length, ", as it read more than the %d values of %s",
                 values.size[suspects[i]], names[suspects[i]]);
      }
      fail(routine, reason);
    }
    *good = index == 0 && routine->trouble[0] == '\0' && (routine->checks || !(routine->pnewdt < 1.0));
    if (index > 0 && routine->checks) fail(routine, "it returned no numbers, and asked for a smaller increment");
  }
  if (*good) {
    memcpy(stress, block + place[STRESS], (size_t)ntens * sizeof *block);
    memcpy(statev, block + place[STATEV], (size_t)nstatv * sizeof *block);
    memcpy(ddsdde, block + place[DDSDDE], (size_t)(ntens * ntens) * sizeof *block);
    for (int i = 0; i < 3; i++) energies[i] = block[place[SSE + i]];
  }
  free(block);
}

/* Do a piece of work in a process of its own, which writes up to `length` bytes of text: 0, or the signal that ended
 * it, or -1. */
int umat_apart(void (*work)(int, void *, char *), int which, void *data, char *text, int length) {
  char *const shared = mmap(NULL, (size_t)length, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  int status = -1;
  if (shared == MAP_FAILED) return -1;
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    /* without the reports of the Fortran run-time library */
    treat_signals(SIG_DFL);
    work(which, data, shared);
    _exit(0);
  }
  if (child > 0) waitpid(child, &status, 0);
  memcpy(text, shared, (size_t)length);
  munmap(shared, (size_t)length);
  return child > 0 && WIFSIGNALED(status) ? WTERMSIG(status) : child > 0 && status == 0 ? 0 : -1;
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
