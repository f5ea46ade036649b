// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/surface_rays.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <new>

namespace mote::render {

struct SurfaceRays::Scene {
    std::atomic<std::int64_t> bytes{0};  // outlives the device, which counts into it
    // One thread builds: pictures of other sessions go on meanwhile.
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = nullptr;

    Scene() {
        const auto count = [](void* total, ssize_t more, bool) {
            *static_cast<std::atomic<std::int64_t>*>(total) += more;
            return true;
        };
        if (device == nullptr) return;
        rtcSetDeviceMemoryMonitorFunction(device, count, &bytes);
        scene = rtcNewScene(device);
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    ~Scene() {
        if (scene != nullptr) rtcReleaseScene(scene);
        if (device != nullptr) rtcReleaseDevice(device);
    }
    void check() const {
        if (scene == nullptr || rtcGetDeviceError(device) != RTC_ERROR_NONE) throw std::bad_alloc();
    }
    template <class Item>
    void copy(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::span<const Item> items) const {
        void* const to = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size());
        if (to == nullptr) throw std::bad_alloc();
        std::copy(items.begin(), items.end(), static_cast<Item*>(to));
    }
};

SurfaceRays::SurfaceRays(std::span<const glm::vec3> positions,
                         std::span<const std::array<std::uint32_t, 3>> triangles) {
    auto made = std::make_unique<Scene>();
    made->check();
    // Without this, rays slip through the edge between two triangles.
    rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcAttachGeometry(made->scene, geometry);
    rtcReleaseGeometry(geometry);  // the scene holds it
    made->copy(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions);
    made->copy(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    rtcCommitGeometry(geometry);
    rtcCommitScene(made->scene);
    made->check();
    scene_ = std::move(made);
}

SurfaceRays::~SurfaceRays() = default;
SurfaceRays::SurfaceRays(SurfaceRays&&) noexcept = default;
SurfaceRays& SurfaceRays::operator=(SurfaceRays&&) noexcept = default;

std::uint64_t SurfaceRays::bytes() const {
    return static_cast<std::uint64_t>(scene_->bytes.load());
}

bool SurfaceRays::blocked(const glm::vec3& from, const glm::vec3& direction, float reach) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray{};
    ray.org_x = from.x;
    ray.org_y = from.y;
    ray.org_z = from.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tnear = 0.0F;
    ray.tfar = reach;
    ray.mask = ~0U;
    rtcOccluded1(scene_->scene, &context, &ray);
    return ray.tfar < 0.0F;
}

}  // namespace mote::render
