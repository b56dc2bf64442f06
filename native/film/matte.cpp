// SPDX-License-Identifier: GPL-3.0-or-later
#include "film/matte.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace nephele {

// MurmurHash3_x86_32 (Austin Appleby, public domain), seed 0.
std::uint32_t matte_hash(std::string_view name) {
    const auto mixed = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
    const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(name[i])}; };
    const std::size_t whole = name.size() / 4 * 4;
    std::uint32_t h = 0;
    for (std::size_t i = 0; i < whole; i += 4) {
        h ^= mixed(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t rest = 0;
    for (std::size_t i = whole; i < name.size(); ++i)
        rest |= byte(i) << (8 * (i - whole));
    h ^= mixed(rest);
    h ^= static_cast<std::uint32_t>(name.size());
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

std::uint32_t matte_id(std::string_view name) {
    const std::uint32_t hash = matte_hash(name);
    // Neither denormal nor infinite: file formats and compositors need not keep those apart.
    const std::uint32_t exponent = std::clamp((hash >> 23) & 255u, 1u, 254u);
    return (hash & 0x807fffffu) | exponent << 23;
}

MatteFilm::MatteFilm(int width, int height)
    : width_(width),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      rows_(static_cast<std::size_t>(height)) {}

void MatteFilm::add(int x, int y, std::uint32_t id, double weight) {
    const auto row = static_cast<std::size_t>(y);
    auto& pixel = pixels_[row * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
    const std::lock_guard lock(rows_[row]);
    const auto known =
        std::find_if(pixel.begin(), pixel.end(), [&](const Coverage& c) { return c.id == id; });
    if (known == pixel.end())
        pixel.push_back({id, weight});
    else
        known->weight += weight;
}

std::vector<float> MatteFilm::read(int level, const std::vector<std::uint32_t>& sample_counts) const {
    std::vector<float> out(4 * pixels_.size());
    std::vector<Coverage> ranked;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        {
            const std::lock_guard lock(rows_[i / static_cast<std::size_t>(width_)]);
            ranked = pixels_[i];
        }
        std::sort(ranked.begin(), ranked.end(), [](const Coverage& a, const Coverage& b) {
            return a.weight != b.weight ? a.weight > b.weight : a.id < b.id;
        });
        const auto first = 2 * static_cast<std::size_t>(level);
        for (std::size_t rank = first; rank < std::min(first + 2, ranked.size()); ++rank) {
            float* pair = out.data() + 4 * i + 2 * (rank - first);
            pair[0] = std::bit_cast<float>(ranked[rank].id);
            pair[1] = static_cast<float>(ranked[rank].weight / std::max(sample_counts[i], 1u));
        }
    }
    return out;
}

std::size_t MatteFilm::bytes() const {
    std::size_t bytes = pixels_.size() * sizeof(pixels_[0]);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const std::lock_guard lock(rows_[i / static_cast<std::size_t>(width_)]);
        bytes += pixels_[i].capacity() * sizeof(Coverage);
    }
    return bytes;
}

void MatteFilm::save(std::vector<double>& counts, std::vector<double>& ids,
                     std::vector<double>& weights) const {
    for (const auto& pixel : pixels_) {
        counts.push_back(static_cast<double>(pixel.size()));
        for (const Coverage& c : pixel) {
            ids.push_back(c.id);
            weights.push_back(c.weight);
        }
    }
}

void MatteFilm::restore(const std::vector<double>& counts, const std::vector<double>& ids,
                        const std::vector<double>& weights) {
    double total = 0;
    bool good = counts.size() == pixels_.size() && ids.size() == weights.size();
    for (const double n : counts) {
        good = good && n >= 0 && n == std::floor(n) && n <= static_cast<double>(ids.size());
        total += n;
    }
    good = good && total == static_cast<double>(ids.size());
    for (std::size_t i = 0; i < ids.size() && good; ++i)
        good = ids[i] >= 0 && ids[i] < 0x1p32 && ids[i] == std::floor(ids[i]) && weights[i] >= 0;
    if (!good)
        throw std::invalid_argument("the checkpoint is damaged (its mattes); render without it");
    std::size_t next = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        pixels_[i].clear();
        for (double n = 0; n < counts[i]; ++n, ++next)
            pixels_[i].push_back({static_cast<std::uint32_t>(ids[next]), weights[next]});
    }
}

}  // namespace nephele
