/* Cohesive user materials of LS-DYNA, umat41c to umat50c: a block of points lft to llt in arrays of nlq.
 *
 * docs/how-to/doors.md describes it. A routine of Fortran in the user's copy of LS-DYNA calls this one, as it alone knows nlq.
 * Components 1 and 2 are Tx and Ty, 3 is N. cm(3..34) has PROPS; aux has STATEV, then the separation at the start, as the
 * program passes the whole one. A block that the law rejects has NaN as tractions. */
#include "asperity.h"
#include <math.h>
#include <stdlib.h>

enum { FIRST = 2, MOST = 32 }; /* place of the first constant in cm, and their number */

void asperity_umatc_(const int *nlq, const int *lft, const int *llt, const double *cm, double *fc, const double *dx,
                     double *aux, double *ek, const double *dt) {
  const size_t stride = *nlq, from = *lft - 1;
  const int n = *llt - *lft + 1, at[3] = {2, 0, 1}; /* N, Tx, Ty */
  const double *props = cm + FIRST;
  double k[2] = {NAN, NAN}, *traction[3], *columns[3];
  const double *increment[3];
  if (n <= 0) return;
  const int nstatv = asperity_nstatv(props, MOST, NULL, 0);
  double *work = calloc(3 * (size_t)n, sizeof(double)), *before = aux + nstatv * stride + from;
  if (work == NULL) abort();
  for (int j = 0; j < 3; j++) {
    increment[j] = columns[j] = work + j * (size_t)n;
    traction[j] = fc + at[j] * stride + from;
    for (int i = 0; i < n && nstatv > 0; i++) columns[j][i] = dx[at[j] * stride + from + i] - before[j * stride + i];
  }
  /* constants that are not admissible: the VUMAT, which this calls, tells why */
  const int status =
      asperity_block(props, MOST, dt[from], n, increment, NULL, (int)stride, nstatv, aux + from, traction);
  for (int j = 0; j < 3 && status == ASPERITY_OK; j++)
    for (int i = 0; i < n; i++) before[j * stride + i] = dx[at[j] * stride + from + i];
  if (status == ASPERITY_OK) asperity_stiffness(props, MOST, k, NULL, 0);
  for (int i = 0; i < n; i++) ek[from + i] = fmax(k[0], k[1]);
  free(work);
}
