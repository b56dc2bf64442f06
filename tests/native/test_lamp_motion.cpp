// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps that move and lamps that are linked: a lamp at a time is the lamp that stands where it is then.
#include <gtest/gtest.h>

#include "light_fixtures.h"
#include "lights/lamp_point.h"
#include "lights/light_set.h"

using namespace nephele;
using namespace nephele::test;

namespace {

std::array<double, 16> matrix_of(const LampDescription& d) {
    std::array<double, 16> m{};
    std::copy(std::begin(d.world_from_light), std::end(d.world_from_light), m.begin());
    return m;
}

/// A lamp that is at rest at the first of the two places, and moves from one to the other.
LampDescription on_its_way(Kind kind, const LampSetter& shape, float degrees) {
    LampDescription d = lamp_of(kind), end;
    shape(d);
    place(d, {1, 0, 2}, {0.3f, 0.2f, 0.1f});
    place(end, {2, -1, 1.5f}, {0.3f + degrees * kDegree, 0.2f, 0.1f});
    d.motion = {matrix_of(d), matrix_of(end)};
    return d;
}

TEST(LampMotion, IsThatOfALampWhichStandsThere) {
    const std::pair<Kind, LampSetter> kinds[] = {
        {Kind::point, ball(0.3f)}, {Kind::spot, ball(0.2f)}, {Kind::area, area(0.8f, 0.4f, true, 100)}};
    Rng rng(4);
    int drawn = 0, met = 0;
    for (const auto& [kind, shape] : kinds) {
        const LampDescription d = on_its_way(kind, shape, 60);
        const Lamp moving = prepare_lamp(d);
        ASSERT_TRUE(moving.motion.moves());
        LampDescription last = d;
        std::copy(d.motion[1].begin(), d.motion[1].end(), last.world_from_light);
        last.motion.clear();
        const Lamp still = prepare_lamp(last);
        for (int i = 0; i < 200; ++i) {
            const Vec3f p(4 * rng.next() - 1, 4 * rng.next() - 2, 1.4f * rng.next());
            const Vec2f u = rng.next2();
            EXPECT_NEAR(moving.importance({p, 1}), still.importance(p), 1e-2f * still.importance(p) + 1e-4f);
            const auto a = moving.sample({p, 1}, u);
            if (!a)
                continue;
            ++drawn;
            const auto hit = moving.intersect({p, a->wi, 0, kInfinity, 1}),
                       there = still.intersect({p, a->wi});
            if (!hit || !there)
                continue;  // at the rim
            ++met;
            EXPECT_NEAR(hit->Le.x, there->Le.x, 1e-2f * there->Le.x + 0.1f);
            EXPECT_NEAR(a->Li.x, there->Le.x, 1e-2f * there->Le.x + 0.1f);
            EXPECT_NEAR(a->pdf, there->pdf, 1e-2f * there->pdf);
            EXPECT_NEAR(hit->pdf, there->pdf, 1e-2f * there->pdf);
            EXPECT_NEAR(hit->distance, there->distance, 1e-3f * there->distance);
        }
    }
    EXPECT_GT(met, 300);
    EXPECT_GT(met, 0.97 * drawn);
}

TEST(LampMotion, StaysInItsBounds) {
    Rng rng(6);
    for (const Kind kind : {Kind::point, Kind::area}) {
        const Lamp lamp = prepare_lamp(on_its_way(kind, kind == Kind::area ? area(2, 1) : ball(0.3f), 170));
        const LightBounds bounds = bounds_of(lamp);
        for (int i = 0; i < 2000; ++i) {
            const Vec3f p(8 * rng.next() - 4, 8 * rng.next() - 4, 8 * rng.next() - 4);
            const float time = rng.next();
            const auto s = lamp.sample({p, time}, rng.next2());
            if (!s)
                continue;
            const Vec3f on = p + s->wi * s->distance;
            for (int a = 0; a < 3; ++a)
                EXPECT_TRUE(on[a] >= bounds.lower[a] - 1e-4f && on[a] <= bounds.upper[a] + 1e-4f);
        }
    }
}

TEST(LampMotion, AnUndefinedPlaceIsRefused) {
    LampDescription d = on_its_way(Kind::point, ball(0.1f), 10);
    d.motion[1].fill(0);
    EXPECT_THROW(prepare_lamp(d), std::invalid_argument);
}

/// Lamps of which the odd ones shine on set 1 alone, and the even ones on all but that.
LightSet linked(int count) {
    std::vector<Lamp> lamps;
    for (int i = 0; i < count; ++i) {
        LampDescription d = lamp_of(Kind::point, 1 + static_cast<float>(i % 7));
        place(d, {std::sin(static_cast<float>(i)), std::cos(2.0f * static_cast<float>(i)), 2});
        d.linking.receivers = i % 2 == 1 ? 0b10 : ~std::uint64_t{0b10};
        lamps.push_back(prepare_lamp(d));
    }
    return LightSet(std::move(lamps), {}, nullptr);
}

TEST(Linking, OnlyLightsOfTheSetAreChosen) {
    for (const int count : {6, 60}) {  // listed, and in a tree
        const LightSet lights = linked(count);
        ASSERT_TRUE(lights.linked());
        Rng rng(3);
        for (const std::uint8_t set : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{63}}) {
            const Receiver at({0.3f, 0.1f, 0}, 0, set);
            double chosen = 0, total = 0;
            for (int i = 0; i < 2000; ++i) {
                float probability = 0;
                const auto light = lights.select(at, rng.next(), probability);
                if (!light)
                    continue;  // a leaf of the tree may hold none of the set
                chosen += 1;
                EXPECT_EQ(*light % 2 == 1, set == 1);
                EXPECT_NEAR(lights.selection_pdf(at, *light), probability, 1e-5f);
            }
            for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
                total += double{lights.selection_pdf(at, i)};
                EXPECT_EQ(lights.selection_pdf(at, i) > 0, (i % 2 == 1) == (set == 1));
            }
            EXPECT_NEAR(chosen / 2000, total, 0.04);
        }
    }
    EXPECT_FALSE(LightSet({prepare_lamp(lamp_of(Kind::point))}, {}, nullptr).linked());
}

TEST(LampPoint, TextureCoordinatesSpanTheLamp) {
    LampDescription d = lamp_of(Kind::area);
    area(2, 1)(d);
    place(d, {0, 0, 2});  // shines down
    const AnyLight light = prepare_lamp(d).light;
    const LampPoint corner = lamp_point(light, {1, 0.5f, 0}, {0, 0, 1}, 2);
    EXPECT_NEAR(corner.uv.x, 1, 1e-6);
    EXPECT_NEAR(corner.uv.y, 1, 1e-6);
    EXPECT_NEAR(corner.n.z, -1, 1e-6);
    LampDescription s = lamp_of(Kind::spot);
    s.spot_size = kPi / 2;
    place(s, {0, 0, 2});
    const LampPoint edge =
        lamp_point(prepare_lamp(s).light, {2, 0, 0}, normalize(Vec3f(-2, 0, 2)), std::sqrt(8.0f));
    EXPECT_NEAR(edge.uv.x, 1, 1e-5) << "the cone touches the picture's sides";
    EXPECT_NEAR(edge.uv.y, 0.5, 1e-5);
}

}  // namespace
