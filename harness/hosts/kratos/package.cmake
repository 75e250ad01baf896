# what the Python package has of Kratos beside its card, mesh and kit
if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  # a UMAT of the same name between Kratos and libasperity, which it finds beside it as the next library in the order of
  # the search; that must stay a dependency although nothing of it is named
  find_package(Threads REQUIRED)
  add_library(asperity_kratos SHARED ${PROJECT_SOURCE_DIR}/harness/hosts/kratos/commit_adapter.c)
  target_link_options(asperity_kratos PRIVATE -Wl,--no-as-needed)
  target_link_libraries(asperity_kratos PRIVATE asperity_packaged asperity_flags Threads::Threads ${CMAKE_DL_LIBS})
  target_include_directories(asperity_kratos PRIVATE ${PROJECT_SOURCE_DIR}/src)
  set_target_properties(asperity_kratos PROPERTIES C_STANDARD 11 INSTALL_RPATH "$ORIGIN")
  install(TARGETS asperity_kratos DESTINATION asperity COMPONENT python)
endif()
install(FILES ${folder}/kratos_model.py DESTINATION asperity/hosts/kratos COMPONENT python)
