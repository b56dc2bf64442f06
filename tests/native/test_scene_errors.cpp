// SPDX-License-Identifier: GPL-3.0-or-later
// Faulty scenes are refused with std::invalid_argument, and the message names the thing at fault.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>

#include "render.h"
#include "scene_fixtures.h"

namespace nephele::test {
namespace {

using Change = std::function<void(SceneSource&)>;

/// Builds a good scene with one change and returns what it complains of; empty where it does not.
std::string complaint(const Change& change) {
    SceneSource source = fog_in(box_mesh(Vec3f(-1), Vec3f(1)));
    source.instances.front().name = "the cloud";
    change(source);
    try {
        const Scene scene(std::move(source));
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
    return "";
}

void expect_words(const std::string& message, std::initializer_list<const char*> words) {
    for (const char* word : words)
        EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' is not in: " << message;
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(SceneErrors, AGoodSceneHasNone) {
    EXPECT_EQ(complaint([](SceneSource&) {}), "");
}

TEST(SceneErrors, BadMeshesAreNamed) {
    const auto with = [](const std::function<void(Mesh&)>& change) {
        return complaint([&](SceneSource& s) {
            s.meshes[0].name = "bad mesh";
            change(s.meshes[0]);
        });
    };
    for (const std::int32_t index : {-1, 3, 1 << 30}) {
        const auto bad = Buffer<std::int32_t>(std::vector<std::int32_t>{0, 1, index});
        expect_words(with([&](Mesh& m) {
                         m.positions = Buffer<float>(std::vector<float>(9, 0.5f));
                         m.triangles = bad;
                     }),
                     {"bad mesh", "vertex"});
    }
    for (const float x : {kNan, kInfinity, -kInfinity})
        expect_words(with([&](Mesh& m) { m.positions = Buffer<float>(std::vector<float>(24, x)); }),
                     {"bad mesh", "finite"});
    const auto floats = [](std::size_t n) { return Buffer<float>(std::vector<float>(n, 1.0f)); };
    expect_words(with([&](Mesh& m) { m.corner_normals = floats(9); }), {"bad mesh", "corner"});
    expect_words(with([&](Mesh& m) { m.uvs.push_back(floats(6)); }), {"bad mesh", "corner"});
    expect_words(with([&](Mesh& m) { m.attributes.push_back(floats(12)); }), {"bad mesh", "corner"});
    expect_words(
        with([&](Mesh& m) { m.material_index = Buffer<std::int32_t>(std::vector<std::int32_t>{0}); }),
        {"bad mesh"});
}

TEST(SceneErrors, BadCoefficientsAreNamed) {
    const auto with = [](const std::function<void(VolumeClosure&)>& change) {
        return complaint([&](SceneSource& s) { change(s.materials[0].volume[0]); });
    };
    expect_words(with([](VolumeClosure& c) { c.sigma_s = {1, -1e-6f, 1}; }), {"the cloud", "negative"});
    expect_words(with([](VolumeClosure& c) { c.sigma_a = {kNan, 0, 0}; }), {"the cloud", "finite"});
    expect_words(with([](VolumeClosure& c) { c.emission = {0, 0, kInfinity}; }), {"the cloud", "finite"});
    expect_words(complaint([](SceneSource& s) { s.world.volume.emplace_back().sigma_s = Rgb(-1); }),
                 {"world", "negative"});
}

TEST(SceneErrors, BadLampsCamerasAndProgramsAreNamed) {
    expect_words(complaint([](SceneSource& s) {
                     LampDescription lamp;
                     lamp.name = "bulb";
                     lamp.power = Rgb(-1);
                     s.lamps.push_back(lamp);
                 }),
                 {"bulb", "negative"});
    expect_words(complaint([](SceneSource& s) {
                     s.camera.name = "eye";
                     s.camera.right = s.camera.left;
                 }),
                 {"eye"});
    expect_words(complaint([](SceneSource& s) {
                     Program p;
                     p.registers = {Vec3f(1)};
                     p.closures.push_back({});
                     p.closures[0].weight = 200;
                     s.materials[0].name = "paint";
                     s.materials[0].surface = p;
                 }),
                 {"paint"});
}

TEST(SceneErrors, MissingVolumeFilesAreNamed) {
    expect_words(complaint([](SceneSource& s) {
                     VolumeSource v;
                     v.name = "smoke";
                     v.path = "/nowhere/smoke.vdb";
                     for (std::size_t i = 0; i < 16; ++i)
                         v.world_from_object[i] = i % 5 == 0 ? 1 : 0;
                     s.volumes.push_back(v);
                 }),
                 {"smoke", "/nowhere/smoke.vdb"});
}

TEST(SceneErrors, SingularTransformsAreRefused) {
    const double flat[16] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    EXPECT_THROW(inverse_of(flat), std::invalid_argument);
    double wild[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    wild[5] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(inverse_of(wild), std::invalid_argument);
}

TEST(RenderErrors, ThePlainTwinRefusesLampsThatNothingCanHit) {
    SceneSource source = fog_in(box_mesh(Vec3f(-1), Vec3f(1)));
    LampDescription lamp;
    lamp.name = "needle";
    source.lamps.push_back(lamp);
    const auto scene = std::make_shared<const Scene>(std::move(source));
    Settings settings;
    settings.integrator = Settings::Integrator::plain;
    FilmSource film;
    film.width = film.height = film.x1 = film.y1 = 1;
    film.passes = {PassId::combined};
    try {
        const Render render(scene, settings, film);
        FAIL() << "not refused";
    } catch (const std::invalid_argument& e) {
        expect_words(e.what(), {"needle", "plain"});
    }
}

}  // namespace
}  // namespace nephele::test
