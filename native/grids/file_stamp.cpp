// SPDX-License-Identifier: GPL-3.0-or-later
#include "grids/file_stamp.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace nephele {

std::string FileStamp::text() const {
    return std::to_string(size) + ' ' + std::to_string(modified) + ' ' + std::to_string(changed) + ' ' +
           std::to_string(device) + ' ' + std::to_string(inode);
}

FileStamp stamp_of(const std::string& path) {
    const auto nanoseconds = [](const timespec& t) {
        return std::int64_t{t.tv_sec} * 1'000'000'000 + std::int64_t{t.tv_nsec};
    };
    struct stat s {};
    if (stat(path.c_str(), &s) != 0)
        return {};
    return {s.st_size, nanoseconds(s.st_mtim), nanoseconds(s.st_ctim), s.st_dev, s.st_ino};
}

void let_settle(const FileStamp& stamp) {
    using namespace std::chrono;
    constexpr nanoseconds kStep = milliseconds(20);
    const nanoseconds age =
        system_clock::now().time_since_epoch() - nanoseconds(std::max(stamp.modified, stamp.changed));
    if (age >= nanoseconds(0) && age < kStep)
        std::this_thread::sleep_for(kStep - age);
}

}  // namespace nephele
