// SPDX-License-Identifier: GPL-3.0-or-later
//
// EmbreeScene: an Embree scene with a device of its own, which says how much memory it takes, and how it is
// asked: Embree 3 and 4 ask alike, with other words. Included by sources alone. Building is for one thread,
// asking for any.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/task_arena.h>

#include <atomic>
#include <cstdint>
#include <new>

namespace mote::render {

#if RTC_VERSION_MAJOR >= 4
using RayContext = RTCRayQueryContext;

inline void beginQuery(RayContext& context) {
    rtcInitRayQueryContext(&context);
}
inline RTCIntersectArguments argumentsOf(RayContext& context, bool coherent) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    return arguments;
}
/// Of a packet that goes almost one way.
inline void meet16(const int* valid, RTCScene scene, RayContext& context, RTCRayHit16& rays) {
    auto arguments = argumentsOf(context, true);
    rtcIntersect16(valid, scene, &rays, &arguments);
}
inline void meet1(RTCScene scene, RayContext& context, RTCRayHit& ray) {
    auto arguments = argumentsOf(context, false);
    rtcIntersect1(scene, &ray, &arguments);
}
inline void meetAny(RTCScene scene, RayContext& context, RTCRay& ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &ray, &arguments);
}
#else
using RayContext = RTCIntersectContext;

inline void beginQuery(RayContext& context) {
    rtcInitIntersectContext(&context);
}
/// Of a packet that goes almost one way.
inline void meet16(const int* valid, RTCScene scene, RayContext& context, RTCRayHit16& rays) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rays);
}
inline void meet1(RTCScene scene, RayContext& context, RTCRayHit& ray) {
    rtcIntersect1(scene, &context, &ray);
}
inline void meetAny(RTCScene scene, RayContext& context, RTCRay& ray) {
    rtcOccluded1(scene, &context, &ray);
}
#endif

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
