# Test suites: genuine pFUnit files (.pf), run by pFUnit where it is found, elsewhere by the stand-in in
# tests/pfunit_stand_in.
#
#   asperity_add_suite(<name> TEST_SOURCES <a.pf> [LINK_LIBRARIES <lib>...] [OTHER_SOURCES ...] [LABELS ...]
#                      [WORKING_DIRECTORY <dir>])
#
# builds the executable <name> and the CTest test <name> (label: suite), which fails when an assertion fails and when no
# test ran.
#
# pFUnit 4.14 is found through -DPFUNIT_DIR=<prefix>/PFUNIT-4.14/cmake or CMAKE_PREFIX_PATH; its modules must come from
# the same compiler. -DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON selects the stand-in in any case.

include_guard(GLOBAL)

set(ASPERITY_PF_SUPPORT ${CMAKE_CURRENT_LIST_DIR}/../tests/pfunit_stand_in)
cmake_path(NORMAL_PATH ASPERITY_PF_SUPPORT)
find_package(Python3 3.10 REQUIRED COMPONENTS Interpreter)

set(_pfunit_dir "${PFUNIT_DIR}")
find_package(PFUNIT 4.14 QUIET)
if(_pfunit_dir AND NOT PFUNIT_FOUND)
  message(FATAL_ERROR "PFUNIT_DIR is ${_pfunit_dir}: expected the folder of PFUNITConfig.cmake of pFUnit 4.14 or later")
endif()

if(PFUNIT_FOUND)
  message(STATUS "Test suites: pFUnit ${PFUNIT_VERSION}, ${PFUNIT_DIR}")
else()
  message(STATUS "Test suites: pFUnit not found, its stand-in in tests/pfunit_stand_in")
  add_library(asperity_funit STATIC EXCLUDE_FROM_ALL ${ASPERITY_PF_SUPPORT}/funit.f90)
  set_target_properties(asperity_funit PROPERTIES
    ASPERITY_SUITE ON
    Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/mod/funit)
  target_include_directories(asperity_funit PUBLIC ${CMAKE_CURRENT_BINARY_DIR}/mod/funit)

  # The call of pFUnit, without its MPI and its hooks.
  function(add_pfunit_ctest name)
    cmake_parse_arguments(PARSE_ARGV 1 PF "" "WORKING_DIRECTORY" "TEST_SOURCES;OTHER_SOURCES;LINK_LIBRARIES;LABELS")
    if(PF_UNPARSED_ARGUMENTS OR NOT PF_TEST_SOURCES)
      message(FATAL_ERROR "add_pfunit_ctest(${name}): no TEST_SOURCES, or unknown argument: ${PF_UNPARSED_ARGUMENTS}")
    endif()
    list(TRANSFORM PF_TEST_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    set(translated ${CMAKE_CURRENT_BINARY_DIR}/${name}_pf.F90)
    add_custom_command(
      OUTPUT ${translated}
      COMMAND Python3::Interpreter ${ASPERITY_PF_SUPPORT}/pf2f90.py ${PF_TEST_SOURCES} -o ${translated}
      DEPENDS ${PF_TEST_SOURCES} ${ASPERITY_PF_SUPPORT}/pf2f90.py
      VERBATIM)
    add_executable(${name} ${translated} ${PF_OTHER_SOURCES})
    set(modules ${CMAKE_CURRENT_BINARY_DIR}/mod/${name})
    set_target_properties(${name} PROPERTIES Fortran_MODULE_DIRECTORY ${modules})
    target_include_directories(${name} PRIVATE ${modules})
    target_link_libraries(${name} PRIVATE ${PF_LINK_LIBRARIES} asperity_funit)
    if(NOT PF_WORKING_DIRECTORY)
      set(PF_WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
    endif()
    add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PF_WORKING_DIRECTORY})
    set_tests_properties(${name} PROPERTIES LABELS "${PF_LABELS}")
  endfunction()
endif()

function(asperity_add_suite name)
  cmake_parse_arguments(PARSE_ARGV 1 PF "" "" "TEST_SOURCES;OTHER_SOURCES;LINK_LIBRARIES;LABELS;WORKING_DIRECTORY")
  foreach(file IN LISTS PF_TEST_SOURCES)
    if(IS_ABSOLUTE ${file})
      message(FATAL_ERROR "asperity_add_suite(${name}): ${file} must be relative, pFUnit writes beside an absolute one")
    endif()
  endforeach()
  add_pfunit_ctest(${ARGV})
  # what is generated has directives
  set_target_properties(${name} PROPERTIES ASPERITY_SUITE ON Fortran_PREPROCESS ON)
  set_property(TEST ${name} APPEND PROPERTY LABELS suite)
  if(PFUNIT_FOUND)
    # pFUnit passes over what it does not understand: check first.
    list(TRANSFORM PF_TEST_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    set(checked ${CMAKE_CURRENT_BINARY_DIR}/${name}.checked)
    add_custom_command(
      OUTPUT ${checked}
      COMMAND Python3::Interpreter ${ASPERITY_PF_SUPPORT}/pf2f90.py ${PF_TEST_SOURCES}
      COMMAND ${CMAKE_COMMAND} -E touch ${checked}
      DEPENDS ${PF_TEST_SOURCES} ${ASPERITY_PF_SUPPORT}/pf2f90.py
      VERBATIM)
    target_sources(${name} PRIVATE ${checked})
    # What pFUnit generates is not ours to keep free of warnings.
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:Fortran,GNU>:-w>)
    # pFUnit calls a suite without tests OK.
    set_property(TEST ${name} APPEND PROPERTY FAIL_REGULAR_EXPRESSION "\\(0 tests?[,)]")
  endif()
endfunction()
