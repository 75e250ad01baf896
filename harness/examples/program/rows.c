/* Rows of a case file: slip, dilation and shear traction of every step from the second on. */
#include <asperity_run.h>
#include <stdio.h>

int main(int argc, char **argv) {
  char message[4096];
  asperity_cases *cases = asperity_read_cases(argc > 1 ? argv[1] : "slip.nml", NULL, NULL, 0);
  if (asperity_case_errors(cases, message, sizeof message) > 0) {
    fprintf(stderr, "%s\n", message);
    asperity_free_cases(cases);
    return 1;
  }
  asperity_run *run = asperity_begin(cases, 0, message, sizeof message);
  asperity_free_cases(cases);
  if (!run) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  while (asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 1) {
    if (asperity_value(run, "step") < 2.0) continue;
    printf("%.3f %8.4f %8.4f\n", asperity_value(run, "s_Tx"), asperity_value(run, "s_N"), asperity_value(run, "t_Tx"));
  }
  int lost = asperity_lost(run, message, sizeof message);
  if (lost) fprintf(stderr, "%s%s\n", lost == 1 ? "equilibrium lost: " : "", message);
  asperity_end(run);
  return lost ? 2 : 0;
}
