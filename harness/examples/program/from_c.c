/* One elastic update through the installed header and library. */
#include <asperity.h>
#include <math.h>
#include <stdio.h>

int main(void) {
  const double sigma0 = 3.0, gc = 0.3, eta = 0.9, mu = 0.5, props[] = {3.0, 0.3, 0.9, 0.5};
  const double s0 = (1.0 - eta) * 2.0 * gc / sigma0, s[3] = {0.5 * s0, 0.0, 0.0};
  double state[11] = {0}, traction[3];
  char message[256] = "";
  if (asperity_update(props, 4, 0.0, 1, NULL, s, NULL, NULL, 11, state, traction, NULL, message, sizeof message) !=
          ASPERITY_OK ||
      fabs(traction[0] - 0.5 * sigma0) > 1e-14 * sigma0) {
    fprintf(stderr, "mu = %g: t_N = %.17g, expected %.17g. %s\n", mu, traction[0], 0.5 * sigma0, message);
    return 1;
  }
  return 0;
}
