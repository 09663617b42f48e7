# Which test sources are built, and how their cases are labelled.
#
# A suite whose name ends with Statistics (or an instantiation of that name) takes many simulated runs to come to its
# figures: minutes under the sanitizers, which see nothing there that the other cases do not show them. Its cases carry
# the label `statistics`. A build without COSIVA_UNIT_TESTS holds the sources of such suites only.

# cosiva_chosen_tests(OUT HAS_STATISTICS FILE…): those to be built, and whether suites of statistics are among them.
function(cosiva_chosen_tests out has_statistics)
  set(with_statistics "")
  foreach(file ${ARGN})
    file(STRINGS ${file} found REGEX "^(TEST|TEST_F|TEST_P)\\([A-Za-z0-9]+Statistics,|^INSTANTIATE_TEST_SUITE_P\\(Statistics,")
    if(found)
      list(APPEND with_statistics ${file})
    endif()
  endforeach()
  set(${has_statistics} ${with_statistics} PARENT_SCOPE)
  if(COSIVA_UNIT_TESTS)
    set(${out} ${ARGN} PARENT_SCOPE)
  else()
    set(${out} ${with_statistics} PARENT_SCOPE)
  endif()
endfunction()

# cosiva_discover_tests(TARGET HAS_STATISTICS ARGUMENT…): gtest_discover_tests with the labels.
function(cosiva_discover_tests target has_statistics)
  if(COSIVA_UNIT_TESTS)
    gtest_discover_tests(${target} TEST_FILTER "-*Statistics/*:*Statistics.*" ${ARGN})
  endif()
  if(has_statistics)
    gtest_discover_tests(${target} TEST_FILTER "*Statistics/*:*Statistics.*" TEST_LIST ${target}_STATISTICS ${ARGN} LABELS statistics)
  endif()
endfunction()
