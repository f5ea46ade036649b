// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/mesh_rays.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <tuple>

#include "server/render/layers/embree_scene.h"

namespace mote::render {
namespace {

/// Embree works in single precision, and in a space in which the bounds' diagonal is 1. Boxes are this much
/// wider there, many times what rounding moves a ray or a corner.
constexpr double margin = 2e-6;

double diagonalOf(const Bounds& bounds) {
    const double diagonal = glm::length(bounds.size());
    return diagonal > 0.0 ? diagonal : 1.0;
}

/// On which side of an edge a ray passes. On the edge itself, the side is that on which the other triangle at
/// this edge, which goes along it the other way, does not have it.
bool passesLeft(double side, const glm::vec3& from, const glm::vec3& to) {
    if (side != 0.0) return side > 0.0;
    return std::tie(from.x, from.y, from.z) < std::tie(to.x, to.y, to.z);
}

/// A triangle as all rays from one place see it, by the volumes that they span with its edges (Pluecker).
class TriangleFrom {
  public:
    TriangleFrom(const storage::SurfaceMesh& mesh, std::uint32_t triangle, const glm::dvec3& origin)
        : triangle_(triangle),
          origin_(origin),
          a_(mesh.positions[mesh.triangles[triangle][0]]),
          b_(mesh.positions[mesh.triangles[triangle][1]]),
          c_(mesh.positions[mesh.triangles[triangle][2]]),
          toA_(glm::dvec3(a_) - origin),
          toC_(glm::dvec3(c_) - origin) {
        const glm::dvec3 toB = glm::dvec3(b_) - origin;
        bc_ = glm::cross(toB, toC_);
        ab_ = glm::cross(toA_, toB);
    }

    const glm::dvec3& origin() const { return origin_; }

    /// Of a ray from there. What most rays that miss do not need is worked out when it is.
    std::optional<MeshMeeting> meet(const MeshRay& ray) const {
        const double z = glm::dot(ab_, ray.direction), x = glm::dot(bc_, ray.direction);
        const bool left = passesLeft(z, a_, b_);
        if (passesLeft(x, b_, c_) != left) return std::nullopt;
        const double y = glm::dot(glm::cross(toC_, toA_), ray.direction);
        if (passesLeft(y, c_, a_) != left) return std::nullopt;
        const glm::dvec3 sides(x, y, z);
        const double sum = sides.x + sides.y + sides.z;
        const glm::dvec3 area = glm::cross(glm::dvec3(b_) - glm::dvec3(a_), glm::dvec3(c_) - glm::dvec3(a_));
        const double speed = glm::dot(area, ray.direction);
        if (sum == 0.0 || speed == 0.0) return std::nullopt;  // seen edge-on
        const double at = glm::dot(area, toA_) / speed;
        if (!(at >= ray.enter && at <= ray.leave)) return std::nullopt;
        return MeshMeeting{triangle_, at, sides / sum};
    }

  private:
    std::uint32_t triangle_;
    glm::dvec3 origin_;
    glm::vec3 a_, b_, c_;
    glm::dvec3 toA_, toC_;
    glm::dvec3 bc_, ab_;
};

}  // namespace

std::optional<MeshMeeting> meet(const storage::SurfaceMesh& mesh, std::uint32_t triangle,
                                const MeshRay& ray) {
    return TriangleFrom(mesh, triangle, ray.origin).meet(ray);
}

/// What is asked of Embree; its callbacks know it by the context that it begins with.
struct MeshRays::Query {
    explicit Query(std::span<const MeshRay> asked) : rays(asked) { beginQuery(context); }

    RayContext context{};
    std::span<const MeshRay> rays;  // by the id of Embree's ray
    MeshMeeting* first = nullptr;   // of each ray; or:
    std::vector<MeshMeeting>* all = nullptr;
    std::span<const IgnoredTriangles> ignored = {};  // of each ray, or of none

    bool ignores(std::uint32_t id, std::uint32_t triangle) const {
        return !ignored.empty() && (ignored[id][0] == triangle || ignored[id][1] == triangle);
    }
};

struct MeshRays::Scene : EmbreeScene {
    const storage::SurfaceMesh& mesh;
    glm::dvec3 center;
    double unit;  // of Embree's space, layer space
    Bounds box;

