# One place for compiler flags, each with its reason.
#
# The target property ASPERITY_SUITE marks what only holds tests (suites and their support): it is compiled for a quick
# build, as its own speed is of no interest and its own errors are not looked for.
add_library(asperity_flags INTERFACE)
set(of_suite $<BOOL:$<TARGET_PROPERTY:ASPERITY_SUITE>>)

if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:
    -std=f2008 -Wall -Wextra -Wimplicit-interface -Wconversion   # the standard, and what a reader would ask about
    -frecursive                                                  # no static locals: hosts call from many threads
    -fopenmp-simd                                                # honours !$omp simd, links no run-time library
    -fno-semantic-interposition                                  # the checks of a call are inlined
    >)
  # The loops of the law run on vectors only if a division that is moved may not trap, every function is inlined,
  # however large its frame, and every structure is replaced by its components. A public kernel is not to be inlined,
  # and its arrays of states are on the stack.
  set(ASPERITY_LAW_FLAGS -fno-trapping-math -fstack-arrays -finline-limit=100000 --param=inline-unit-growth=2000
    --param=large-function-growth=100000 --param=large-stack-frame=100000
    --param=sra-max-scalarization-size-Ospeed=10000 -fsemantic-interposition)
  list(TRANSFORM ASPERITY_LAW_FLAGS REPLACE "(.+)" "$<$<CONFIG:Release>:\\1>")
  # the suites spend most of their time in the kernels, and few seconds more to compile them pay
  list(APPEND ASPERITY_LAW_FLAGS $<$<CONFIG:Debug>:-O1>)
  set(debug_flags -O0 -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived
    -fbacktrace)
  set(CMAKE_Fortran_FLAGS_RELEASE "-O3")
  target_compile_options(asperity_flags INTERFACE $<$<AND:${of_suite},$<CONFIG:Release>>:-O1>)
  if(ASPERITY_WERROR)
    target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-Werror>)
  endif()
  target_compile_options(asperity_flags INTERFACE $<$<AND:$<CONFIG:Debug>,$<COMPILE_LANGUAGE:Fortran>>:${debug_flags}>)
elseif(CMAKE_Fortran_COMPILER_ID MATCHES "Flang")
  set(CMAKE_Fortran_FLAGS_RELEASE "-O2")
  target_compile_options(asperity_flags INTERFACE $<$<AND:${of_suite},$<COMPILE_LANGUAGE:Fortran>>:-O0>)
elseif(CMAKE_Fortran_COMPILER_ID MATCHES "Intel")
  # it obeys !$omp simd unasked, and takes what the loops assign for shared; not tried, as this compiler was not to be
  # had
  target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:Fortran>:-qno-openmp-simd>)
endif()
if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
  target_compile_options(asperity_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:-Wall -Wextra>)
endif()

if(ASPERITY_SANITIZE)
  # without -fno-sanitize-recover undefined behaviour is printed, and the suite passes; in Fortran the address sanitizer
  # finds null pointers as well, the compiler aligns what it declares, and an assignment to an array that is not
  # allocated subtracts 1 from its undefined lower bound before it looks whether there is an array; an address that
  # wraps around is out of bounds, which is checked, and to look for it takes half of the time to compile
  target_compile_options(asperity_flags INTERFACE
    "$<$<NOT:${of_suite}>:-fsanitize=${ASPERITY_SANITIZE};-fno-sanitize-recover=all;-fno-omit-frame-pointer;-g>"
    "$<$<COMPILE_LANGUAGE:Fortran>:-fno-sanitize=null,alignment,object-size,signed-integer-overflow,pointer-overflow>")
  target_link_options(asperity_flags INTERFACE -fsanitize=${ASPERITY_SANITIZE})
endif()
if(ASPERITY_COVERAGE)
  # the library alone is measured; its counters are those of one thread (atomic ones take two thirds of the time)
  set(ASPERITY_COVERAGE_FLAGS --coverage -fprofile-abs-path)
endif()
