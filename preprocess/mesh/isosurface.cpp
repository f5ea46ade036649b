// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/isosurface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <utility>

namespace mote::prep {
namespace {

constexpr std::uint32_t none = UINT32_MAX;
/// Steps along the gradient: from the middle of a cell's crossings two come within a thousandth of it.
constexpr int steps = 3;

/// The corners of a cell: bit 0 of a corner's number is its x, bit 1 its y, bit 2 its z.
using CellCorners = std::array<float, 8>;

glm::dvec3 placeOf(unsigned corner) {
    return {corner & 1U, corner >> 1U & 1U, corner >> 2U & 1U};
}

/// The trilinear interpolation of a cell's corners, less the surface's value.
struct CellField {
    CellCorners corners;
    double value;

    double at(const glm::dvec3& place) const {
        double sum = 0.0;
        for (unsigned i = 0; i < 8; ++i) sum += weight(i, place) * corners[i];
        return sum - value;
    }
    glm::dvec3 gradient(const glm::dvec3& place) const {
        glm::dvec3 slope(0.0);
        for (unsigned i = 0; i < 8; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                glm::dvec3 there = place;
                there[axis] = placeOf(i)[axis];  // of this axis the weight's slope alone counts
                slope[axis] += (placeOf(i)[axis] > 0.0 ? 1.0 : -1.0) * weight(i, there) * corners[i];
            }
        }
        return slope;
    }
    static double weight(unsigned corner, const glm::dvec3& place) {
        const glm::dvec3 far = placeOf(corner);
        const glm::dvec3 shares = far * place + (1.0 - far) * (1.0 - place);
        return shares.x * shares.y * shares.z;
    }
};

/// Where the surface crosses the edge between two samples, one inside and one outside, 0 to 1.
double crossing(float from, float to, double value) {
    if (!std::isfinite(from) || !std::isfinite(to)) return 0.5;
    return std::clamp((value - from) / (static_cast<double>(to) - from), 0.0, 1.0);
}

class SurfaceNet {
  public:
    SurfaceNet(const VolumeShape& shape, const IsosurfaceOptions& options)
        : options_(options),
          shape_(shape),
          nx_(shape.nx),
          ny_(shape.ny),
          mostTriangles_(std::min<std::uint64_t>(options.mostTriangles, UINT32_MAX / 4)) {
        for (auto& slice : slices_) slice.resize(shape.voxelsOfSlice());
        for (auto& inside : inside_) inside.resize(shape.voxelsOfSlice());
        for (auto& layer : vertices_) layer.resize(shape.voxelsOfSlice(), none);
        mesh_.origin = origin();
        // Seen from outside, which a mirror image turns round.
        mirrored_ = glm::determinant(glm::dmat3(shape.indexToWorld)) < 0.0;
    }

    /// The next slice's values, to be filled before add().
    std::span<float> next() { return slices_[1]; }
    /// Takes the slice, the z-th.
    Status add(std::uint32_t z) {
        for (std::size_t i = 0; i < slices_[1].size(); ++i) {
            float& value = slices_[1][i];
            if (!std::isfinite(value)) value = std::numeric_limits<float>::quiet_NaN();
            inside_[1][i] = value >= options_.value ? 1 : 0;  // not if it is no number
            if (std::isnan(value)) continue;
            low_ = std::min(low_, value);
            high_ = std::max(high_, value);
        }
        if (z > 0) addLayer(z - 1);
        std::swap(slices_[0], slices_[1]);
        std::swap(inside_[0], inside_[1]);
        if (!full()) return success();
        return Error{ErrorCode::resourceExhausted, "isovalue",
                     fmt::format("its surface has more than {} triangles, for which the job's memory does "
                                 "not do: clip it, or give more",
                                 mostTriangles_)};
    }
    Result<TriangleMesh> take() {
        if (!mesh_.triangles.empty()) return std::move(mesh_);
        return invalid("isovalue", whyEmpty());
    }

  private:
    /// The origin for the volume's box, or what of it is kept.
    glm::dvec3 origin() const {
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
        const glm::dvec3 last(shape_.nx - 1.0, shape_.ny - 1.0, shape_.nz - 1.0);
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::dvec3 world(shape_.indexToWorld * glm::dvec4(placeOf(corner) * last, 1.0));
            low = glm::min(low, world);
            high = glm::max(high, world);
        }
        if (options_.clip) {
            low = glm::max(low, options_.clip->min);
            high = glm::max(low, glm::min(high, options_.clip->max));
        }
        return originFor(low, high);
    }
    std::string whyEmpty() const {
        if (low_ > high_) return "the volume has no values that are numbers";
        if (!(low_ < options_.value && options_.value <= high_))
            return fmt::format("there is no surface at {}: values go from {} to {}", options_.value, low_,
                               high_);
        return options_.clip ? "the clip box leaves nothing of its surface"
                             : "its surface only touches the volume's sides";
    }
    bool full() const { return mesh_.triangles.size() > mostTriangles_; }
    std::size_t sample(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * nx_ + x; }

