// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a file is still the one that was read.
#pragma once

#include <cstdint>
#include <string>

namespace nephele {

/// Differs where a file differs, once let_settle() is over; all 0 where there is none.
struct FileStamp {
    std::int64_t size = 0, modified = 0, changed = 0;  ///< times: ns since 1970
    std::uint64_t device = 0, inode = 0;

    bool operator==(const FileStamp&) const = default;
    std::string text() const;
};

FileStamp stamp_of(const std::string& path);

/// Waits until a change of the file is sure to change its stamp: file systems count time in steps of a few
/// milliseconds, and within one of them a file may be read and written again.
void let_settle(const FileStamp& stamp);

}  // namespace nephele
