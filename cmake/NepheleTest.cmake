# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_add_test(name sources...): one GoogleTest binary; ctest runs each of its tests as `name.Suite.Case`.
# It links GoogleTest's main and nothing of ours: add what it tests with target_link_libraries.

if(NEPHELE_TESTS)
    include(GoogleTest)
endif()

function(nephele_add_test name)
    add_executable(${name} ${ARGN})
    nephele_apply_flags(${name})
    target_link_libraries(${name} PRIVATE GTest::gtest_main)
    # PRE_TEST asks the binary for its tests when ctest runs, so that a build never has to run one.
    gtest_discover_tests(${name} TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120)
endfunction()
