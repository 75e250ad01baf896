/* What the doors of explicit hosts share: increments of a block of points by columns, and the largest stiffnesses. */
#include "asperity.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { THICKNESS = 8 }; /* place of h in PROPS, which is 1 here: hosts of this kind pass separations */

/* Call the VUMAT for n points. Columns of n: strain (N, Ty, Tx as tensor components), stress at the start and at the end,
 * state at the start and at the end. rest: 7 columns of zeros. */
static void call(const double *props, int nprops, double total_time, double dt, int n, int nstatv, const double *strain,
                 const double *old, const double *state_old, double *state, double *stress, double *rest) {
  const int ndir = 1, nshr = 2, none = 0;
  vumat_(&n, &ndir, &nshr, &nstatv, &none, &nprops, &none, &total_time, &total_time, &dt, " ", rest, rest, props, rest,
         strain, rest, rest, rest, rest, rest, old, state_old, rest, rest, rest, rest, rest, rest, stress, state,
         rest + 5 * (size_t)n, rest + 6 * (size_t)n);
}

int asperity_block(const double *props, int nprops, double dt, int n, const double *const increment[3],
                   const double *const old[3], int stride, int nstatv, double *state, double *const traction[3]) {
  if (n <= 0) return ASPERITY_OK;
  const size_t rows = n, column = rows * sizeof(double), of_state = rows * (nstatv > 0 ? nstatv : 0);
  const size_t of_props = nprops > 0 ? nprops : 0;
  double *work = calloc(of_props + 16 * rows + 2 * of_state, sizeof(double));
  if (work == NULL) return ASPERITY_BAD_SIZE;
  double *const constants = work, *const strain = constants + of_props, *const before = strain + 3 * rows,
                *const after = before + 3 * rows, *const rest = after + 3 * rows, *const state_old = rest + 7 * rows,
                *const state_new = state_old + of_state;
  const int at[3] = {0, 2, 1}; /* columns of N, Tx, Ty in Abaqus/Explicit */
  memcpy(constants, props, of_props * sizeof(double));
  if (nprops > THICKNESS) constants[THICKNESS] = 1.0;
  for (int j = 0; j < 3; j++) {
    for (size_t i = 0; i < rows; i++) strain[at[j] * rows + i] = (j == 0 ? 1.0 : 0.5) * increment[j][i];
    if (old != NULL) memcpy(before + at[j] * rows, old[j], column);
  }
  for (int j = 0; j < nstatv; j++) memcpy(state_old + j * rows, state + (size_t)j * stride, column);
  call(constants, nprops, 1.0, dt, n, nstatv, strain, before, state_old, state_new, after, rest);
  for (int j = 0; j < 3; j++) memcpy(traction[j], after + at[j] * rows, column);
  /* a rejected block is all NaN, and its state is that of the start */
  for (int j = 0; j < nstatv; j++) memcpy(state + (size_t)j * stride, state_new + j * rows, column);
  const int rejected = isnan(after[0]);
  free(work);
  return rejected ? ASPERITY_BAD_STATE : ASPERITY_OK;
}

int asperity_stiffness(const double *props, int nprops, double stiffness[2], char *message, int size) {
  /* the VUMAT shows the stiffness of a closed joint in the elastic response to a unit of each component */
  static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5}, none[9];
  double k[9], rest[21] = {0};
  const int nstatv = asperity_nstatv(props, nprops, message, size);
  if (nstatv == 0) return ASPERITY_BAD_PROPS;
  double *work = calloc((size_t)nprops + 6 * (size_t)nstatv, sizeof(double));
  if (work == NULL) return ASPERITY_BAD_SIZE;
  memcpy(work, props, nprops * sizeof(double));
  if (nprops > THICKNESS) work[THICKNESS] = 1.0;
  call(work, nprops, 0.0, 0.0, 3, nstatv, unit, none, work + nprops, work + nprops + 3 * nstatv, k, rest);
  free(work);
  /* sums of the magnitudes of rows: no direction is stiffer */
  double sum[3];
  for (int i = 0; i < 3; i++) sum[i] = fabs(k[3 * i]) + fabs(k[3 * i + 1]) + fabs(k[3 * i + 2]);
  stiffness[0] = sum[0];
  stiffness[1] = fmax(sum[1], sum[2]);
  return ASPERITY_OK;
}
