# Target `docs`: the reference of the libraries' headers, in build/.../docs/html.
find_program(TAGTWIST_DOXYGEN doxygen)
if(TAGTWIST_DOXYGEN)
  set(DOCS_OUTPUT ${PROJECT_BINARY_DIR}/docs)
  configure_file(docs/Doxyfile.in ${DOCS_OUTPUT}/Doxyfile @ONLY)
  add_custom_target(docs COMMAND ${TAGTWIST_DOXYGEN} ${DOCS_OUTPUT}/Doxyfile VERBATIM)
endif()
