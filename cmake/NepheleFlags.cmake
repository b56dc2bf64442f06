# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_apply_flags(target): the one place where compiler flags of our own code are set. Call it on every
# library, module and test binary, so that all of them agree on the processor and on the sanitizers.
# Headers of other projects come in as system headers and are exempt from the warnings.

function(nephele_apply_flags target)
    target_compile_options(${target} PRIVATE
        -Wall -Wextra -Wpedantic -Wshadow -Werror
        # GCC 12 sees uninitialised values in std::optional where there are none.
        $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
        # No code of ours reads errno after a mathematical function; without it sqrt is one instruction.
        -fno-math-errno)
    if(NEPHELE_ARCH)
        target_compile_options(${target} PRIVATE "-march=${NEPHELE_ARCH}")
    endif()
    if(NEPHELE_SANITIZE)
        nephele_sanitizers(compile link)
        target_compile_options(${target} PRIVATE ${compile} -fno-omit-frame-pointer -g1)
        target_compile_definitions(${target} PRIVATE _GLIBCXX_ASSERTIONS)  # bounds of std::vector and the like
        target_link_options(${target} PRIVATE ${link})
    endif()
endfunction()

# What -DNEPHELE_SANITIZE=... means to compiler and linker.
function(nephele_sanitizers compile_out link_out)
    if(NEPHELE_SANITIZE STREQUAL "address")
        set(link -fsanitize=address,undefined)
        set(compile ${link} -fno-sanitize-recover=all)
    elseif(NEPHELE_SANITIZE STREQUAL "thread")
        set(link -fsanitize=thread)
        set(compile ${link})
    elseif(NEPHELE_SANITIZE STREQUAL "fuzzer" AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
        # vptr and function would need parts of the runtime that Python's fuzzer does not bring.
        set(link -fsanitize=address,undefined -fno-sanitize=vptr)
        set(compile -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize=vptr
            -fno-sanitize-recover=all)
    else()
        message(FATAL_ERROR " NEPHELE_SANITIZE=${NEPHELE_SANITIZE} is none of address, thread and, with Clang, fuzzer")
    endif()
    set(${compile_out} ${compile} PARENT_SCOPE)
    set(${link_out} ${link} PARENT_SCOPE)
endfunction()
