// SPDX-License-Identifier: GPL-3.0-or-later
// The fuzz targets: each takes any bytes and returns, whatever they are. A fault ends the process: a
// sanitizer's report, or ours by fail(). libFuzzer calls them (main.cpp), and the native tests with the
// corpus of inputs that once failed (tests/native/test_fuzz_corpus.cpp).
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace nephele::fuzz {

using Data = std::span<const std::uint8_t>;

/// An OpenVDB file: listed, every grid loaded, looked up and bounded.
void vdb(Data data);
/// A node program: refused, or run inside a box without leaving its bounds there.
void program(Data data);
/// What a render saved, with changes: refused, or taken up by a render that then goes on.
void checkpoint(Data data);

/// Says what is wrong and ends the process.
[[noreturn]] void fail(const std::string& what);

}  // namespace nephele::fuzz
