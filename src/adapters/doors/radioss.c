/* User library of OpenRadioss: the law for /MAT/USER01 to /MAT/USER99 on connection elements, /PROP/TYPE43.
 *
 * docs/how-to/radioss.md describes it. ZZ is N, ZX is Tx, YZ is Ty. The card has PROPS after the line of the density. UVAR
 * is STATEV as in Abaqus/Explicit, by columns of the block: 6 to 8 have the whole separation. The stresses at the start are
 * read for the initial traction. A call that the law rejects ends the run with exit code 2. */
#include "asperity.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* The element assigns the stiffness of one of its four points to all of them; a fifth more for corners that are not alike. */
static const double POINTS = 4.0 * 1.2;

enum { CLOSURE = 20, DASHPOT = 23 }; /* places in PROPS */

/* Arrays of the block that the next call of this thread updates: N, Tx, Ty. */
static _Thread_local const double *increment[3], *start[3];
static _Thread_local double *end[3];

static void stop(const char *form, ...) {
  va_list values;
  va_start(values, form);
  fputs("asperity radioss: ", stderr);
  vfprintf(stderr, form, values);
  fputs("\n", stderr);
  va_end(values);
  exit(2);
}

/* Starter: read the card of a material, a file of the starter, into UPARAM, and write the lines for its listing. */
void st_lecm99_(const int *law, const char *root, const int *length, const int *number, double *uparam, const int *most,
                int *nuparam, int *nuvar, int *functions, const int *most_functions, int *nfunc, double *parmat) {
  char name[4200], message[4000] = "";
  double value, k[2];
  int n = 0, found;
  (void)functions, (void)most_functions;
  snprintf(name, sizeof name, "SI%.*s_%04d.scr", *length, root, *law);
  FILE *file = fopen(name, "r");
  if (file == NULL) stop("%s: expected the card of /MAT/USER%02d, which the starter writes", name, *number);
  while ((found = fscanf(file, "%lf", &value)) == 1) {
    if (n == *most) stop("/MAT/USER%02d: expected at most %d constants", *number, *most);
    uparam[n++] = value;
  }
  if (found != EOF)
    stop("/MAT/USER%02d: expected blanks between numbers behind constant %d, as 1.5 2.0e-3", *number, n);
  fclose(file);
  if (asperity_stiffness(uparam, n, k, message, sizeof message) != ASPERITY_OK)
    stop("/MAT/USER%02d: %s", *number, message);
  if ((n > CLOSURE && uparam[CLOSURE] > 0.0) || (n > DASHPOT && uparam[DASHPOT] > 0.0))
    stop("/MAT/USER%02d: closure (constant %d), c (%d): expected 0, as the time step needs a largest stiffness",
         *number, CLOSURE + 1, DASHPOT + 1);
  *nuparam = n;
  *nuvar = asperity_nstatv(uparam, n, NULL, 0);
  *nfunc = 0;
  parmat[0] = k[0];
  snprintf(name, sizeof name, "SO%.*s_%04d.scr", *length, root, *law);
  if ((file = fopen(name, "w")) == NULL) stop("%s: expected a folder that can be written", name);
  asperity_version(message, sizeof message);
  fprintf(file, "     asperity %s, /MAT/USER%02d: %d CONSTANTS, %d UVAR, STIFFNESS %g IN N, %g IN T\n", message,
          *number, n, *nuvar, k[0], k[1]);
  fclose(file);
}

