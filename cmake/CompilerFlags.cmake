# One place for compiler flags, each with its reason.
add_library(asperity_flags INTERFACE)

if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:
    -std=f2008 -Wall -Wextra -Wimplicit-interface -Wconversion   # the standard, and what a reader would ask about
    -frecursive                                                  # no static locals: hosts call from many threads
    -fopenmp-simd                                                # honours !$omp simd, links no run-time library
    >)
  # the loops of the law run on vectors only if a division that is moved may not trap and every function is inlined
  set(ASPERITY_LAW_FLAGS $<$<CONFIG:Release>:-fno-trapping-math> $<$<CONFIG:Release>:-finline-limit=100000>)
  set(debug_flags -O0 -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived -fbacktrace)
  set(CMAKE_Fortran_FLAGS_RELEASE "-O3")
  if(ASPERITY_WERROR)
    target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-Werror>)
  endif()
  target_compile_options(asperity_flags INTERFACE $<$<AND:$<CONFIG:Debug>,$<COMPILE_LANGUAGE:Fortran>>:${debug_flags}>)
elseif(CMAKE_Fortran_COMPILER_ID MATCHES "Flang")
  set(CMAKE_Fortran_FLAGS_RELEASE "-O2")
endif()
if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
  target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:-Wall -Wextra>)
endif()

if(ASPERITY_ARCH)
  # instruction set, e.g. native or x86-64-v3 (AVX2, FMA); empty: the compiler's portable baseline
  target_compile_options(asperity_flags INTERFACE -march=${ASPERITY_ARCH})
endif()

if(ASPERITY_SANITIZE)
  target_compile_options(asperity_flags INTERFACE -fsanitize=${ASPERITY_SANITIZE} -fno-omit-frame-pointer -g)
  target_link_options(asperity_flags INTERFACE -fsanitize=${ASPERITY_SANITIZE})
endif()
if(ASPERITY_COVERAGE)
  # counters that two threads may count up
  set(ASPERITY_COVERAGE_FLAGS --coverage -fprofile-update=atomic -fprofile-abs-path -O0)
endif()
