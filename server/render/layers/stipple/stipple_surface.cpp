// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/stipple_surface.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "server/render/layers/embree_scene.h"

namespace mote::render {

struct SurfaceRays::Scene : EmbreeScene {
    template <class Item>
    static void copy(RTCGeometry geometry, RTCBufferType type, RTCFormat format,
                     std::span<const Item> items) {
        void* const to = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size());
        if (to == nullptr) throw std::bad_alloc();
        std::copy(items.begin(), items.end(), static_cast<Item*>(to));
    }
};

SurfaceRays::SurfaceRays(std::span<const glm::vec3> positions,
                         std::span<const std::array<std::uint32_t, 3>> triangles) {
    auto made = std::make_unique<Scene>();
    // Without this, rays slip through the edge between two triangles.
    rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = made->add(RTC_GEOMETRY_TYPE_TRIANGLE);
    made->copy(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions);
    made->copy(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    made->build(geometry);
    scene_ = std::move(made);
}

SurfaceRays::~SurfaceRays() = default;
SurfaceRays::SurfaceRays(SurfaceRays&&) noexcept = default;
SurfaceRays& SurfaceRays::operator=(SurfaceRays&&) noexcept = default;

std::uint64_t SurfaceRays::bytes() const {
    return static_cast<std::uint64_t>(scene_->bytes.load());
}

bool SurfaceRays::blocked(const glm::vec3& from, const glm::vec3& direction, float reach) const {
    RayContext context;
    beginQuery(context);
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
    meetAny(scene_->scene, context, ray);
    return ray.tfar < 0.0F;
}

StippleSurface::StippleSurface(StippleReplay replay, SurfaceRays rays, const Bounds& bounds, double area)
    : replay_(std::move(replay)),
      rays_(std::move(rays)),
      bounds_(bounds),
      density_(static_cast<double>(replay_.size()) / area),
      tolerance_(static_cast<float>(0.05 / std::sqrt(std::max(density_, 1e-30)))) {}

bool StippleSurface::hides(const glm::vec3& place, const glm::vec3& normal, const glm::vec3& direction,
                           float reach) const {
    // Rays start off the surface, on the side from which it is looked at.
    const float side = glm::dot(normal, direction) < 0.0F ? -tolerance_ : tolerance_;
    return rays_.blocked(place + side * normal, direction, reach);
}

}  // namespace mote::render
