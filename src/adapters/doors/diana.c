/* USRIFC, the user-supplied interface of DIANA: the UMAT of the library on separations.
 *
 * docs/how-to/doors.md describes it. Components are those of the UMAT: normal, then one or two shears; TRA is the traction
 * at the start, and at the end; STIFF the consistent tangent. USRVAL has PROPS, USRSTA has STATEV. TRA of the first call of
 * a point is its initial traction. */
#include "asperity.h"
#include <stdlib.h>
#include <string.h>

enum { THICKNESS = 8 }; /* place of h in PROPS, which is 1 here */

void usrifc_(const double *u0, const double *du, const int *nt, const double *age0, const double *dtime,
             const double *temp0, const double *dtemp, const int *elemen, const int *intpt, const double *coord,
             const double *se, const int *iter, const char *usrmod, const double *usrval, const int *nuv,
             double *usrsta, const int *nus, int *usrind, const int *nui, double *tra, double *stiff) {
  const int ndi = 1, nshr = *nt - 1, step = 1;
  const size_t n = *nuv > 0 ? *nuv : 0;
  double energies[3], *props = calloc(n + 1, sizeof(double));
  (void)age0, (void)temp0, (void)dtemp, (void)coord, (void)se, (void)iter, (void)usrind, (void)nui;
  if (props == NULL) abort();
  memcpy(props, usrval, n * sizeof(double));
  if (n > THICKNESS) props[THICKNESS] = 1.0;
  umat_(tra, usrsta, stiff, &energies[0], &energies[1], &energies[2], NULL, NULL, NULL, NULL, u0, du, NULL, dtime, NULL,
        NULL, NULL, NULL, usrmod, &ndi, &nshr, nt, nus, props, nuv, NULL, NULL, NULL, NULL, NULL, NULL, elemen, intpt,
        NULL, NULL, &step, &step);
  free(props);
}