    Scene(const storage::SurfaceMesh& of, const Bounds& bounds);

    glm::dvec3 inUnit(const glm::dvec3& inLayer) const { return (inLayer - center) / unit; }
    /// How far Embree looks along a ray that ends there.
    float reach(const MeshRay& ray, double end) const {
        return static_cast<float>((end - ray.enter) * glm::length(ray.direction) / unit + margin);
    }
    RTCRay toEmbree(const MeshRay& ray, unsigned id) const {
        const glm::vec3 from(inUnit(ray.origin + ray.enter * ray.direction));
        const glm::vec3 way(glm::normalize(ray.direction));
        return {.org_x = from.x,
                .org_y = from.y,
                .org_z = from.z,
                .tnear = 0.0F,
                .dir_x = way.x,
                .dir_y = way.y,
                .dir_z = way.z,
                .time = 0.0F,
                .tfar = reach(ray, ray.leave),
                .mask = ~0U,
                .id = id,
                .flags = 0};
    }
    void take(const MeshMeeting& met, std::uint32_t id, const Query& query, float& far) const {
        if (query.all != nullptr) {
            query.all->push_back(met);
            return;
        }
        MeshMeeting& first = query.first[id];
        const bool nearer = std::tie(met.at, met.triangle) < std::tie(first.at, first.triangle);
        if (first.triangle != MeshMeeting::none && !nearer) return;
        first = met;
        far = std::min(far, reach(query.rays[id], met.at));
    }

    static void bounds(const RTCBoundsFunctionArguments* asked);
    static void intersect(const RTCIntersectFunctionNArguments* asked);
    static void occlude(const RTCOccludedFunctionNArguments* asked);
};

MeshRays::Scene::Scene(const storage::SurfaceMesh& of, const Bounds& bounds)
    : mesh(of), center(bounds.center()), unit(diagonalOf(bounds)), box(bounds) {
    box.min -= 0.5 * margin * unit;
    box.max += 0.5 * margin * unit;
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = add(RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangles.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, Scene::bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occlude);
    build(geometry);
}

void MeshRays::Scene::bounds(const RTCBoundsFunctionArguments* asked) {
    const auto& self = *static_cast<const Scene*>(asked->geometryUserPtr);
    Bounds triangle{glm::dvec3(std::numeric_limits<double>::infinity()),
                    glm::dvec3(-std::numeric_limits<double>::infinity())};
    for (const auto vertex : self.mesh.triangles[asked->primID]) {
        const glm::dvec3 at = self.inUnit(self.mesh.positions[vertex]);
        triangle = triangle.united({at - margin, at + margin});
    }
    const glm::vec3 low(triangle.min), high(triangle.max);
    *asked->bounds_o = {low.x, low.y, low.z, 0.0F, high.x, high.y, high.z, 0.0F};
}

void MeshRays::Scene::intersect(const RTCIntersectFunctionNArguments* asked) {
    const auto& self = *static_cast<const Scene*>(asked->geometryUserPtr);
    const auto& query = *reinterpret_cast<const Query*>(asked->context);
    RTCRayN* const rays = RTCRayHitN_RayN(asked->rayhit, asked->N);
    std::optional<TriangleFrom> triangle;  // in a perspective all rays begin in one place
    for (unsigned i = 0; i < asked->N; ++i) {
        if (asked->valid[i] == 0) continue;
        const unsigned id = RTCRayN_id(rays, asked->N, i);
        if (query.ignores(id, asked->primID)) continue;
        const MeshRay& ray = query.rays[id];
        if (!triangle || triangle->origin() != ray.origin)
            triangle.emplace(self.mesh, asked->primID, ray.origin);
        if (const auto met = triangle->meet(ray)) self.take(*met, id, query, RTCRayN_tfar(rays, asked->N, i));
    }
}

void MeshRays::Scene::occlude(const RTCOccludedFunctionNArguments* asked) {
    const auto& self = *static_cast<const Scene*>(asked->geometryUserPtr);
    const auto& query = *reinterpret_cast<const Query*>(asked->context);
    for (unsigned i = 0; i < asked->N; ++i) {
        if (asked->valid[i] == 0) continue;
        const unsigned id = RTCRayN_id(asked->ray, asked->N, i);
        if (meet(self.mesh, asked->primID, query.rays[id]))
            RTCRayN_tfar(asked->ray, asked->N, i) = -std::numeric_limits<float>::infinity();
    }
}

void MeshRay::clip(const Bounds& box) {
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.min[axis] - origin[axis], high = box.max[axis] - origin[axis];
        const double speed = direction[axis];
        if (speed == 0.0) {
            if (low > 0.0 || high < 0.0) leave = -std::numeric_limits<double>::infinity();
            continue;
        }
        enter = std::max(enter, std::min(low / speed, high / speed));
        leave = std::min(leave, std::max(low / speed, high / speed));
    }
}

