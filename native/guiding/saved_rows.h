// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of plain data as the doubles of a checkpoint, one for each 32 bits, and back, bit for bit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace nephele {

template <class Row, class Allocator>
std::vector<double> flattened(const std::vector<Row, Allocator>& rows) {
    static_assert(std::is_trivially_copyable_v<Row> && sizeof(Row) % sizeof(std::uint32_t) == 0);
    std::vector<std::uint32_t> words(rows.size() * sizeof(Row) / sizeof(std::uint32_t));
    if (!rows.empty())
        std::memcpy(words.data(), rows.data(), rows.size() * sizeof(Row));
    return {words.begin(), words.end()};
}

/// Whether `name` is there with as many rows.
template <class Row, class Allocator>
bool holds(const std::map<std::string, std::vector<double>>& saved, const char* name,
           const std::vector<Row, Allocator>& rows) {
    const auto found = saved.find(name);
    return found != saved.end() && found->second.size() == rows.size() * sizeof(Row) / sizeof(std::uint32_t);
}

/// Throws std::invalid_argument where `name` is missing or not of the rows' number.
template <class Row, class Allocator>
void unflatten(const std::map<std::string, std::vector<double>>& saved, const char* name,
               std::vector<Row, Allocator>& rows) {
    if (!holds(saved, name, rows)) {
        throw std::invalid_argument(std::string("the checkpoint does not fit this render ('") + name +
                                    "' is missing or of another size); render with the settings it was "
                                    "made with");
    }
    const std::vector<double>& values = saved.at(name);
    std::vector<std::uint32_t> words(values.size());
    for (std::size_t i = 0; i < words.size(); ++i) {
        const double word = values[i];
        if (!(word >= 0 && word <= 0xffffffffu))
            throw std::invalid_argument(std::string("the checkpoint is damaged ('") + name +
                                        "'); render without it");
        words[i] = static_cast<std::uint32_t>(word);
    }
    if (!rows.empty())
        std::memcpy(static_cast<void*>(rows.data()), words.data(), words.size() * sizeof(std::uint32_t));
}

/// Throws std::invalid_argument unless good(row) of all.
template <class Rows, class F>
void check_rows(const char* name, const Rows& rows, F good) {
    if (!std::all_of(rows.begin(), rows.end(), good)) {
        throw std::invalid_argument(std::string("what was learned is damaged ('") + name +
                                    "'); render without it");
    }
}

/// The rows that are saved, however many. Throws std::invalid_argument where `name` is missing or cut.
template <class Row>
std::vector<Row> unflattened(const std::map<std::string, std::vector<double>>& saved, const char* name) {
    const auto found = saved.find(name);
    const std::size_t size = found == saved.end() ? 0 : found->second.size();
    std::vector<Row> rows(size * sizeof(std::uint32_t) / sizeof(Row));
    unflatten(saved, name, rows);
    return rows;
}

}  // namespace nephele
