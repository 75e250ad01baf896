// The C header compiles in C++, and its names link.
#include "asperity.h"
#include "check.h"

static int names_link_from_cpp() {
  const double props[] = {3.0, 0.3, 0.9, 0.5};
  return FAILS(asperity_version(nullptr, 0) > 0) +
         FAILS(asperity_nstatv(props, 4, nullptr, 0) == POINT_STATEV + PLANE_STATEV) + FAILS(&umat_ != nullptr) +
         FAILS(&vumat_ != nullptr) + FAILS(&vumat_single_ != nullptr);
}

int main() {
  int (*const tests[])() = {names_link_from_cpp};
  return check_run(1, tests);
}
