// SPDX-License-Identifier: GPL-3.0-or-later
#include "grids/grid_cache.h"

#include <bit>
#include <stdexcept>

namespace nephele {

namespace {

/// The file changed while it was read.
struct Changed {};

}  // namespace

GridCache& GridCache::process() {
    static GridCache cache;
    return cache;
}

std::string GridCacheScope::Request::key(const FileStamp& stamp) const {
    return std::string(kind) + ' ' + stamp.text() + ' ' +
           std::to_string(static_cast<int>(options.precision)) + ' ' +
           std::to_string(std::bit_cast<std::uint32_t>(options.clipping)) +
           (options.keep_negative ? " signed " : " ") + std::to_string(path.size()) + ' ' + path + ' ' + name;
}

template <typename T, typename Load>
std::shared_ptr<const T> GridCacheScope::read(const Request& request, const Load& load) {
    constexpr int kAttempts = 3;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const FileStamp stamp = cache_->probe_(request.path);
        const auto make = [&]() -> PartCache::Value {
            auto value = std::make_shared<const T>(load());
            let_settle(stamp);
            if (cache_->probe_(request.path) != stamp)
                throw Changed();
            return value;
        };
        try {
            return std::static_pointer_cast<const T>(use(request.key(stamp), make));
        } catch (const Changed&) {  // once more, from its new beginning
        }
    }
    throw std::runtime_error(request.path +
                             " is being written to while it is read: render once it is complete");
}

std::shared_ptr<const LoadedGrid> GridCacheScope::grid(const std::string& path, const std::string& name,
                                                       const GridOptions& options) {
    return read<LoadedGrid>({"numbers", path, name, options}, [&] { return load_grid(path, name, options); });
}

std::shared_ptr<const LoadedVectorGrid> GridCacheScope::vector_grid(const std::string& path,
                                                                    const std::string& name,
                                                                    const GridOptions& options) {
    return read<LoadedVectorGrid>({"vectors", path, name, options},
                                  [&] { return load_vector_grid(path, name, options); });
}

std::shared_ptr<const std::vector<GridInfo>> GridCacheScope::list(const std::string& path) {
    return read<std::vector<GridInfo>>({"list", path, {}, {}}, [&] { return list_grids(path); });
}

}  // namespace nephele
