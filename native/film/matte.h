// SPDX-License-Identifier: GPL-3.0-or-later
// Cryptomatte (Friedman and Jones, SIGGRAPH 2015 posters, "Fully automatic ID mattes with support for motion
// blur and transparency"; specification 1.2): per pixel, the names of what is seen there, as hashes, and how
// much of the pixel each covers. Every id that a pixel's samples meet is kept, so that the ranks are exact
// whatever the number of threads.
#pragma once

#include <cstdint>
#include <mutex>
#include <string_view>
#include <vector>

namespace nephele {

/// MurmurHash3_32 of a name, changed so that its bits are those of a normal float: the id in the file.
std::uint32_t matte_id(std::string_view name);
/// The hash itself, as manifests have it.
std::uint32_t matte_hash(std::string_view name);

/// Coverage by id of all pixels, for one kind of names.
class MatteFilm {
  public:
    explicit MatteFilm(int width, int height);

    void add(int x, int y, std::uint32_t id, double weight);
    /// Two ranks of every pixel as (id, coverage, id, coverage), from rank 2 * level on; sample_counts
    /// divide.
    std::vector<float> read(int level, const std::vector<std::uint32_t>& sample_counts) const;
    std::size_t bytes() const;

    /// For checkpoints: how many ids each pixel has, the ids, and their weights.
    void save(std::vector<double>& counts, std::vector<double>& ids, std::vector<double>& weights) const;
    /// Throws std::invalid_argument where these are not as save() gives them.
    void restore(const std::vector<double>& counts, const std::vector<double>& ids,
                 const std::vector<double>& weights);

  private:
    struct Coverage {
        std::uint32_t id;
        double weight;
    };
    int width_;
    std::vector<std::vector<Coverage>> pixels_;
    mutable std::vector<std::mutex> rows_;  ///< one thread adds to a pixel while others may read it
};

}  // namespace nephele
