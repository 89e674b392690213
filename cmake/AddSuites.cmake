# Run when a test program has been built: writes the file that makes each of its suites known to CTest.
# PROGRAM, FILE, LABEL, TIMEOUT and FOLDER are given by kantaro_discover_suites.
cmake_minimum_required(VERSION 3.24)

execute_process(COMMAND ${PROGRAM} --gtest_list_tests
                OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
# Suites stand at the margin and end in a dot; what follows it is a type parameter.
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\." suites "${listing}")
get_filename_component(program ${PROGRAM} NAME)
# Nothing passed, nothing failed: the data is not here.
set(skipped "  PASSED  . 0 tests[.]\n.  SKIPPED . [^\n]+\n(.  SKIPPED . [^\n]+\n)+$")
set(tests "")
foreach(suite ${suites})
  string(REGEX REPLACE "[\n.]" "" suite "${suite}")
  string(APPEND tests "add_test([==[${program}.${suite}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${suite}.*]==])\n"
                      "set_tests_properties([==[${program}.${suite}]==] PROPERTIES LABELS ${LABEL} TIMEOUT ${TIMEOUT}\n"
                      "  WORKING_DIRECTORY [==[${FOLDER}]==] SKIP_REGULAR_EXPRESSION [==[${skipped}]==])\n")
endforeach()
file(WRITE ${FILE} "${tests}")
