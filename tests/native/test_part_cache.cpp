// SPDX-License-Identifier: GPL-3.0-or-later
// Parts that scenes hand on: found by what they are made of, let go of once no scene uses them, and never
// taken for others.
#include "base/part_cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <optional>

#include "bounds_fixtures.h"
#include "math/sampler.h"
#include "math/warp.h"
#include "scene/part_keys.h"
#include "scene_fixtures.h"

namespace nephele::test {
namespace {

PartKey key_of(const Buffer<float>& array) {
    return PartKey().add(array);
}

TEST(PartCache, KeepsTheArraysThatNameAPart) {
    PartCache cache;
    std::weak_ptr<const void> watched;
    {
        PartScope scope(cache);
        const Buffer<float> array(std::vector<float>{1, 2, 3});
        watched = array.owner();
        EXPECT_EQ(*scope.get_or_make<int>(key_of(array), [] { return 7; }), 7);
        EXPECT_EQ(*scope.get_or_make<int>(key_of(array), [] { return 8; }), 7);
        scope.commit();
    }
    EXPECT_FALSE(watched.expired()) << "another array could get its address, and its part";
    PartScope(cache).commit();
    EXPECT_TRUE(watched.expired());
    EXPECT_EQ(cache.size(), 0u);
}

TEST(PartCache, LetsGoOfWhatIsReplacedBeforeItIsComplete) {
    PartCache cache;
    std::weak_ptr<const int> old, other;
    {
        PartScope scope(cache);
        old = scope.get_or_make<int>(PartKey().add("big").add(1), [] { return 1; });
        other = scope.get_or_make<int>(PartKey().add("bigger").add(1), [] { return 2; });
        scope.commit();
    }
    PartScope scope(cache);
    scope.get_or_make<int>(PartKey().add("big").add(2), [&] {
        scope.let_go<int>(PartKey().add("big"));
        EXPECT_TRUE(old.expired());
        return 3;
    });
    EXPECT_FALSE(other.expired());
}

TEST(PartKey, TellsTextsAndArraysApart) {
    EXPECT_NE(PartKey().add("ab").add("c").text(), PartKey().add("a").add("bc").text());
    const Buffer<float> a(std::vector<float>{1}), b(std::vector<float>{1});
    EXPECT_NE(key_of(a).text(), key_of(b).text());
    EXPECT_EQ(key_of(a).text(), key_of(Buffer<float>(a)).text());
}

/// Two balls in a box, one of them twice.
SceneSource some_scene() {
    SceneSource source;
    source.meshes = {ball_mesh(8, 16), ball_mesh(9, 18), box_mesh(Vec3f(-6), Vec3f(6), true)};
    source.instances = {instance_of(0), instance_of(1, Vec3f(1), {2, 0, 0}),
                        instance_of(1, Vec3f(1), {-2, 0, 0}), instance_of(2)};
    return source;
}

std::size_t made(PartCache& cache, const SceneSource& source, const Settings& settings) {
    const std::size_t before = cache.statistics().misses;
    const Scene scene(source, settings, &cache);
    return cache.statistics().misses - before;
}

TEST(SceneParts, AreMadeAgainOnlyWhereSomethingChanged) {
    for (const auto layout : {Settings::Hierarchy::whole, Settings::Hierarchy::by_mesh}) {
        Settings settings;
        settings.hierarchy = layout;
        PartCache cache;
        SceneSource source = some_scene();
        EXPECT_GT(made(cache, source, settings), 5u);
        EXPECT_EQ(made(cache, source, settings), 0u);
        source.camera.world_from_camera[3] += 1;
        EXPECT_EQ(made(cache, source, settings), 0u);
        source.instances[0].world_from_object.translation.x += 1;
        EXPECT_EQ(made(cache, source, settings), 1u) << "the hierarchy over instances";
        source.meshes[0] = ball_mesh(8, 16);
        EXPECT_EQ(made(cache, source, settings), layout == Settings::Hierarchy::whole ? 2u : 3u)
            << "the check of the mesh, its hierarchy, and the one over instances";
        source.instances.pop_back();
        EXPECT_EQ(made(cache, source, settings), 3u) << "the hierarchies, two of them empty";
    }
}

/// Each with parts of the other states against none.
TEST(SceneParts, GiveTheSameHits) {
    for (const auto layout : {Settings::Hierarchy::whole, Settings::Hierarchy::by_mesh}) {
        Settings settings;
        settings.hierarchy = layout;
        PartCache cache;
        SceneSource source = some_scene();
        for (int state = 0; state < 3; ++state) {
            if (state == 1)
                source.instances[0].world_from_object.translation.x += 0.5f;
            if (state == 2)
                source.meshes[1] = ball_mesh(5, 10);
            const Scene fresh(source, settings), kept(source, settings, &cache);
            Rng rng(3);
            for (int n = 0; n < 5000; ++n) {
                const Ray ray{sample_sphere(rng.next2()) * 5.0f, sample_sphere(rng.next2())};
                const Hit a = fresh.intersect(ray, kCameraRay), b = kept.intersect(ray, kCameraRay);
                ASSERT_EQ(a.t, b.t);
                ASSERT_EQ(a.instance, b.instance);
                ASSERT_EQ(a.triangle, b.triangle);
                ASSERT_EQ(a.u, b.u);
            }
        }
    }
}

/// A program of one operation, validated; nothing where there is no such mode.
std::optional<Program> program_of(int op, std::int32_t mode) {
    Program program;
    program.registers = {{0.3f, 0.2f, 0.1f}, {0.7f, 0.5f, 0.9f}, {0.2f, 0.4f, 0.6f}, Vec3f(0.5f), Vec3f(0)};
    program.parameters.assign(16, 0.0f);
    program.parameters[1] = 100;  // pixels
    program.code = {{op, 4, 0, 1, 2, 3, mode >= kShift ? 1 : 0, mode}};
    try {
        validate(program, 1);
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
    return program;
}

struct Told {
    Vec3f value;
    std::string key;
};
Told told(const Program& program, const ShadingPoint& point, const TextureContext& context) {
    std::vector<Vec3f> values(program.registers.size());
    run(program, point, context, values.data());
    PartKey key;
    add_to(key, program, context);
    add_to(key, point);
    return {values.back(), key.text()};
}

TEST(ProgramKeys, ChangeWithWhateverChangesTheValue) {
    Volume volume;
    volume.point.ng = volume.point.ns = normalize(Vec3f(1, 2, 3));
    TextureContext other_camera = volume.context, other_images = volume.context;
    other_camera.camera_from_world.translation += Vec3f(1, 2, 3);
    other_camera.pixel_width *= 20;
    std::vector<Image> images = volume.images;
    images[0].floats = Buffer(std::vector<float>(images[0].floats.size(), 7.0f));
    other_images.images = images;
    Instance instance = volume.instance;
    instance.random = 0.25f;
    instance.color = {0.9f, 0.8f, 0.7f, 0.5f};
    instance.pass_index = 3;
    instance.properties = {{9, 8, 7, 6}};
    ShadingPoint other_object = volume.point;
    other_object.instance = &instance;
    int camera = 0, image = 0, object = 0;  // operations whose values changed
    for (int op = 0; op < kOpCount; ++op) {
        bool of_camera = false, of_image = false, of_object = false;
        for (std::int32_t mode = 0; mode < 64 + 2; ++mode) {
            const auto program = program_of(op, mode < 64 ? mode : (mode - 63) * kShift);
            if (!program)
                continue;
            const Told before = told(*program, volume.point, volume.context);
            const auto compare = [&](const Told& after, bool& changed) {
                if (std::memcmp(&after.value, &before.value, sizeof(Vec3f)) == 0)
                    return;
                changed = true;
                EXPECT_NE(after.key, before.key) << kOpNames[op] << ", mode " << program->code[0].mode;
            };
            compare(told(*program, volume.point, other_camera), of_camera);
            compare(told(*program, volume.point, other_images), of_image);
            compare(told(*program, other_object, volume.context), of_object);
        }
        camera += of_camera;
        image += of_image;
        object += of_object;
    }
    EXPECT_GE(camera, 5);
    EXPECT_EQ(image, 4);
    EXPECT_GE(object, 6);
}

}  // namespace
}  // namespace nephele::test
