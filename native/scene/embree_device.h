// SPDX-License-Identifier: GPL-3.0-or-later
// Embree's device: hierarchies that are to be put together, from one scene to the next, must be of one.
#pragma once

#if NEPHELE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>
#include <mutex>
#include <stdexcept>
#include <string>

namespace nephele::embree {

class Device {
  public:
    /// Throws std::runtime_error.
    Device() : handle_(rtcNewDevice(nullptr)) {
        if (handle_ == nullptr)
            throw std::runtime_error("Embree could not be started");
        const auto monitor = [](void* self, ssize_t bytes, bool) {
            static_cast<Device*>(self)->memory_ += bytes;
            return true;
        };
        rtcSetDeviceMemoryMonitorFunction(handle_, monitor, this);
    }
    ~Device() { rtcReleaseDevice(handle_); }
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    RTCDevice handle() const { return handle_; }

    RTCScene new_scene() const {
        RTCScene scene = rtcNewScene(handle_);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST
#if NEPHELE_EMBREE_MAJOR < 4
                                    | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#endif
        );
        return scene;
    }

    /// Builds a hierarchy, one at a time. Returns the memory that Embree holds more of, bytes. Throws
    /// std::runtime_error naming the cause.
    std::ptrdiff_t commit(RTCScene scene) const {
        const std::lock_guard lock(building_);
        const std::ptrdiff_t before = memory_;
        rtcCommitScene(scene);
        const RTCError error = rtcGetDeviceError(handle_);
        if (error != RTC_ERROR_NONE) {
            throw std::runtime_error("Embree failed to build the ray tracing hierarchy (error " +
                                     std::to_string(static_cast<int>(error)) + ", 4 is out of memory)");
        }
        return memory_ - before;
    }

  private:
    RTCDevice handle_;
    std::atomic<std::ptrdiff_t> memory_{0};
    mutable std::mutex building_;
};

/// A scene of Embree's, released in the end.
class SceneHandle {
  public:
    explicit SceneHandle(RTCScene scene) : scene_(scene) {}
    ~SceneHandle() { rtcReleaseScene(scene_); }
    SceneHandle(const SceneHandle&) = delete;
    SceneHandle& operator=(const SceneHandle&) = delete;
    RTCScene get() const { return scene_; }

  private:
    RTCScene scene_;
};

/// Gives a geometry to a scene under a number.
inline void attach(RTCScene scene, RTCGeometry geometry, std::uint32_t number) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, number);
    rtcReleaseGeometry(geometry);
}

}  // namespace nephele::embree
