"""The file abaqus_v6.env, which tells Abaqus how to compile and link user subroutines."""

ENVIRONMENT = r"""# abaqus_v6.env: which compiler translates the user subroutines. Abaqus reads
# this file from the folder of the job, after its own (SMA/site/lnx86_64.env, win86_64.env). It is Python,
# of version 2 in older releases.
#
# NOT RUN: asperity was written without Abaqus and without Intel's compilers. With the list for gfortran on
# Linux the tests of asperity compile and link the sources; all others follow manuals and reports of users.
#
# "ifort", "ifx" or "gfortran"; "" leaves the compiler of your installation.
asperity_compiler = ""

import sys

asperity_windows = sys.platform.startswith("win")

if asperity_compiler in ("ifort", "ifx"):
    # The commands of the installation (lists, in older releases texts) with another compiler. -mP2OPT is an
    # internal option of ifort. On Windows Microsoft's linker links, and its commands stay.
    # Free form under any extension; no static local arrays, because Abaqus calls from several threads.
    asperity_commands = []
    for asperity_command in (compile_fortran, link_sl, link_exe):
        asperity_words = []
        asperity_text = not isinstance(asperity_command, list)
        for asperity_word in asperity_command.split() if asperity_text else asperity_command:
            if asperity_word in ("ifort", "ifx"):
                asperity_word = asperity_compiler
            if asperity_compiler == "ifort" or not asperity_word.startswith("-mP2OPT"):
                asperity_words.append(asperity_word)
        if not asperity_commands:
            asperity_words += ["/free", "/recursive"] if asperity_windows else ["-free", "-auto"]
        asperity_commands.append(" ".join(asperity_words) if asperity_text else asperity_words)
    compile_fortran, link_sl, link_exe = asperity_commands

elif asperity_compiler == "gfortran" and not asperity_windows:
    # %P is the source; older releases append it themselves, so that it stands here only if it stood there.
    asperity_source = ["%P"] if "%P" in compile_fortran else []
    # -frecursive: no static arrays. -cpp is what Intel's -fpp is; the sources need no preprocessor.
    compile_fortran = ["gfortran", "-c", "-cpp", "-fPIC", "-O2", "-frecursive", "-ffree-form",
                       "-ffree-line-length-132", "-DABQ_LNX86_64", "-DABQ_FORTRAN", "-I%I"] + asperity_source
    link_sl = ["gfortran", "-fPIC", "-shared", "%E", "-Wl,-soname,%U", "-o", "%U", "%F", "%A", "%L", "%B",
               "-Wl,-Bdynamic"]
    link_exe = ["gfortran", "-fPIC", "-o", "%J", "%F", "%M", "%L", "%B", "%O", "-Wl,-Bdynamic"]

elif asperity_compiler == "gfortran":
    asperity_source = ["%P"] if "%P" in compile_fortran else []
    # Windows: names without underscore, as Intel's /iface:cref makes them. No report of success is known.
    compile_fortran = ["gfortran", "-c", "-cpp", "-O2", "-frecursive", "-ffree-form",
                       "-ffree-line-length-132", "-fno-underscoring", "-DABQ_WIN86_64",
                       "-DABQ_FORTRAN", "-I%I"] + asperity_source
    link_sl = ["gfortran", "-shared", "-static", "-o", "%U", "%E", "%F", "%A", "%L", "%B"]
    link_exe = ["gfortran", "-static", "-o", "%J", "%F", "%M", "%L", "%B", "%O"]

elif asperity_compiler:
    raise ValueError("asperity_compiler = %r: expected 'ifort', 'ifx', 'gfortran' or ''" % asperity_compiler)

# Abaqus takes every name that is left for a setting.
for asperity_name in list(locals()):
    if asperity_name.startswith("asperity_") and asperity_name != "asperity_name":
        del locals()[asperity_name]
del asperity_name, sys
"""
"""Text of the file."""
