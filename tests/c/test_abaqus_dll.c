/* The DLLs for Abaqus on Windows, called by the names that Abaqus may use, from 16 threads. Arguments: standardU.dll,
 * explicitU.dll, explicitU-D.dll. */
#include "check.h"
#include "libraries.h"

enum { NTENS = 3, NSTATV = 11, NPROPS = 10, NBLOCK = 2, THREADS = 16 };
static const double SIGMA0 = 3.0, GC = 0.3, ETA = 0.9;
#define S0 ((1.0 - ETA) * 2.0 * GC / SIGMA0)
#define K (SIGMA0 / S0)
/* A few roundings of a number of the size of the strength, in both kinds of reals. */
#define DOUBLE_TOLERANCE (16 * 2.3e-16 * SIGMA0)
#define SINGLE_TOLERANCE (16 * 1.2e-7 * SIGMA0)

typedef void umat_routine(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd,
                          double *rpl, double *ddsddt, double *drplde, double *drpldt, const double *stran,
                          const double *dstran, const double *time, const double *dtime, const double *temp,
                          const double *dtemp, const double *predef, const double *dpred, const char *cmname,
                          const int *ndi, const int *nshr, const int *ntens, const int *nstatv, const double *props,
                          const int *nprops, const double *coords, const double *drot, double *pnewdt,
                          const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
                          const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc,
                          size_t length);

/* The paths of the DLLs, and a part of s_0 at which the joint is intact. */
static char **dlls;
static const double part = 0.5;

/* A routine of a DLL by one of its two names; NULL if there is none. */
static void *routine_of(const char *path, const char *name) {
  void *const opened = dlopen(path, RTLD_NOW);
  return opened ? dlsym(opened, name) : NULL;
}

/* In each thread the traction and the stiffness of an intact joint that opens. */
static int call_umat(const char *name) {
  void *const address = routine_of(dlls[1], name);
  umat_routine *const umat = (umat_routine *)(intptr_t)address;
  const int ndi = 1, nshr = 2, ntens = NTENS, nstatv = NSTATV, nprops = NPROPS, one = 1;
  const double props[NPROPS] = {SIGMA0, GC, ETA, 0.5, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0}, dtime = 1.0;
  int wrong = FAILS(address != NULL);
  if (wrong) return wrong;
#pragma omp parallel num_threads(THREADS) reduction(+ : wrong)
  {
    double stress[NTENS] = {0}, statev[NSTATV] = {0}, ddsdde[NTENS * NTENS], energy[3] = {0}, none[9] = {0},
           pnewdt = 1.0;
    const double stran[NTENS] = {0}, dstran[NTENS] = {part * S0, 0, 0};
    umat(stress, statev, ddsdde, energy, energy + 1, energy + 2, none, none, none, none, stran, dstran, none, &dtime,
         none, none, none, none, "JOINT", &ndi, &nshr, &ntens, &nstatv, props, &nprops, none, none, &pnewdt, none, none,
         none, &one, &one, &one, &one, &one, &one, 5);
    wrong += DIFFERS(part * SIGMA0, stress[0], DOUBLE_TOLERANCE);
    wrong += DIFFERS(K, ddsdde[0], DOUBLE_TOLERANCE * K / SIGMA0);
  }
  return wrong;
}

/* The same by a block of two points in reals of a kind. */
#define CALL_VUMAT(NAME, REAL, TOLERANCE)                                                                              \
  static int NAME(const char *path, const char *name) {                                                                \
    void *const address = routine_of(path, name);                                                                      \
    if (FAILS(address != NULL)) return 1;                                                                              \
    typedef void vumat_routine(const int *, const int *, const int *, const int *, const int *, const int *,           \
                               const int *, const REAL *, const REAL *, const REAL *, const char *, const REAL *,      \
                               const REAL *, const REAL *, const REAL *, const REAL *, const REAL *, const REAL *,     \
                               const REAL *, const REAL *, const REAL *, const REAL *, const REAL *, const REAL *,     \
                               const REAL *, const REAL *, const REAL *, const REAL *, const REAL *, REAL *, REAL *,   \
                               REAL *, REAL *, size_t);                                                                \
    vumat_routine *const vumat = (vumat_routine *)(intptr_t)address;                                                   \
    const int nblock = NBLOCK, ndir = 1, nshr = 2, nstatev = NSTATV, none = 0, nprops = NPROPS;                        \
    const REAL props[NPROPS] = {(REAL)SIGMA0, (REAL)GC, (REAL)ETA, (REAL)0.5, 0, 0, 1, 0, 1, 0};                       \
    const REAL time = 1, zero[16 * NBLOCK] = {0}, one[NBLOCK] = {1, 1};                                                \
    const REAL strain[NBLOCK * NTENS] = {(REAL)(part * S0), (REAL)(0.5 * part * S0)};                                  \
    const REAL old[NBLOCK * NSTATV] = {0};                                                                             \
    REAL stress[NBLOCK * NTENS], state[NBLOCK * NSTATV], intern[NBLOCK], inelastic[NBLOCK];                            \
    vumat(&nblock, &ndir, &nshr, &nstatev, &none, &nprops, &none, &time, &time, &time, "JOINT", zero, one, props, one, \
          strain, zero, zero, zero, zero, zero, zero, old, zero, zero, zero, zero, zero, zero, stress, state, intern,  \
          inelastic, 5);                                                                                               \
    return DIFFERS(part * SIGMA0, (double)stress[0], TOLERANCE) +                                                      \
           DIFFERS(0.5 * part * SIGMA0, (double)stress[1], TOLERANCE);                                                 \
  }
CALL_VUMAT(call_single, float, SINGLE_TOLERANCE)
CALL_VUMAT(call_double, double, DOUBLE_TOLERANCE)

static int standard(void) { return call_umat("umat") + call_umat("UMAT"); }
static int explicit_single(void) { return call_single(dlls[2], "vumat") + call_single(dlls[2], "VUMAT"); }
static int explicit_double(void) { return call_double(dlls[3], "vumat") + call_double(dlls[3], "VUMAT"); }

int main(int count, char **arguments) {
  static int (*const tests[])(void) = {standard, explicit_single, explicit_double};
  dlls = arguments;
  if (FAILS(count == 4)) return 1;
  return check_run(sizeof tests / sizeof *tests, tests);
}
