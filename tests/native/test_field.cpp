// SPDX-License-Identifier: GPL-3.0-or-later
// The guiding field: the same bits on any threads, leaves where samples are, bounded memory, and a state that
// survives a checkpoint.
#include "guiding/field.h"

#include <gtest/gtest.h>

#include <limits>

#include <tbb/task_arena.h>

#include "field_fixtures.h"
#include "guiding_fixtures.h"

namespace nephele::test {
namespace {

using Saved = std::map<std::string, std::vector<double>>;

const Settings kSettings = vsp_settings(Control::conditional);
constexpr std::size_t kMemory = 1 << 20;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Samples of a small lamp above a box, in volumes and on surfaces; keys from first_key on.
std::vector<FieldSample> batch_of(int n, Rng& rng, std::uint64_t first_key = 0) {
    const Vec3f lamp(0.3f, 0.2f, 3);
    std::vector<FieldSample> out;
    for (int i = 0; i < n; ++i) {
        const Vec3f p = rng.next3() * 2 - Vec3f(1), to_lamp = normalize(lamp - p);
        const bool hits = rng.next() < 0.5f;
        const Vec3f wi = hits ? vmf_sample({to_lamp, 100}, rng.next2()) : sample_sphere(rng.next2());
        FieldSample s = isotropic_sample(p, wi, dot(wi, to_lamp) > 0.95f ? 1 + rng.next() : 0.01f);
        s.pdf = 0.5f * kInv4Pi + 0.5f * vmf_pdf({to_lamp, 100}, wi);
        s.distance = dot(wi, to_lamp) > 0.95f ? length(lamp - p) : kInfinity;
        s.key = first_key + static_cast<std::uint64_t>(i);
        s.part =
            static_cast<FieldPart>(std::max(0, static_cast<int>(rng.next() * 12) - 5));  // half in volumes
        s.vsp = record_of(1, 0.5f, rng);
        out.push_back(s);
    }
    return out;
}
GuidingField taught(int batches, int n, std::uint64_t seed = 977, std::size_t memory = kMemory) {
    Rng rng(seed);
    GuidingField field(kSettings, memory);
    for (int i = 0; i < batches; ++i)
        field.update(batch_of(n, rng));
    return field;
}
Saved saved(const GuidingField& field) {
    Saved out;
    field.save(out);
    return out;
}

TEST(GuidingField, KnowsNothingAtFirst) {
    GuidingField field(kSettings, kMemory);
    EXPECT_EQ(field.find({}, FieldPart::volume), nullptr);
    field.update({});
    EXPECT_EQ(field.find({}, FieldPart::plus_z), nullptr);
    EXPECT_EQ(field.regions(), 0U);
    EXPECT_EQ(field.memory(), 0U);
}

TEST(GuidingField, KeepsVolumesAndSurfacesApart) {
    Rng rng(983);
    auto samples = batch_of(1000, rng);
    std::erase_if(samples, [](const FieldSample& s) { return s.part != FieldPart::volume; });
    GuidingField field(kSettings, kMemory);
    field.update(samples);
    EXPECT_NE(field.find({}, FieldPart::volume), nullptr);
    EXPECT_EQ(field.find({}, FieldPart::plus_z), nullptr);
    for (FieldSample& s : samples)
        s.part = FieldPart::plus_z;
    field.update(samples);
    ASSERT_NE(field.find({}, FieldPart::plus_z), nullptr);
    EXPECT_NE(field.find({}, FieldPart::plus_z), field.find({}, FieldPart::volume));
    EXPECT_EQ(field.find({}, FieldPart::minus_z), nullptr) << "the other face of a wall";
    for (const float far : {-1e30f, 1e30f, kInfinity})
        EXPECT_NE(field.find(Vec3f(far), FieldPart::volume), nullptr) << "the tree covers all of space";
}

TEST(GuidingField, PartsOfSurfacesAreTheirFacings) {
    EXPECT_EQ(part_facing({-1, 0, 0}), FieldPart::minus_x);
    EXPECT_EQ(part_facing({0.9f, 0.3f, -0.3f}), FieldPart::plus_x);
    EXPECT_EQ(part_facing({0.1f, -0.7f, 0.6f}), FieldPart::minus_y);
    EXPECT_EQ(part_facing({0, 1, 0}), FieldPart::plus_y);
    EXPECT_EQ(part_facing({0.5f, 0.5f, -0.6f}), FieldPart::minus_z);
    EXPECT_EQ(part_facing({0, 0, 1}), FieldPart::plus_z);
}

TEST(GuidingField, IsTheSameOnAnyThreads) {
    Saved one, two;
    tbb::task_arena(1).execute([&] { one = saved(taught(4, 30000)); });
    tbb::task_arena(2).execute([&] { two = saved(taught(4, 30000)); });
    EXPECT_TRUE(one == two);
}

TEST(GuidingField, IsTheSameInAnyOrder) {
    Rng rng(991), order(997);
    GuidingField straight(kSettings, kMemory), mixed(kSettings, kMemory);
    for (int i = 0; i < 3; ++i) {
        auto samples = batch_of(20000, rng);
        straight.update(samples);
        for (std::size_t j = samples.size() - 1; j > 0; --j)
            std::swap(samples[j], samples[order.next_uint() % (j + 1)]);
        mixed.update(samples);
    }
    EXPECT_TRUE(saved(straight) == saved(mixed));
}

TEST(GuidingField, PointsAtTheLamp) {
    const GuidingField field = taught(8, 20000);
    Rng rng(1009);
    for (int i = 0; i < 100; ++i) {
        const Vec3f p = rng.next3() * 2 - Vec3f(1);
        for (const FieldPart part : {FieldPart::volume, FieldPart::plus_z}) {
            const FieldRegion& region = *field.find(p, part);
            const VmfMixture seen = region.mixture.seen_from(p - region.pivot);
            EXPECT_GT(seen.pdf(normalize(Vec3f(0.3f, 0.2f, 3) - p)), 10 * kInv4Pi);
            EXPECT_GT(region.guided_share, 0);
        }
    }
}

TEST(GuidingField, IsPartedWhereSamplesAreMany) {
    Rng rng(1013);
    GuidingField field(kSettings, kMemory);
    for (int i = 0; i < 4; ++i) {
        auto samples = batch_of(20000, rng);
        for (FieldSample& s : samples) {
            s.part = FieldPart::volume;
            if (rng.next() < 0.9f)
                s.p = Vec3f(0.5f) + s.p * 0.05f;  // nine tenths in a small part
        }
        field.update(samples);
    }
    EXPECT_GT(field.regions(), 8U);
    const auto distinct = [&](Vec3f centre, float half) {
        std::vector<const FieldRegion*> found;
        for (int i = 0; i < 1000; ++i)
            found.push_back(field.find(centre + (rng.next3() * 2 - Vec3f(1)) * half, FieldPart::volume));
        std::sort(found.begin(), found.end());
        return std::unique(found.begin(), found.end()) - found.begin();
    };
    EXPECT_GT(distinct(Vec3f(0.5f), 0.05f), 2 * distinct(Vec3f(-0.5f), 0.05f));
}

TEST(GuidingField, PlacesThatAreAllButOneAreNotParted) {
    // Their mean is one of them in single precision: a half would be empty, and the other parted again.
    for (const float apart : {0.0f, 0x1p-23f}) {
        GuidingField field(kSettings, kMemory);
        for (int i = 0; i < 5; ++i) {
            Rng rng(1019);
            auto samples = batch_of(10000, rng);
            for (std::size_t j = 0; j < samples.size(); ++j) {
                samples[j].p = {1 + (j % 2 == 0 ? 0 : apart), 2, 3};
                samples[j].part = FieldPart::volume;
            }
            field.update(samples);
        }
        EXPECT_LE(field.regions(), apart > 0 ? 2U : 1U);
    }
}

TEST(GuidingField, KeepsToItsMemory) {
    constexpr std::size_t kLittle = 40000;
    Rng rng(1021);
    GuidingField field(kSettings, kLittle), none(kSettings, 0);
    for (int i = 0; i < 40; ++i) {
        field.update(batch_of(20000, rng));
        ASSERT_LE(field.memory(), kLittle);
    }
    EXPECT_GT(field.memory(), kLittle / 2);
    none.update(batch_of(20000, rng));
    EXPECT_EQ(none.regions(), std::size_t{kFieldParts}) << "one a tree in any case";
}

TEST(GuidingField, EndlessSmallBatchesLeaveItSound) {
    constexpr std::size_t kLittle = 100000;
    Rng rng(1031);
    GuidingField field(kSettings, kLittle);
    std::size_t most = 0;
    for (int i = 0; i < 10000; ++i) {
        field.update(batch_of(i % 64 == 0 ? 300 : i % 7, rng));
        most = std::max(most, field.memory());
    }
    EXPECT_LE(most, kLittle);
    EXPECT_GT(field.regions(), 2U);
    GuidingField other(kSettings, kLittle);
    EXPECT_NO_THROW(other.restore(saved(field))) << "all numbers are sound";
    for (const FieldPart part : {FieldPart::volume, FieldPart::plus_z}) {
        for (int i = 0; i < 100; ++i) {
            const FieldRegion& region = *field.find(rng.next3() * 2 - Vec3f(1), part);
            double total = 0;
            for (const float w : region.mixture.weight)
                total += double{w};
            EXPECT_NEAR(total, 1, 1e-5);
        }
    }
}

TEST(GuidingField, GoesOnFromWhatWasSaved) {
    for (const int batches : {0, 1, 4}) {
        GuidingField field = taught(batches, 20000);
        GuidingField other = taught(1, 500, 1033);  // which forgets what it knew
        other.restore(saved(field));
        EXPECT_TRUE(saved(field) == saved(other));
        EXPECT_EQ(field.regions(), other.regions());
        Rng rng(1039);
        const auto more = batch_of(20000, rng);
        field.update(more);
        other.update(more);
        EXPECT_TRUE(saved(field) == saved(other));
    }
}

TEST(GuidingField, RefusesWhatIsDamaged) {
    const Saved good = saved(taught(3, 20000));
    const auto refused = [](const Saved& bad) {
        GuidingField field(kSettings, kMemory);
        EXPECT_THROW(field.restore(bad), std::invalid_argument);
    };
    refused({});
    const double nan_bits = std::bit_cast<std::uint32_t>(kNan);
    for (const auto& [name, values] : good) {
        Saved bad = good;
        bad.erase(name);
        refused(bad);  // missing
        const auto with = [&](auto&& edit) {
            bad = good;
            edit(bad[name]);
            refused(bad);
        };
        with([](auto& v) { v.clear(); });
        with([](auto& v) { v.pop_back(); });
        with([](auto& v) { v.resize(v.size() / 2); });
        with([](auto& v) { v[0] = -1; });
        with([](auto& v) { v[0] = 1e10; });
        with([](auto& v) { v[1] = std::numeric_limits<double>::quiet_NaN(); });
        with([&](auto& v) { v[0] = nan_bits; });  // a split, or a weight
        if (name.starts_with("field_nodes")) {
            with([](auto& v) { v[1] = 0; });                // the root is its own child
            with([](auto& v) { v[1] = 0xfffffffcU; });      // a child beyond the end
            with([](auto& v) { v.back() = 3; });            // two leaves of one region
            with([](auto& v) { v.back() = 0xffffffffU; });  // a region beyond the end
        } else {
            with([&](auto& v) { v.back() = nan_bits; });
            with([](auto& v) { v[0] = std::bit_cast<std::uint32_t>(5.0f); });  // a weight
            with([](auto& v) { v[0] = std::bit_cast<std::uint32_t>(-0.5f); });
            with([](auto& v) { v[32] = std::bit_cast<std::uint32_t>(-1.0f); });  // a concentration
        }
    }
}

TEST(GuidingField, LeavesOutWhatIsNotFinite) {
    Rng rng(1049);
    const auto good = batch_of(1000, rng);
    GuidingField expected(kSettings, kMemory);
    expected.update(good);
    using Edit = void (*)(FieldSample&, float);
    constexpr Edit kEdits[] = {
        [](FieldSample& s, float x) { s.p.y = x; },
        [](FieldSample& s, float x) { s.wi.x = x; },
        [](FieldSample& s, float x) { s.pdf = x; },
        [](FieldSample& s, float x) { s.scatter_pdf = x; },
        [](FieldSample& s, float x) { s.guide_pdf = x; },
        [](FieldSample& s, float x) { s.scattering = x; },
        [](FieldSample& s, float x) { s.light = x; },
        [](FieldSample& s, float x) { s.cost = x; },
        [](FieldSample& s, float x) { s.vsp.probability = x; },
        [](FieldSample& s, float x) { s.vsp.volume_weight = x; },
        [](FieldSample& s, float x) { s.vsp.surface_weight = x; },
        [](FieldSample& s, float x) { s.vsp.light = x; },
        [](FieldSample& s, float x) { s.vsp.cost = x; },
        [](FieldSample& s, float x) { s.vsp.transmittance = x; },
        [](FieldSample& s, float x) { s.vsp.majorant_depth = kNan + x; },
        [](FieldSample& s, float x) { s.vsp.walked = true, s.vsp.volume_square = kNan + x; },
        [](FieldSample& s, float x) { s.vsp.walked = true, s.vsp.surface_square = kNan + x; },
        [](FieldSample& s, float x) { s.vsp.walked = true, s.vsp.both = kNan + x; },
        [](FieldSample& s, float x) { s.vsp.walked = true, s.vsp.extra_work = x; },
        [](FieldSample& s, float) { s.distance = kNan; },
        [](FieldSample& s, float) { s.distance = 0; },
        [](FieldSample& s, float) { s.pdf = 0; },
        [](FieldSample& s, float) { s.light = -1; }};
    for (std::size_t i = 0; i < std::size(kEdits); ++i) {
        for (const float value : {kNan, kInfinity, -kInfinity}) {
            auto samples = good;
            samples.push_back(good[0]);
            samples.back().key = 500;
            kEdits[i](samples.back(), value);
            GuidingField field(kSettings, kMemory);
            field.update(samples);
            EXPECT_TRUE(saved(field) == saved(expected)) << i << ' ' << value;
        }
    }
}

}  // namespace
}  // namespace nephele::test
