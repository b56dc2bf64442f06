// SPDX-License-Identifier: GPL-3.0-or-later
// Cryptomattes: the hash and the ids made of it, ranks of a pixel, checkpoints.
#include "film/matte.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <stdexcept>

namespace nephele {
namespace {

TEST(Matte, HashesAreThoseOfMurmur3) {
    EXPECT_EQ(matte_hash(""), 0u);
    EXPECT_EQ(matte_hash("hello"), 0x248bfa47u);
    EXPECT_EQ(matte_hash("hello, world"), 0x149bbb7fu);
    EXPECT_EQ(matte_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
    EXPECT_EQ(matte_hash("Cube"), 0xa8fce865u);  // as Cycles 5.0 writes it
}

TEST(Matte, IdsAreNormalFloatsAndElseTheHash) {
    int changed = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::string name = "object " + std::to_string(i);
        const std::uint32_t id = matte_id(name);
        EXPECT_TRUE(std::isnormal(std::bit_cast<float>(id))) << name;
        changed += id != matte_hash(name);
    }
    EXPECT_GT(changed, 50) << "2 of 256 exponents are not those of normal floats";
    EXPECT_LT(changed, 300);
}

TEST(Matte, RanksByCoverageAndDividesBySamples) {
    MatteFilm film(2, 1);
    for (const auto& [id, weight] : {std::pair(7u, 1.0), {5u, 3.0}, {9u, 0.5}, {7u, 1.0}, {4u, 0.5}})
        film.add(1, 0, id, weight);
    const std::vector<std::uint32_t> counts{0, 8};
    const auto ids = [](const std::vector<float>& pixels) {
        return std::pair(std::bit_cast<std::uint32_t>(pixels[4]), std::bit_cast<std::uint32_t>(pixels[6]));
    };
    const auto first = film.read(0, counts), second = film.read(1, counts), third = film.read(2, counts);
    EXPECT_EQ(ids(first), std::pair(5u, 7u));
    EXPECT_EQ(first[5], 3.0f / 8);
    EXPECT_EQ(first[7], 2.0f / 8);
    EXPECT_EQ(ids(second), std::pair(4u, 9u)) << "of equal coverage, the lower id comes first";
    EXPECT_EQ(ids(third), std::pair(0u, 0u));
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(first[i], 0) << "nothing was added to the other pixel";
}

TEST(Matte, RestoresWhatItSavedAndRefusesTheRest) {
    MatteFilm film(2, 2);
    film.add(0, 1, 11, 2);
    film.add(0, 1, 12, 1);
    film.add(1, 0, 11, 1);
    std::vector<double> counts, ids, weights;
    film.save(counts, ids, weights);
    MatteFilm again(2, 2);
    again.restore(counts, ids, weights);
    const std::vector<std::uint32_t> samples{3, 3, 3, 3};
    EXPECT_EQ(again.read(0, samples), film.read(0, samples));
    auto wrong = counts;
    wrong[0] += 1;
    EXPECT_THROW(again.restore(wrong, ids, weights), std::invalid_argument);
    EXPECT_THROW(again.restore({1}, ids, weights), std::invalid_argument);
    EXPECT_THROW(again.restore(counts, ids, {1, -1, 1}), std::invalid_argument);
    EXPECT_THROW(again.restore(counts, {1, 2, double{NAN}}, weights), std::invalid_argument);
    EXPECT_EQ(again.read(0, samples), film.read(0, samples)) << "what is refused changes nothing";
}

}  // namespace
}  // namespace nephele
