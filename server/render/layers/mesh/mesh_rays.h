// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshRays: what rays meet of a triangle mesh. Embree finds the triangles that may be met; whether one is,
// and where, is decided here in double precision by single steps of arithmetic: at any magnification, and
// with the same result on every processor. If triangles share an edge, a ray through it meets one of them.
// Made once for a dataset, immutable, refers to the mesh; any number of threads may ask.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/scene/clip.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::render {

/// A ray in layer space: origin + at * direction, from `enter` to `leave`, both finite; none if it ends
/// before it begins.
struct MeshRay {
    glm::dvec3 origin{0.0};
    glm::dvec3 direction{0.0, 0.0, 1.0};
    double enter = 0.0, leave = -1.0;

    bool empty() const { return !(enter <= leave); }
    /// Ends it where it leaves a box, and begins it where it enters that.
    void clip(const Bounds& box);
    /// The same of what clips leave.
    void clip(const HalfSpaces& clips) { clipWay(clips, origin, direction, enter, leave); }
};

/// Where a ray meets a triangle; the weights of its corners add up to 1.
struct MeshMeeting {
    static constexpr std::uint32_t none = UINT32_MAX;

    std::uint32_t triangle = none;
    double at = 0.0;  ///< directions from the ray's origin
    glm::dvec3 weights{0.0};
};

/// Whether and where a ray meets a triangle: what decides, whatever finds it.
std::optional<MeshMeeting> meet(const storage::SurfaceMesh& mesh, std::uint32_t triangle, const MeshRay& ray);

/// Two triangles, or MeshMeeting::none, which a ray goes through.
using IgnoredTriangles = std::array<std::uint32_t, 2>;

class MeshRays {
  public:
    static constexpr std::size_t packet = 16;

    /// `bounds`: of the mesh's vertices. Throws std::bad_alloc if memory runs out.
    MeshRays(const storage::SurfaceMesh& mesh, const Bounds& bounds);
    ~MeshRays();
    MeshRays(const MeshRays&) = delete;
    MeshRays& operator=(const MeshRays&) = delete;

    /// The mesh's bounds, a little wider: rays are clipped to them, or meet what lies between.
    const Bounds& box() const;
    /// What each of some rays that go almost the same way meets first; of triangles in one place, that with
    /// the least number.
    void first(std::span<const MeshRay, packet> rays, std::span<MeshMeeting, packet> met) const;
    /// The same but for two triangles of each ray's own.
    void firstBut(std::span<const MeshRay, packet> rays, std::span<const IgnoredTriangles, packet> ignored,
                  std::span<MeshMeeting, packet> met) const;
    /// All that a ray meets, in order, each triangle once.
    void all(const MeshRay& ray, std::vector<MeshMeeting>& met) const;
    /// What a ray meets first but for two triangles.
    MeshMeeting firstBut(const MeshRay& ray, const IgnoredTriangles& ignored) const;
    /// Whether it meets anything.
    bool blocked(const MeshRay& ray) const;

    /// That it takes in memory beside the mesh, as Embree counts.
    std::uint64_t bytes() const;

  private:
    struct Scene;
    struct Query;
    void trace(Query& query) const;

    std::unique_ptr<const Scene> scene_;
};

}  // namespace mote::render
