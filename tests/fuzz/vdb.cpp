// SPDX-License-Identifier: GPL-3.0-or-later
// The VDB loader on any file. It may throw std::runtime_error that begins with the file's name; what it loads
// must answer look-ups anywhere, and its bounds must hold them.
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <stdexcept>

#include "grids/cell_bounds.h"
#include "grids/vdb_file.h"
#include "targets.h"

namespace nephele::fuzz {

namespace {

/// A file in memory, for a loader that wants a path.
class MemoryFile {
  public:
    explicit MemoryFile(Data data) : descriptor_(memfd_create("fuzz.vdb", 0)) {
        if (write(descriptor_, data.data(), data.size()) != static_cast<ssize_t>(data.size()))
            fail("cannot write the input to memory");
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { close(descriptor_); }
    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

  private:
    int descriptor_;
};

void look_up(const BrickGrid& grid) {
    const IndexBox& box = grid.active_bounds();
    if (box.empty())
        return;
    for (const Filter filter : {Filter::nearest, Filter::trilinear, Filter::tricubic}) {
        const CellBounds cells = CellBounds::of_grid(grid, filter);
        for (int n = 0; n < 9; ++n) {  // corners, then the middle
            float p[3];
            for (std::size_t a = 0; a < 3; ++a) {
                const auto lo = static_cast<float>(box.min[a]), hi = static_cast<float>(box.max[a]);
                p[a] = n == 8 ? 0.5f * lo + 0.5f * hi : (n >> a & 1) != 0 ? hi : lo;
            }
            const Vec3f at(p[0], p[1], p[2]);
            const float value = grid.evaluate(filter, at);
            const Bounds bounds = cells.range(at, at);
            if (!std::isfinite(value) || !(bounds.min <= value && value <= bounds.max))
                fail("a look-up gives " + std::to_string(value) + ", its bounds are " +
                     std::to_string(bounds.min) + " to " + std::to_string(bounds.max));
        }
    }
}

template <typename F>
void expecting_errors(const std::string& path, F f) {
    try {
        f();
    } catch (const std::runtime_error& e) {
        if (!std::string_view(e.what()).starts_with(path))
            fail(std::string("an error that does not name the file: ") + e.what());
    }
}

}  // namespace

void vdb(Data data) {
    const MemoryFile file(data);
    const std::string path = file.path();
    std::vector<GridInfo> infos;
    expecting_errors(path, [&] { infos = list_grids(path); });
    if (infos.empty())
        infos.emplace_back().name = "density";  // may be there even where a grid after it is damaged
    constexpr std::size_t kMost = 4;            // of any number
    infos.resize(std::min(infos.size(), kMost));
    for (const GridInfo& info : infos) {
        expecting_errors(path, [&] {
            if (const auto grid = load_grid(path, info.name).grid)
                look_up(*grid);
        });
        expecting_errors(path, [&] {
            for (const auto& grid : load_vector_grid(path, info.name).components) {
                if (grid)
                    look_up(*grid);
            }
        });
    }
}

}  // namespace nephele::fuzz
