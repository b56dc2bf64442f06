// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs that once made a fuzz target fail (tests/fuzz/corpus), replayed.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "../fuzz/targets.h"

namespace nephele {
namespace {

/// Runs the target on its inputs; a fault ends the process.
void replay(const char* name, void (*target)(fuzz::Data)) {
    int count = 0;
    const std::filesystem::path folder = std::filesystem::path(NEPHELE_FUZZ_CORPUS) / name;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        SCOPED_TRACE(entry.path());
        std::ifstream in(entry.path(), std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
        target({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
        ++count;
    }
    EXPECT_GT(count, 0) << folder;
}

TEST(FuzzCorpus, Program) {
    replay("program", fuzz::program);
}

TEST(FuzzCorpus, Checkpoint) {
    replay("checkpoint", fuzz::checkpoint);
}

}  // namespace
}  // namespace nephele
