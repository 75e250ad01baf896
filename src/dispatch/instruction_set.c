/* Choice of the kernels: once, when the library is loaded, by what the processor has. */
#include "asperity.h"

#include <stdlib.h>
#include <string.h>

static int level = 1;

/* Level 3 of the x86-64 psABI, as far as the kernels use it; ASPERITY_ISA=v1 in the environment forbids it. */
__attribute__((constructor)) static void choose(void) {
  const char *wanted = getenv("ASPERITY_ISA");
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("lzcnt") && __builtin_cpu_supports("f16c") &&
      !(wanted && strcmp(wanted, "v1") == 0))
    level = 3;
}

int asperity_isa(void) { return level; }
