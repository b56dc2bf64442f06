# SPDX-License-Identifier: GPL-3.0-or-later
#
# nephele_apply_flags(target): the one place where compiler flags of our own code are set. Call it on every
# library, module and test binary, so that all of them agree on the processor and on the sanitizers.
# Headers of other projects come in as system headers and are exempt from the warnings.

function(nephele_apply_flags target)
    target_compile_options(${target} PRIVATE
        -Wall -Wextra -Wpedantic -Wshadow -Werror
        # GCC 12 sees uninitialised values in std::optional where there are none.
        -Wno-maybe-uninitialized
        # No code of ours reads errno after a mathematical function; without it sqrt is one instruction.
        -fno-math-errno)
    if(NEPHELE_ARCH)
        target_compile_options(${target} PRIVATE "-march=${NEPHELE_ARCH}")
    endif()
    if(NEPHELE_SANITIZE)
        target_compile_options(${target} PRIVATE
            -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
        target_compile_definitions(${target} PRIVATE _GLIBCXX_ASSERTIONS)  # bounds of std::vector and the like
        target_link_options(${target} PRIVATE -fsanitize=address,undefined)
    endif()
endfunction()
