/* Choice of the kernels: once, when the library is loaded, by what the processor has. */
#include <stdlib.h>
#include <string.h>

int asperity_isa(void);

static int level = 1;

/* Levels 3 and 4 of the x86-64 psABI, as far as compilers use them in the kernels. ASPERITY_ISA (v1, v3, v4) lowers the
   level; a level that the processor does not have is not taken. */
__attribute__((constructor)) static void choose(void)
{
  const char *wanted = getenv("ASPERITY_ISA");
  int limit = 4;
  if (wanted && strcmp(wanted, "v1") == 0)
    limit = 1;
  else if (wanted && strcmp(wanted, "v3") == 0)
    limit = 3;
  __builtin_cpu_init();
  if (limit >= 3 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    level = 3;
  if (limit >= 4 && level == 3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    level = 4;
}

int asperity_isa(void)
{
  return level;
}
