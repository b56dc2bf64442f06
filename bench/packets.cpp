// SPDX-License-Identifier: GPL-3.0-or-later
// Do coherent rays in packets pay? Times Embree's single rays against packets of 8 and 16 on what could be
// put into packets: camera rays of 4 x 4 pixel tiles, and their shadow rays to one small lamp. One thread,
// one mesh of a rough ball, as Markdown.
//
//     packets [RESOLUTION]
#if NEPHELE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "math/sampler.h"
#include "thread_time.h"

namespace {

using namespace nephele;
using bench::thread_seconds;

/// A ball with bumps above a floor, of about 2 n^2 triangles.
RTCScene make_scene(RTCDevice device, unsigned n) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry ball = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        ball, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), (n + 1) * (n + 1)));
    auto* triangles = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        ball, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), 2 * std::size_t{n} * n));
    for (unsigned i = 0; i <= n; ++i) {
        for (unsigned j = 0; j <= n; ++j) {
            const float a = kPi * static_cast<float>(i) / static_cast<float>(n);
            const float b = 2 * kPi * static_cast<float>(j) / static_cast<float>(n);
            const float r = 1 + 0.05f * std::sin(40 * a) * std::sin(30 * b);
            *vertices++ = r * std::sin(a) * std::cos(b);
            *vertices++ = r * std::sin(a) * std::sin(b);
            *vertices++ = r * std::cos(a);
        }
    }
    for (unsigned i = 0; i < n; ++i) {
        for (unsigned j = 0; j < n; ++j) {
            const unsigned v = i * (n + 1) + j;
            for (const unsigned corner : {v, v + 1, v + n + 1, v + 1, v + n + 2, v + n + 1})
                *triangles++ = corner;
        }
    }
    rtcCommitGeometry(ball);
    rtcAttachGeometry(scene, ball);
    rtcReleaseGeometry(ball);
    rtcCommitScene(scene);
    return scene;
}

#if NEPHELE_EMBREE_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& ray) {
    rtcIntersect1(scene, &ray);
}
void intersect(const int* valid, RTCScene scene, RTCRayHit8& rays) {
    rtcIntersect8(valid, scene, &rays);
}
void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
    rtcIntersect16(valid, scene, &rays);
}
void occluded(RTCScene scene, RTCRay& ray) {
    rtcOccluded1(scene, &ray);
}
void occluded(const int* valid, RTCScene scene, RTCRay8& rays) {
    rtcOccluded8(valid, scene, &rays);
}
void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
    rtcOccluded16(valid, scene, &rays);
}
#else
struct Coherent : RTCIntersectContext {
    Coherent() {
        rtcInitIntersectContext(this);
        flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    }
};
void intersect(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray);
}
void intersect(const int* valid, RTCScene scene, RTCRayHit8& rays) {
    Coherent context;
    rtcIntersect8(valid, scene, &context, &rays);
}
void intersect(const int* valid, RTCScene scene, RTCRayHit16& rays) {
    Coherent context;
    rtcIntersect16(valid, scene, &context, &rays);
}
void occluded(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
}
void occluded(const int* valid, RTCScene scene, RTCRay8& rays) {
    Coherent context;
    rtcOccluded8(valid, scene, &context, &rays);
}
void occluded(const int* valid, RTCScene scene, RTCRay16& rays) {
    Coherent context;
    rtcOccluded16(valid, scene, &context, &rays);
}
#endif

/// Camera rays in tiles of 4 x 4, each through a random point of its pixel.
std::vector<Ray> camera_rays(int resolution) {
    std::vector<Ray> rays;
    Rng rng(1);
    const Vec3f eye(0, -3, 0.5f);
    for (int ty = 0; ty < resolution; ty += 4) {
        for (int tx = 0; tx < resolution; tx += 4) {
            for (int k = 0; k < 16; ++k) {
                const float u =
                    (static_cast<float>(tx + k % 4) + rng.next()) / static_cast<float>(resolution);
                const float v =
                    (static_cast<float>(ty + k / 4) + rng.next()) / static_cast<float>(resolution);
                rays.push_back({eye, normalize(Vec3f(u - 0.5f, 1.2f, v - 0.6f)), 0, 1e30f});
            }
        }
    }
    return rays;
}

