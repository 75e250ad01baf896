#!/bin/sh
# Prints CMake's options for the LLVM Fortran compiler, or nothing where none is installed that links a program.
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
echo end >"$work/a.f90"
for flang in ${FLANG:-flang flang-new flang-new-20 flang-new-19 flang-new-18 flang-new-17 flang-new-16}; do
  command -v "$flang" >/dev/null || continue
  for flags in "" -flang-experimental-exec; do # versions 15 to 17 link on request only
    # shellcheck disable=SC2086  # no flag, or one
    if "$flang" $flags "$work/a.f90" -o "$work/a" 2>/dev/null; then
      echo "-DCMAKE_Fortran_COMPILER=$flang -DCMAKE_Fortran_FLAGS=$flags"
      exit
    fi
  done
done