MeshRays::MeshRays(const storage::SurfaceMesh& mesh, const Bounds& bounds)
    : scene_(std::make_unique<const Scene>(mesh, bounds)) {}

MeshRays::~MeshRays() = default;

const Bounds& MeshRays::box() const {
    return scene_->box;
}

std::uint64_t MeshRays::bytes() const {
    return static_cast<std::uint64_t>(scene_->bytes.load());
}

void MeshRays::first(std::span<const MeshRay, packet> rays, std::span<MeshMeeting, packet> met) const {
    Query query(rays);
    query.first = met.data();
    trace(query);
}

void MeshRays::firstBut(std::span<const MeshRay, packet> rays,
                        std::span<const IgnoredTriangles, packet> ignored,
                        std::span<MeshMeeting, packet> met) const {
    Query query(rays);
    query.first = met.data();
    query.ignored = ignored;
    trace(query);
}

/// Of a packet that goes almost one way.
void MeshRays::trace(Query& query) const {
    std::fill_n(query.first, packet, MeshMeeting{});
    RTCRayHit16 hits{};
    alignas(64) std::array<int, packet> valid{};
    for (unsigned i = 0; i < packet; ++i) {
        hits.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        if (query.rays[i].empty()) continue;
        valid[i] = -1;
        const RTCRay ray = scene_->toEmbree(query.rays[i], i);
        hits.ray.org_x[i] = ray.org_x;
        hits.ray.org_y[i] = ray.org_y;
        hits.ray.org_z[i] = ray.org_z;
        hits.ray.dir_x[i] = ray.dir_x;
        hits.ray.dir_y[i] = ray.dir_y;
        hits.ray.dir_z[i] = ray.dir_z;
        hits.ray.tfar[i] = ray.tfar;
        hits.ray.mask[i] = ray.mask;
        hits.ray.id[i] = ray.id;
    }
    meet16(valid.data(), scene_->scene, query.context, hits);
}

void MeshRays::all(const MeshRay& ray, std::vector<MeshMeeting>& met) const {
    met.clear();
    if (ray.empty()) return;
    Query query({&ray, 1});
    query.all = &met;
    RTCRayHit way{.ray = scene_->toEmbree(ray, 0), .hit = {}};
    way.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    meet1(scene_->scene, query.context, way);
    const auto before = [](const MeshMeeting& a, const MeshMeeting& b) {
        return std::tie(a.at, a.triangle) < std::tie(b.at, b.triangle);
    };
    const auto same = [](const MeshMeeting& a, const MeshMeeting& b) { return a.triangle == b.triangle; };
    std::sort(met.begin(), met.end(), before);
    met.erase(std::unique(met.begin(), met.end(), same), met.end());
}

MeshMeeting MeshRays::firstBut(const MeshRay& ray, const IgnoredTriangles& ignored) const {
    MeshMeeting met;
    if (ray.empty()) return met;
    Query query({&ray, 1});
    query.first = &met;
    query.ignored = {&ignored, 1};
    RTCRayHit way{.ray = scene_->toEmbree(ray, 0), .hit = {}};
    way.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    meet1(scene_->scene, query.context, way);
    return met;
}

bool MeshRays::blocked(const MeshRay& ray) const {
    if (ray.empty()) return false;
    Query query({&ray, 1});
    RTCRay way = scene_->toEmbree(ray, 0);
    meetAny(scene_->scene, query.context, way);
    return way.tfar < 0.0F;
}

}  // namespace mote::render