/* Engine: the arrays of the block of the next call. Components that an element does not have are one array. */
void eng_get_law_user_var_(int *ncycle, int *imat, int *iptr, int *ipts, int *iptt, double *r11, double *r12,
                           double *r13, double *r21, double *r22, double *r23, double *r31, double *r32, double *r33,
                           double *so1, double *so2, double *so3, double *so4, double *so5, double *so6, double *ep1,
                           double *ep2, double *ep3, double *ep4, double *ep5, double *ep6, double *es1, double *es2,
                           double *es3, double *es4, double *es5, double *es6, double *de1, double *de2, double *de3,
                           double *de4, double *de5, double *de6, double *rho0, double *s1, double *s2, double *s3,
                           double *s4, double *s5, double *s6) {
  (void)ncycle, (void)imat, (void)iptr, (void)ipts, (void)iptt, (void)r11, (void)r12, (void)r13, (void)r21, (void)r22;
  (void)r23, (void)r31, (void)r32, (void)r33, (void)so1, (void)so2, (void)so4, (void)ep1, (void)ep2, (void)ep3;
  (void)ep4, (void)ep5, (void)ep6, (void)es1, (void)es2, (void)es3, (void)es4, (void)es5, (void)es6, (void)de1;
  (void)de2, (void)de4, (void)rho0;
  if (s1 != s2 || s1 != s4) stop("expected elements of /PROP/TYPE43: others have stresses in their plane");
  increment[0] = de3, increment[1] = de6, increment[2] = de5;
  start[0] = so3, start[1] = so6, start[2] = so5;
  end[0] = s3, end[1] = s6, end[2] = s5;
}

/* Engine: stresses, state and speed of sound of a block of points at the end of a cycle. */
void eng_sigeps99_(const int *nel, const int *nuparam, const int *nuvar, const int *law, const int *nfunc,
                   const int *ifunc, const int *npf, const double *tf, const double *time, const double *dt,
                   const double *uparam, const double *rho, const double *volume, const double *eint, const int *ngl,
                   double *soundsp, double *viscmax, double *uvar, const double *off, double *sigy, double *pla) {
  const int n = *nel;
  double k[2];
  char message[4000] = "";
  (void)law, (void)nfunc, (void)ifunc, (void)npf, (void)tf, (void)volume, (void)eint, (void)off;
  if (asperity_stiffness(uparam, *nuparam, k, message, sizeof message) != ASPERITY_OK) stop("%s", message);
  if (asperity_block(uparam, *nuparam, *dt, n, increment, start, n, *nuvar, uvar, end) != ASPERITY_OK)
    stop("time %g, elements %d to %d: the law rejects their increments, as said above", *time, ngl[0], ngl[n - 1]);
  for (int i = 0; i < n; i++) {
    if (!(rho[i] > 0.0)) stop("element %d: density %g: expected > 0, as the time step needs a mass", ngl[i], rho[i]);
    soundsp[i] = sqrt(POINTS * fmax(k[0], k[1]) / rho[i]);
    viscmax[i] = 0.0;
    sigy[i] = 0.0;
    pla[i] = uvar[i]; /* the damage, for plots */
  }
}

void eng_set_law_user_var_(void) {}

/* Windows: functions of the program, none of which is called. */
void set_callback(void **functions) { (void)functions; }

/* A number below that of libraries with further calls. */
void userlib_id(int *id) { *id = 1; }

/* The programs ask for these names; a deck that needs one of them is refused. */
#define REFUSED(name, what)                                                                       \
  void name(void) { stop(what ": this library has /MAT/USER01 to USER99 on /PROP/TYPE43 only"); }
REFUSED(st_lecg_, "user property")
REFUSED(st_lecguser_, "user property")
REFUSED(st_lecm_, "/MAT/USER1 to USER3, of one digit")
REFUSED(st_lecr_, "user failure")
REFUSED(st_lecsen_, "user sensor")
REFUSED(st_riniuser_, "user spring")
REFUSED(st_siniusr_, "user solid")
REFUSED(st_userwis_, "user window")
REFUSED(st_userwis_ini_, "user window")
REFUSED(eng_ruser_, "user spring")
REFUSED(eng_sigeps_, "/MAT/USER1 to USER3, of one digit")
REFUSED(eng_sigepsc_, "/MAT/USER1 to USER3, of one digit")
REFUSED(eng_flaw_, "user failure")
REFUSED(eng_flawc_, "user failure")
REFUSED(eng_suser_, "user solid")
REFUSED(eng_userint_, "user interface")
REFUSED(eng_get_uintbuf_var_, "user interface")
REFUSED(eng_userwi_, "user window")
REFUSED(eng_user_sens_, "user sensor")
REFUSED(eng_get_lawc_user_var_, "user material of shells")
REFUSED(eng_sigeps99c_, "user material of shells")
REFUSED(eng_set_lawc_user_var_, "user material of shells")
void st_get_userbuf_var_(void) {}
