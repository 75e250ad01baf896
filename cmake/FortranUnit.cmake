# Kernels of the law. The compiler inlines a procedure if it is a private one of the same module. The parts of the law
# are modules of src/law; here they are merged by text into one module for each kernel, real kind and instruction set.
# The compiler's messages name the parts and their lines.
#
#   asperity_unit(<variable> FROM <folder> PARTS <part>... [LEVEL <v1 or v3>] [SINGLE])
#
# writes the module asperity_<last part> into the folder `merged` of the build, with the other parts as private ones,
# and appends the path to the variable. A part is the module asperity_<part> of the folder. The name ends with the
# level, and in single precision with _single. One part alone may be an external procedure. The file is written when the
# project is configured, which happens again after a change of a part.
function(asperity_unit variable)
  cmake_parse_arguments(PARSE_ARGV 1 UNIT "SINGLE" "FROM;LEVEL" "PARTS")
  list(JOIN UNIT_PARTS "|" merged)
  list(GET UNIT_PARTS -1 last)
  # a function begins with the variables of its caller
  set(uses "")
  set(declarations "")
  set(procedures "")
  foreach(part IN LISTS UNIT_PARTS)
    set(source ${UNIT_FROM}/asperity_${part}.f90)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(READ ${source} text)
    if(part STREQUAL merged)  # nothing to merge
      string(PREPEND text "# 1 \"${source}\"\n")
      break()
    endif()
    string(CONCAT form "\n  implicit none\n  private\n  public ::.*"
      "\n\ncontains\n.*\nend module asperity_${part}\n$")
    if(NOT text MATCHES "${form}")
      message(FATAL_ERROR "${source}: expected `implicit none`, `private` and `public :: ...` after the use "
        "statements, declarations, `contains`, procedures and `end module asperity_${part}`, as for each part of "
        "a kernel")
    endif()
    string(FIND "${text}" "\ncontains\n" at)
    string(SUBSTRING "${text}" 0 ${at} head)
    string(SUBSTRING "${text}" ${at} -1 body)
    string(REGEX MATCHALL "\n" lines "${head}")
    list(LENGTH lines line)
    math(EXPR line "${line} + 3")
    string(REPLACE "\ncontains\n" "\n" body "${body}")
    # what only a module of its own has becomes comments, so that lines keep their numbers
    string(REGEX MATCHALL "\n(module|  use|  implicit|  private|  public)[^\n&]*(&\n[^\n&]*)*" statements "${head}")
    if(part STREQUAL last)
      list(FILTER statements EXCLUDE REGEX "^\n  public")
    else()
      string(REPLACE ", public ::" " ::" head "${head}")
      string(REGEX REPLACE "\nend module [a-z_]*\n$" "\n" body "${body}")
    endif()
    foreach(statement IN LISTS statements)
      if(statement MATCHES "^\n  use" AND NOT statement MATCHES "^\n  use asperity_(${merged}),")
        string(APPEND uses "${statement}")
      endif()
      string(REPLACE "\n" "\n!" comment "${statement}")
      string(REPLACE "${statement}" "${comment}" head "${head}")
    endforeach()
    string(APPEND declarations "# 1 \"${source}\"\n${head}\n")
    string(APPEND procedures "# ${line} \"${source}\"${body}")
    set(text "module asperity_${part}${uses}\n  implicit none\n  private\n${declarations}contains\n${procedures}")
  endforeach()
  set(name asperity_${last})
  if(UNIT_LEVEL)
    string(APPEND name _${UNIT_LEVEL})
    asperity_rename(text _${UNIT_LEVEL} point_kernel block_kernel rows_kernel)
    asperity_rename_use(text width vector_width vector_width_${UNIT_LEVEL})
  endif()
  if(UNIT_SINGLE)
    string(APPEND name _single)
    asperity_rename(text _single types plane_setup block_setup block_kernel block_kernel_v1 block_kernel_v3)
    asperity_rename_use(text kinds wp sp)
    # what is written twice, because its kinds differ, and external procedures
    string(REPLACE "use asperity_block_double," "use asperity_block_single," text "${text}")
    string(REGEX REPLACE "(subroutine |call |routine = \")(vumat|vuinter)([(\n\"])" "\\1\\2_single\\3" text "${text}")
  endif()
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${UNIT_FROM})
  set(written ${PROJECT_BINARY_DIR}/merged/${folder}/${name}.f90)
  file(CONFIGURE OUTPUT ${written} CONTENT "${text}" @ONLY)
  set(${variable} ${${variable}} ${written} PARENT_SCOPE)
endfunction()

# Append an ending to the names of modules in a text.
function(asperity_rename variable ending)
  set(text "${${variable}}")
  foreach(module IN LISTS ARGN)
    string(REGEX REPLACE "(module|use) asperity_${module}([,\n])" "\\1 asperity_${module}${ending}\\2" text "${text}")
  endforeach()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

# Let all lines `use asperity_<module>, only: <name>` of a text take another name of that module, under the same name.
function(asperity_rename_use variable module name other)
  string(REPLACE "use asperity_${module}, only: ${name}\n" "use asperity_${module}, only: ${name} => ${other}\n"
    text "${${variable}}")
  string(REGEX MATCHALL "use asperity_${module}[^\n]*" lines "${text}")
  list(FILTER lines EXCLUDE REGEX ", only: ${name} => ${other}$")
  if(lines)
    message(FATAL_ERROR "${lines}: expected `use asperity_${module}, only: ${name}`, without another name in the line")
  endif()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()
