// SPDX-License-Identifier: GPL-3.0-or-later
//
// EmbreeScene: an Embree scene with a device of its own, which says how much memory it takes. Included by
// sources alone. Building is for one thread, asking for any.
#pragma once

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstdint>
#include <new>

namespace mote::render {

struct EmbreeScene {
    std::atomic<std::int64_t> bytes{0};  // outlives the device, which counts into it
    // Not of one thread: as long as such a device lives, TBB has no more for anything.
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = nullptr;

    /// Throws std::bad_alloc.
    EmbreeScene() {
        const auto count = [](void* total, ssize_t more, bool) {
            *static_cast<std::atomic<std::int64_t>*>(total) += more;
            return true;
        };
        if (device == nullptr) throw std::bad_alloc();
        rtcSetDeviceMemoryMonitorFunction(device, count, &bytes);
        scene = rtcNewScene(device);
        if (scene != nullptr) return;
        rtcReleaseDevice(device);
        throw std::bad_alloc();
    }
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;
    ~EmbreeScene() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }

    /// Adds a geometry, which the scene holds from then on.
    RTCGeometry add(RTCGeometryType type) {
        const RTCGeometry geometry = rtcNewGeometry(device, type);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        return geometry;
    }
    /// Builds what was added. Throws std::bad_alloc if memory runs out, or ran out before.
    void build(RTCGeometry geometry) {
        rtcCommitGeometry(geometry);
        // One thread builds: pictures of other sessions go on meanwhile.
        tbb::task_arena(1).execute([this] { rtcJoinCommitScene(scene); });
        if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::bad_alloc();
    }
};

}  // namespace mote::render
