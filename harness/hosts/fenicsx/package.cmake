# what the Python package has of FEniCSx beside its card and kit: the solver
file(GLOB solver CONFIGURE_DEPENDS ${folder}/jointed*.py)
install(FILES ${solver} ${folder}/../paraview_files.py DESTINATION asperity/hosts/fenicsx COMPONENT python)
