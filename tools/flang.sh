#!/bin/sh
# Prints CMake's option for LLVM's Fortran compiler, or nothing where version 19 or later is not installed: older ones lack
# polymorphic types.
for flang in ${FLANG:-flang flang-new flang-22 flang-21 flang-20 flang-new-19}; do
  version=$("$flang" --version 2>/dev/null | sed -n '1s/.*flang.* version \([0-9]*\)\..*/\1/p')
  if [ "${version:-0}" -ge 19 ]; then
    echo "-DCMAKE_Fortran_COMPILER=$flang"
    exit
  fi
done