/// From where the camera rays hit to points of a lamp 0.1 m wide, still in tiles; where one hits nothing, it
/// stays as a ray of no length.
std::vector<Ray> shadow_rays(RTCScene scene, const std::vector<Ray>& camera) {
    std::vector<Ray> rays;
    Rng rng(2);
    for (const Ray& r : camera) {
        RTCRayHit h{};
        h.ray = {r.o.x, r.o.y, r.o.z, 0, r.d.x, r.d.y, r.d.z, 0, 1e30f, ~0u, 0, 0};
        h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        intersect(scene, h);
        const Vec3f lamp = Vec3f(2, -2, 3) + (Vec3f(rng.next(), rng.next(), rng.next()) - Vec3f(0.5f)) * 0.1f;
        const Vec3f p = h.hit.geomID == RTC_INVALID_GEOMETRY_ID ? lamp : r.at(h.ray.tfar * 0.999f);
        const float distance = length(lamp - p);
        rays.push_back({p, distance > 0 ? (lamp - p) / distance : Vec3f(0, 0, 1), 0, distance});
    }
    return rays;
}

template <class Packet, int N>
void fill(Packet& p, const Ray* rays) {
    for (int k = 0; k < N; ++k) {
        p.org_x[k] = rays[k].o.x, p.org_y[k] = rays[k].o.y, p.org_z[k] = rays[k].o.z;
        p.dir_x[k] = rays[k].d.x, p.dir_y[k] = rays[k].d.y, p.dir_z[k] = rays[k].d.z;
        p.tnear[k] = 0, p.tfar[k] = rays[k].t_max, p.time[k] = 0, p.mask[k] = ~0u, p.id[k] = 0,
        p.flags[k] = 0;
    }
}

template <class RayHitN, int N>
double packets(RTCScene scene, const std::vector<Ray>& rays, bool shadow) {
    alignas(64) int valid[N];
    std::fill(valid, valid + N, -1);
    const double start = thread_seconds();
    for (std::size_t i = 0; i + N <= rays.size(); i += N) {
        alignas(64) RayHitN p;
        fill<decltype(p.ray), N>(p.ray, rays.data() + i);
        if (shadow) {
            occluded(valid, scene, p.ray);
            continue;
        }
        std::fill(p.hit.geomID, p.hit.geomID + N, RTC_INVALID_GEOMETRY_ID);
        std::fill(p.hit.instID[0], p.hit.instID[0] + N, RTC_INVALID_GEOMETRY_ID);
        intersect(valid, scene, p);
    }
    return (thread_seconds() - start) * 1e9 / static_cast<double>(rays.size());
}

double singles(RTCScene scene, const std::vector<Ray>& rays, bool shadow) {
    const double start = thread_seconds();
    for (const Ray& r : rays) {
        RTCRayHit h{};
        h.ray = {r.o.x, r.o.y, r.o.z, 0, r.d.x, r.d.y, r.d.z, 0, r.t_max, ~0u, 0, 0};
        h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        shadow ? occluded(scene, h.ray) : intersect(scene, h);
    }
    return (thread_seconds() - start) * 1e9 / static_cast<double>(rays.size());
}

}  // namespace

int main(int argc, char** argv) {
    const int resolution = argc > 1 ? std::atoi(argv[1]) : 1024;
    RTCDevice device = rtcNewDevice("threads=1");
    std::printf(
        "| rays | triangles | single ns | packets of 8 ns | of 16 ns | best gain "
        "|\n|---|---|---|---|---|---|\n");
    for (const unsigned n : {8u, 100u, 1000u}) {
        RTCScene scene = make_scene(device, n);
        const std::vector<Ray> camera = camera_rays(resolution), shadow = shadow_rays(scene, camera);
        for (const bool is_shadow : {false, true}) {
            const std::vector<Ray>& rays = is_shadow ? shadow : camera;
            double best[3] = {1e30, 1e30, 1e30};
            for (int run = 0; run < 5; ++run) {
                best[0] = std::min(best[0], singles(scene, rays, is_shadow));
                best[1] = std::min(best[1], packets<RTCRayHit8, 8>(scene, rays, is_shadow));
                best[2] = std::min(best[2], packets<RTCRayHit16, 16>(scene, rays, is_shadow));
            }
            std::printf("| %s | %u | %.0f | %.0f | %.0f | %.2f |\n", is_shadow ? "shadow" : "camera",
                        2 * n * n, best[0], best[1], best[2], best[0] / std::min(best[1], best[2]));
        }
        rtcReleaseScene(scene);
    }
    rtcReleaseDevice(device);
    return 0;
}
