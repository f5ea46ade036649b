// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeField: the continuous volume of one layer (docs/PICTURE.md, "Volume"): extinction and colour anywhere
// in layer space, and how much of each leaf lies in it. A value; safe on any number of threads.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/particles_style.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/point_values.h"
#include "storage/particles/particle_step.h"
#include "tests/reference/volume.h"

namespace mote::reference {

class VolumeField final : public Volume {
  public:
    /// `values` and `map`: of all points of the step, and their colours, which it then has; or null.
    VolumeField(const storage::ParticleStep& step, const ParticlesStyle& style,
                const render::PointValues* values = nullptr, const ColorMap* map = nullptr);

    /// Extinction per unit length of layer space: its cube root is trilinear between the cells' centres; the
    /// nearest value beyond the outermost ones, and nothing where there are no cells.
    double extinction(const glm::dvec3& inLayer) const { return std::pow(between(root_, inLayer), 3.0); }
    /// Whether there are no cells.
    bool empty() const { return t_.empty(); }
    /// Scaled log density, trilinear; or the mean of values, as a share of their range.
    double t(const glm::dvec3& inLayer) const { return between(t_, inLayer); }
    /// How much lies in the volume of what the curve gives it of a leaf, 0 to 1.
    double share(std::size_t leaf) const { return shares_.empty() ? 1.0 : shares_[leaf]; }
    /// How much of the extinction in a cell and the 26 around it lies in the volume, trilinear.
    double held(const glm::dvec3& inLayer) const { return between(held_, inLayer); }
    /// Linear RGB.
    glm::dvec3 color(double t) const { return transfer_.color(t); }
    VolumeMatter at(const glm::dvec3& inLayer) const override;
    std::vector<HalfSpace> within() const override;
    double cellEdge() const override { return edge_; }

  private:
    struct Leaf {
        std::size_t number;
        int level;
        std::array<std::int64_t, 3> place;  ///< among the cells of its level
        double density, t, extinction;      ///< t: its place in the colour map; NaN: it has none
        double points;                      ///< how much of it is points
        double evenness;                    ///< of its points in its cell, 0 to 1
        double middle;                      ///< of its first points, from its cell's centre, cells squared
        std::uint64_t pointsSeen;           ///< so many
    };

    class ThickCells;

    void findShares(const std::vector<Leaf>& leaves, const std::vector<Leaf>& all);
    static std::array<std::int64_t, 3> cellOf(const Leaf& leaf, int level);
    std::vector<Leaf> leavesOf(const storage::ParticleStep& step, const Curve& fraction,
                               const render::PointValues* values) const;
    bool choose(const std::vector<Leaf>& leaves, int level, double most);
    /// `leaves`: those that are seen.
    void fill(const std::vector<Leaf>& leaves, const std::vector<Leaf>& all);
    std::size_t index(std::int64_t x, std::int64_t y, std::int64_t z) const;
    std::vector<double> rootsOf(const std::vector<double>& extinction) const;
    double between(const std::vector<double>& cells, const glm::dvec3& inLayer) const;

    TransferFunction transfer_;
    double edge_ = 2.0;  // of a cell, layer units
    int level_ = 0;
    std::array<std::int64_t, 3> first_{}, size_{};  // cells of that level
    std::vector<double> root_, t_, held_;           // of each, x fastest
    std::vector<double> shares_;                    // by leaf
};

/// Of a layer of particles of a scene.
VolumeField volumeOf(const render::Scene& scene, std::size_t layer, const ParticlesStyle& style);

}  // namespace mote::reference
