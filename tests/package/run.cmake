# This script installs the library to a fresh prefix, checks the exported symbols, and builds and runs the foreign
# project. CTest calls it with WORK, SOURCES, BINARY_DIR, LIBRARY, NM, GENERATOR, C_COMPILER, FORTRAN_COMPILER,
# FORTRAN_FLAGS.
set(prefix ${WORK}/prefix)
set(build ${WORK}/build)
set(passed 0)
file(REMOVE_RECURSE ${WORK})

function(finish failed)
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${passed} passed, ${failed} failed")
  if(failed)
    message(FATAL_ERROR "the installed package does not serve a foreign project")
  endif()
endfunction()

# A step is a test. The first step that fails ends the run, because later steps depend on it. The variable `output` is
# set.
macro(step name)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message("${name} failed (${result}):\n${output}")
    finish(1)
  endif()
  math(EXPR passed "${passed} + 1")
endmacro()

step(install ${CMAKE_COMMAND} --install ${BINARY_DIR} --prefix ${prefix})

file(GLOB_RECURSE library ${prefix}/${LIBRARY})
step(exports ${NM} -D --defined-only ${library})
foreach(symbol umat_ vumat_ vumat_single_ asperity_version asperity_isa asperity_nstatv asperity_initial_state
    asperity_update asperity_iterate asperity_planes asperity_warn asperity_slip_increment asperity_joint)
  if(NOT output MATCHES " T ${symbol}\n")
    message("${LIBRARY} does not export ${symbol}:\n${output}")
    finish(1)
  endif()
endforeach()

step(configure ${CMAKE_COMMAND} -S ${prefix}/share/doc/asperity/example -B ${build} -G ${GENERATOR}
     -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_Fortran_COMPILER=${FORTRAN_COMPILER}
     -DCMAKE_Fortran_FLAGS=${FORTRAN_FLAGS})
step(build ${CMAKE_COMMAND} --build ${build})
step(from_c ${build}/from_c)
step(rows ${build}/rows ${prefix}/share/doc/asperity/example/slip.nml)
if(NOT output MATCHES "\n0.600 +0.3455 +0.7573\n")
  message("the example of docs/reference/c.md prints other rows:\n${output}")
  finish(1)
endif()
foreach(name example example_static)
  step(${name} ${build}/${name})
  if(NOT output MATCHES "^ +0.0000 +2.5000 +0.0000")
    message("the example of docs/reference/c.md prints another traction:\n${output}")
    finish(1)
  endif()
endforeach()
file(GLOB_RECURSE license ${prefix}/*/LICENSE)
if(NOT license)
  message("no LICENSE in ${prefix}")
  finish(1)
endif()

# the package is used where the compiler of this build is not
file(GLOB_RECURSE targets ${prefix}/*/asperityTargets*.cmake)
foreach(file IN LISTS targets)
  file(STRINGS ${file} absolute REGEX "[\"; ]/[a-z]")
  if(absolute)
    message("${file} has a path of this machine: ${absolute}")
    finish(1)
  endif()
endforeach()

# as a part of another project: the targets exist, and the flags of asperity are not those of the project
step(configure_fetched ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/fetched -B ${WORK}/fetched -G ${GENERATOR}
     -DSOURCES=${SOURCES} -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_Fortran_COMPILER=${FORTRAN_COMPILER}
     -DCMAKE_Fortran_FLAGS=${FORTRAN_FLAGS})
file(STRINGS ${WORK}/fetched/compile_commands.json own REGEX "\"command\".*example.f90")
list(FILTER own INCLUDE REGEX "-std=|-Wall")
if(own)
  message("the flags of asperity are those of another project, too: ${own}")
  finish(1)
endif()

# the lines of docs/reference/c.md for a C compiler alone
get_filename_component(where ${library} DIRECTORY)
set(options -I${prefix}/include -L${where} -Wl,-rpath,${where})
step(build_by_line ${C_COMPILER} ${SOURCES}/harness/examples/program/from_c.c ${options} -lasperity -lm
     -o ${WORK}/from_c)
step(run_by_line ${WORK}/from_c)
file(GLOB run_library ${where}/libasperity_run.*)
if(run_library)
  step(build_rows_by_line ${C_COMPILER} ${SOURCES}/harness/examples/program/rows.c ${options} -lasperity_run -lasperity
       -o ${WORK}/rows)
  step(run_rows_by_line ${WORK}/rows ${SOURCES}/harness/examples/program/slip.nml)
  if(NOT output MATCHES "\n0.600 +0.3455 +0.7573\n")
    message("the example of docs/reference/c.md, linked by hand, prints other rows:\n${output}")
    finish(1)
  endif()
endif()

find_program(PKG_CONFIG NAMES pkg-config pkgconf)
if(PKG_CONFIG)
  file(GLOB_RECURSE pc ${prefix}/*/asperity.pc)
  get_filename_component(folder ${pc} DIRECTORY)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  step(pkg_config ${PKG_CONFIG} --cflags --libs asperity)
  separate_arguments(flags UNIX_COMMAND "${output}")
  step(build_by_pkg_config ${C_COMPILER} ${SOURCES}/harness/examples/program/from_c.c ${flags} -Wl,-rpath,${where} -lm
       -o ${WORK}/by_pkg_config)
  step(run_by_pkg_config ${WORK}/by_pkg_config)
  # and from the archive alone
  step(pkg_config_static ${PKG_CONFIG} --cflags --libs --static asperity)
  file(GLOB_RECURSE archive ${prefix}/*/libasperity.a)
  string(REPLACE "-lasperity" "\"${archive}\"" output "${output}")
  separate_arguments(flags UNIX_COMMAND "${output}")
  step(build_static_by_pkg_config ${C_COMPILER} ${SOURCES}/harness/examples/program/from_c.c ${flags} -o ${WORK}/static)
  step(run_static_by_pkg_config ${WORK}/static)
endif()
finish(0)
