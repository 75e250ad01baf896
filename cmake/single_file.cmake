# cmake -DOUTPUT=<file> -DSOURCES=<a.f90|b.f90...> -DVERSION=<version> -DABOUT=<line> -P single_file.cmake
#
# Writes one free-form source for the user subroutine of a host: SOURCES in their order, vumat_single and vuinter_single
# named as hosts call them, without directives of OpenMP.
string(REPLACE "|" ";" sources "${SOURCES}")

# the first line is a directive of Intel's compilers: free form, whatever the extension and the options say
set(text "!DIR$ FREEFORM
! ${ABOUT}
! asperity ${VERSION}: interface law for rough quasi-brittle interfaces. BSD 3-Clause License, see the project.
! Written by the build from src/: change it there.
! Local arrays must not be static, as solvers call from many threads: Intel -auto, gfortran -frecursive.
")
foreach(source IN LISTS sources)
  file(READ ${source} part)
  if(source MATCHES "/asperity_report[.]f90$")
    # the routines of Abaqus/Explicit have other names
    string(REPLACE "asperity_report\n" "asperity_report_explicit\n" explicit "${part}")
    string(REPLACE "Abaqus/Standard" "Abaqus/Explicit" explicit "${explicit}")
    string(REPLACE "stdb_abqerr" "xplb_abqerr" explicit "${explicit}")
    string(REPLACE "xit()" "xplb_exit()" explicit "${explicit}")
    string(REPLACE "subroutine xit\n" "subroutine xplb_exit\n" explicit "${explicit}")
    if(NOT SOURCES MATCHES "/asperity_umat[.]f90")
      set(part "")
    endif()
    if(SOURCES MATCHES "/asperity_vumat")
      string(APPEND part "\n${explicit}")
    endif()
  elseif(source MATCHES "/asperity_vumat")
    string(REPLACE "use asperity_report, " "use asperity_report_explicit, " part "${part}")
  endif()
  string(APPEND text "\n${part}")
endforeach()
# marks and comments that FortranUnit.cmake puts into merged modules
string(REGEX REPLACE "\n(# [0-9]+ \"|!module|!  )[^\n]*" "" text "${text}")
# Intel's compilers obey `omp simd` without being asked to, and wrong results of ifx with it were reported
string(REGEX REPLACE "\n *!\\$omp[^\n]*" "" text "${text}")
# Abaqus runs a preprocessor, to which an apostrophe in a comment may begin a text
while(text MATCHES "!([^\n\"]*)'")
  string(REGEX REPLACE "!([^\n\"]*)'" "!\\1`" text "${text}")
endwhile()
string(REGEX REPLACE "(vumat|vuinter)_single" "\\1" text "${text}")
file(WRITE ${OUTPUT} "${text}")
