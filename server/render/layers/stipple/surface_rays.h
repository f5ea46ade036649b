// SPDX-License-Identifier: GPL-3.0-or-later
//
// SurfaceRays: whether a triangle mesh lies in the way of a ray (Embree). Made once for a dataset, immutable;
// any number of threads may ask.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

namespace mote::render {

class SurfaceRays {
  public:
    /// Copies the mesh. Throws std::bad_alloc where memory runs out.
    SurfaceRays(std::span<const glm::vec3> positions,
                std::span<const std::array<std::uint32_t, 3>> triangles);
    ~SurfaceRays();
    SurfaceRays(SurfaceRays&&) noexcept;
    SurfaceRays& operator=(SurfaceRays&&) noexcept;

    /// Whether a triangle is met between `from` and `from` + `reach` * `direction`; `reach` may be infinite.
    bool blocked(const glm::vec3& from, const glm::vec3& direction, float reach) const;

    /// That it takes in memory, its tree included, as Embree counts them.
    std::uint64_t bytes() const;

  private:
    struct Scene;
    std::unique_ptr<const Scene> scene_;
};

}  // namespace mote::render
