# Which test sources are built, and how their cases are labelled.
#
# A suite whose name ends with Statistics (or an instantiation of that name) takes many simulated runs to come to its
# figures: minutes under the sanitizers, which see nothing there that the other cases do not show them. The suite carries
# the label `statistics`. A build without COSIVA_UNIT_TESTS holds the sources of such suites only.

# cosiva_chosen_tests(OUT FILE…): those to be built.
function(cosiva_chosen_tests out)
  set(with_statistics "")
  foreach(file ${ARGN})
    file(STRINGS ${file} found REGEX "^(TEST|TEST_F|TEST_P)\\([A-Za-z0-9]+Statistics,|^INSTANTIATE_TEST_SUITE_P\\(Statistics,")
    if(found)
      list(APPEND with_statistics ${file})
    endif()
  endforeach()
  if(COSIVA_UNIT_TESTS)
    set(${out} ${ARGN} PARENT_SCOPE)
  else()
    set(${out} ${with_statistics} PARENT_SCOPE)
  endif()
endfunction()

# cosiva_discover_suites(TARGET MODULE PROPERTIES): the suites become tests when the program has been built.
function(cosiva_discover_suites target module properties)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${target}> -D MODULE=${module} -D FILE=${file}
      -D UNIT_TESTS=${COSIVA_UNIT_TESTS} "-DPROPERTIES=${properties}" -P ${CMAKE_SOURCE_DIR}/cmake/list_suites.cmake)
  # A program that is not built yet has one test, which fails.
  set(unbuilt ${CMAKE_CURRENT_BINARY_DIR}/${target}_unbuilt.cmake)
  file(WRITE ${unbuilt} "if(EXISTS [==[${file}]==])\n  include([==[${file}]==])\nelse()\n  add_test([==[${module}: not built]==] false)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${unbuilt})
endfunction()
