# cmake -DOUTPUT=<file> -DSOURCES=<a.f90|b.f90...> -DVERSION=<version> -DABOUT=<line> -P single_file.cmake
#
# Writes one free-form source for the user subroutine of a host: SOURCES in their order, `include` lines replaced by the
# files they name (beside one of the sources), vumat_single named as hosts call it, without directives of OpenMP.
string(REPLACE "|" ";" sources "${SOURCES}")

# the first line is a directive of Intel's compilers: free form, whatever the extension and the options say
set(text "!DIR$ FREEFORM
! ${ABOUT}
! asperity ${VERSION}: interface law for rough quasi-brittle interfaces. BSD 3-Clause License, see the project.
! Written by the build from src/: change it there.
! Local arrays must not be static, as solvers call from many threads: Intel -auto, gfortran -frecursive.
")
set(folders "")
foreach(source IN LISTS sources)
  get_filename_component(folder ${source} DIRECTORY)
  list(APPEND folders ${folder})
endforeach()
list(REMOVE_DUPLICATES folders)
foreach(source IN LISTS sources)
  file(READ ${source} part)
  while(part MATCHES "\n *include \"([^\"\n]+)\" *\n")
    set(line "${CMAKE_MATCH_0}")
    set(name "${CMAKE_MATCH_1}")
    find_file(place ${name} PATHS ${folders} NO_DEFAULT_PATH NO_CACHE REQUIRED)
    file(READ ${place} included)
    unset(place)
    string(REPLACE "${line}" "\n${included}" part "${part}")
  endwhile()
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
string(REPLACE "vumat_single" "vumat" text "${text}")
file(WRITE ${OUTPUT} "${text}")