    /// The cells between the two slices, and the quadrilaterals around edges that have all their cells now.
    void addLayer(std::uint32_t z) {
        std::swap(vertices_[0], vertices_[1]);
        std::fill(vertices_[1].begin(), vertices_[1].end(), none);
        for (std::uint32_t y = 0; y + 1 < ny_; ++y) {
            for (std::uint32_t x = 0; x + 1 < nx_; ++x) {
                if (crossed(x, y)) vertices_[1][sample(x, y)] = addVertex(x, y, z);
            }
        }
        for (std::uint32_t y = 0; y + 1 < ny_ && !full(); ++y)
            for (std::uint32_t x = 0; x + 1 < nx_; ++x) addFaces(x, y, z);
    }
    bool crossed(std::uint32_t x, std::uint32_t y) const {
        const std::size_t i = sample(x, y), above = i + nx_;
        int sum = 0;
        for (const auto& inside : inside_)
            sum += inside[i] + inside[i + 1] + inside[above] + inside[above + 1];
        return sum != 0 && sum != 8;
    }
    std::uint32_t addVertex(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        const glm::dvec3 index = glm::dvec3(x, y, z) + placeIn(cornersOf(x, y));
        const glm::dvec3 world(shape_.indexToWorld * glm::dvec4(index, 1.0));
        if (options_.clip && (glm::any(glm::lessThan(world, options_.clip->min)) ||
                              glm::any(glm::greaterThan(world, options_.clip->max))))
            return none;
        mesh_.positions.emplace_back(world - mesh_.origin);
        return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
    }
    CellCorners cornersOf(std::uint32_t x, std::uint32_t y) const {
        CellCorners corners;
        for (unsigned i = 0; i < 8; ++i)
            corners[i] = slices_[i >> 2U & 1U][sample(x + (i & 1U), y + (i >> 1U & 1U))];
        return corners;
    }
    /// Where a crossed cell has its vertex: the middle of its edges' crossings, then along the gradient.
    glm::dvec3 placeIn(const CellCorners& corners) const {
        glm::dvec3 sum(0.0);
        int count = 0;
        for (unsigned from = 0; from < 8; ++from) {
            for (const unsigned axis : {1U, 2U, 4U}) {
                const unsigned to = from | axis;
                if (to == from || (corners[from] >= options_.value) == (corners[to] >= options_.value))
                    continue;
                sum += glm::mix(placeOf(from), placeOf(to),
                                crossing(corners[from], corners[to], options_.value));
                ++count;
            }
        }
        glm::dvec3 place = sum / static_cast<double>(count);
        if (!std::all_of(corners.begin(), corners.end(), [](float v) { return std::isfinite(v); }))
            return place;
        const CellField field{corners, options_.value};
        for (int i = 0; i < steps; ++i) {
            const glm::dvec3 slope = field.gradient(place);
            const double square = glm::dot(slope, slope);
            if (!(square > 0.0)) break;
            place = glm::clamp(place - field.at(place) / square * slope, 0.0, 1.0);
        }
        return place;
    }

    /// Around the three edges from sample (x, y, z) on, of which those across need the layer before.
    void addFaces(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        const std::size_t here = sample(x, y);
        const auto& now = vertices_[1];
        if (x > 0 && y > 0 && inside_[0][here] != inside_[1][here])
            addQuad(inside_[0][here], {now[here - nx_ - 1], now[here - nx_], now[here], now[here - 1]});
        if (z == 0) return;
        const auto& before = vertices_[0];
        if (y > 0 && inside_[0][here] != inside_[0][here + 1])
            addQuad(inside_[0][here], {before[here - nx_], before[here], now[here], now[here - nx_]});
        if (x > 0 && inside_[0][here] != inside_[0][here + nx_])
            addQuad(inside_[0][here], {before[here - 1], now[here - 1], now[here], before[here]});
    }
    /// `corners`: counterclockwise seen from the edge's far end; `insideFirst`: its near end is inside, so
    /// that the far one sees the surface from outside. Cut along the shorter diagonal.
    void addQuad(bool insideFirst, std::array<std::uint32_t, 4> corners) {
        if (std::find(corners.begin(), corners.end(), none) != corners.end()) return;
        if (insideFirst == mirrored_) std::swap(corners[1], corners[3]);
        const auto [a, b, c, d] = corners;
        const auto& at = mesh_.positions;
        if (glm::distance(at[a], at[c]) <= glm::distance(at[b], at[d])) {
            mesh_.triangles.push_back({a, b, c});
            mesh_.triangles.push_back({a, c, d});
        } else {
            mesh_.triangles.push_back({a, b, d});
            mesh_.triangles.push_back({b, c, d});
        }
    }

    const IsosurfaceOptions& options_;
    const VolumeShape& shape_;
    const std::uint32_t nx_, ny_;
    const std::uint64_t mostTriangles_;
    bool mirrored_;
    std::array<std::vector<float>, 2> slices_;            // below and above a layer of cells
    std::array<std::vector<std::uint8_t>, 2> inside_;     // of their samples
    std::array<std::vector<std::uint32_t>, 2> vertices_;  // of the layer before and this one, by first sample
    float low_ = std::numeric_limits<float>::infinity(), high_ = -low_;
    TriangleMesh mesh_;
};

}  // namespace

Result<TriangleMesh> isosurface(VolumeSource& source, const IsosurfaceOptions& options, Progress& progress) {
    const VolumeShape& shape = source.shape();
    if (std::min({shape.nx, shape.ny, shape.nz}) < 2) {
        return invalid("isovalue", fmt::format("a volume of {} x {} x {} samples has no cells", shape.nx,
                                               shape.ny, shape.nz));
    }
    SurfaceNet net(shape, options);
    for (std::uint32_t z = 0; z < shape.nz; ++z) {
        if (progress.cancelled()) return wasCancelled();
        progress.report(0.5 * z / shape.nz, fmt::format("slice {} of {}", z + 1, shape.nz));
        MOTE_RETURN_IF_ERROR(source.read(z, z + 1, net.next()));
        MOTE_RETURN_IF_ERROR(net.add(z));
    }
    return net.take();
}

}  // namespace mote::prep
