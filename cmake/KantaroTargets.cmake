# How a room, a test, a benchmark and a fuzz target are declared.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

set(KANTARO_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined")

add_library(kantaro_options INTERFACE)
target_compile_options(kantaro_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                                 -Wno-sign-conversion -Wnon-virtual-dtor)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 sees overlapping copies in `"text" + string` where there are none (GCC bug 105651).
  target_compile_options(kantaro_options INTERFACE -Wno-restrict)
endif()
# No fused or reassociated arithmetic: a run repeats to the bit on every x86-64.
target_compile_options(kantaro_options INTERFACE -ffp-contract=off)
target_include_directories(kantaro_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_definitions(kantaro_options INTERFACE
  $<$<CONFIG:Debug>:EIGEN_INITIALIZE_MATRICES_BY_NAN>)
if(KANTARO_SANITIZE)
  # -O1 -g1 builds in half the time of -O2 -g and names the same lines.
  target_compile_options(kantaro_options INTERFACE -O1 -g1 -fsanitize=${KANTARO_SANITIZE}
                         -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(kantaro_options INTERFACE -fsanitize=${KANTARO_SANITIZE})
endif()
if(KANTARO_FUZZ)
  target_compile_options(kantaro_options INTERFACE -fsanitize=fuzzer-no-link,address,undefined
                         -fno-sanitize-recover=all)
  target_link_options(kantaro_options INTERFACE -fsanitize=address,undefined)
endif()

# kantaro_library(NAME SOURCES ... DEPENDS ... [PCH ...]): a room, or a target of one. Defines kantaro::NAME.
function(kantaro_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS;PCH" ${ARGN})
  add_library(kantaro_${name} STATIC ${ARG_SOURCES})
  add_library(kantaro::${name} ALIAS kantaro_${name})
  target_link_libraries(kantaro_${name} PUBLIC kantaro_options ${ARG_DEPENDS}
                        PRIVATE ${ARG_PRIVATE_DEPENDS})
  if(ARG_PCH)
    target_precompile_headers(kantaro_${name} PRIVATE ${ARG_PCH})
  endif()
endfunction()

# All programs whose tests are labelled fast, and all fuzz targets: what the asan, tsan and fuzz presets build.
add_custom_target(fast_tests)
add_custom_target(fuzzers)

# kantaro_test(NAME LABEL fast|slow|soak SOURCES ... DEPENDS ... [TIMEOUT s] [SINGLY]): one GoogleTest program. CTest knows
# each of its suites, whose tests share a process and what it costs to make their world; SINGLY: each of its tests.
# KANTARO_SOURCE_DIR is the checkout, for models and test data.
# LABEL fast is also run under the sanitizers; soak is left out of the default run.
function(kantaro_test name)
  cmake_parse_arguments(ARG "SINGLY" "LABEL;TIMEOUT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE KANTARO_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                                             KANTARO_BINARY_DIR="${PROJECT_BINARY_DIR}")
  if(ARG_LABEL STREQUAL "fast")
    add_dependencies(fast_tests ${name})
  endif()
  if(ARG_SINGLY)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 120
                         PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT})
  else()
    kantaro_discover_suites(${name} ${ARG_LABEL} ${ARG_TIMEOUT})
  endif()
endfunction()

# Makes the suites of a built program known to CTest, as gtest_discover_tests does its tests.
function(kantaro_discover_suites program label timeout)
  set(stub ${CMAKE_CURRENT_BINARY_DIR}/${program}_stub.cmake)
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  file(WRITE ${stub} "if(EXISTS \"${suites}\")\n  include(\"${suites}\")\nelse()\n"
                     "  add_test(${program}_NOT_BUILT ${program}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${stub})
  add_custom_command(TARGET ${program} POST_BUILD BYPRODUCTS ${suites} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DFILE=${suites} -DLABEL=${label}
            -DTIMEOUT=${timeout} -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}
            -P ${PROJECT_SOURCE_DIR}/cmake/AddSuites.cmake)
endfunction()

# kantaro_bench(NAME SOURCES ... DEPENDS ...): one Google Benchmark program, never run by CTest.
function(kantaro_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} benchmark::benchmark benchmark::benchmark_main)
  target_compile_definitions(${name} PRIVATE KANTARO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()

# kantaro_fuzz(NAME SOURCES ... DEPENDS ...): one libFuzzer program; its corpus is fuzz/corpus/NAME.
function(kantaro_fuzz name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzzers ${name})
  target_compile_definitions(${name} PRIVATE KANTARO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()
