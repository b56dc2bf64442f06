// SPDX-License-Identifier: GPL-3.0-or-later
// libFuzzer's way into the target named by NEPHELE_FUZZ_TARGET.
#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    nephele::fuzz::NEPHELE_FUZZ_TARGET({data, size});
    return 0;
}
