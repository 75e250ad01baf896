// The C headers compile in C++, and their names link.
#include "asperity.h"
#include "asperity_run.h"
#include "check.h"

static int names_link_from_cpp() {
  const double props[] = {3.0, 0.3, 0.9, 0.5};
  return FAILS(asperity_version(nullptr, 0) > 0) +
         FAILS(asperity_nstatv(props, 4, nullptr, 0) == POINT_STATEV + PLANE_STATEV) + FAILS(&umat_ != nullptr) +
         FAILS(&vumat_ != nullptr) + FAILS(&vumat_single_ != nullptr);
}

static int names_of_runs_link_from_cpp() {
  char message[200], events[ASPERITY_EVENTS];
  double numbers[6];
  const double props[] = {3.0, 0.3, 0.9, 0.5}, tangent[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  asperity_cases *cases = asperity_read_cases(nullptr, "&step s_N = 0.1, increments = 2 /", props, 4);
  int bad = FAILS(asperity_case_errors(cases, message, sizeof message) == 0) +
            FAILS(asperity_case_content(cases, nullptr, 0) > 0) + FAILS(asperity_tables(nullptr, 0) > 0);
  asperity_run *run = asperity_begin(cases, 0, message, sizeof message);
  asperity_free_cases(cases);
  bad += FAILS(asperity_next(run, 1, 6, numbers, 0, nullptr, events) == 1) + FAILS(numbers[0] == 1.0);
  bad += FAILS(asperity_value(run, "s_N") == 0.05) + FAILS(asperity_lost(run, message, sizeof message) == 0);
  asperity_end(run);
  return bad + FAILS(asperity_stability_of(props, 4, 1, tangent, numbers) == ASPERITY_OK);
}

int main() {
  int (*const tests[])() = {names_link_from_cpp, names_of_runs_link_from_cpp};
  return check_run(2, tests);
}
