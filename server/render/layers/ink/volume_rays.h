// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumeRays: what rays through places of a picture see of a scalar field, as a drawing is made from it
// (docs/INK.md, "Volumes and particles"). Made for a view; refers to the field. Any number of threads may
// ask, each with scratch of its own.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "protocol/scene/bounds.h"
#include "protocol/scene/light.h"
#include "server/render/layers/ink/depth_spans.h"
#include "server/render/layers/ink/extinction_table.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/plan/field_blocks.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/grid/volume_samples.h"

namespace mote::render {

/// What a ray sees; means are weighted by what of the ray's light is absorbed in each place.
struct VolumeSeenOn {
    double opacity = 0.0;    ///< of all that it meets
    double depth = 0.0;      ///< where half of that is met, world units; where the opacity is above 0
    double light = 0.0;      ///< of a white matter: at most the opacity
    glm::dvec3 normal{0.0};  ///< the sum of normals towards the eye, eye space
};

class VolumeRays {
  public:
    /// Where a ray has been absorbed so far.
    struct Mark {
        double depth, absorbed;
    };
    /// A part of a ray that has one normal.
    struct Part {
        double step, absorbed;
    };
    /// What one thread's rays are followed with.
    struct Scratch {
        std::vector<Mark> marks;
        std::vector<Part> parts;
    };

    /// `plan`: its size and its camera are told, and whether it is exact. Works in parallel.
    VolumeRays(const InkVolume& volume, const glm::dmat4& transform, const Light& light,
               const FramePlan& plan);

    /// Whether any value that there is can be seen.
    bool any() const { return blocks_.any(); }
    /// What lies around all that can be seen, layer space; nothing else if there is any.
    Bounds visible() const;
    /// Finds where in the picture, and between which depths, anything can be seen: from then on rays are
    /// followed only there, and see the same. Pays if there are many. Works in parallel.
    void findSpans();
    /// Through (x, y) of the picture, in pixels from its upper left corner. Nothing where less than `least`
    /// of the ray is absorbed.
    VolumeSeenOn look(double x, double y, double least, Scratch& scratch) const;
    /// Of the ray that was looked along last: which share of its light is absorbed before a depth; the depth
    /// at which a share is, at most the one of all that is absorbed.
    static double absorbedBefore(const Scratch& scratch, double depth);
    static double depthWhere(const Scratch& scratch, double absorbed);
    /// Of what lies at a depth behind (x, y) of the picture: the place in the field's box [0, 1]^3; the code.
    glm::dvec3 boxPlace(double x, double y, double depth) const;
    double codeAt(double x, double y, double depth) const;

  private:
    struct Way;
    class BlockWalk;
    struct Stretch;
    struct Run;
    struct Samples;
    struct Sight;

    VolumeRays(const InkVolume& volume, const BlockRanges& ranges, const glm::dmat4& transform,
               const Light& light, const FramePlan& plan);
    double longestStep() const;  ///< layer space, at least
    bool isCounted(std::size_t block) const { return most_[block] > leastExtinction_; }
    /// What lies around a block's places, in cells: they end half a cell behind the next one's corner.
    Bounds cellsOf(const glm::uvec3& block) const;
    Way wayThrough(double x, double y) const;
    /// Whether the optical depth of a whole way may exceed `thickness`. `walk`, at its begin, goes on to the
    /// first block in which a step may be counted.
    bool mayAbsorb(const Way& way, double thickness, BlockWalk& walk) const;
    /// Finds what lies at the steps of a way from `first` to `last`, as many as go together.
    void sample(const Way& way, double first, double last, Samples& found) const;
    /// Follows some steps of a way, and gives them up.
    void march(const Way& way, Run& run, Sight& sight) const;
    /// Gathers what a stretch of a way shows, between two places in the table.
    void meet(const Way& way, const Stretch& stretch, double from, double to, Sight& sight) const;
    /// Adds the light of all parts, and their normals.
    void shade(const Way& way, const std::vector<Part>& parts, VolumeSeenOn& seen) const;
    void shade(const glm::vec3& slope, double absorbed, VolumeSeenOn& seen) const;

    const GridField& field_;
    VolumeSamples samples_;
    TransferTable table_;
    ExtinctionTable extinction_;
    VisibleBlocks blocks_;     // where anything can be seen
    std::vector<float> most_;  // extinction in each block, per unit length of layer space
    glm::dmat4 cellsToEye_, eyeToCells_;
    glm::dmat3 cellsToLayer_;   // ways
    glm::dmat3 slopeToNormal_;  // slopes of codes in cells to normals in eye space, outward of what is dense
    Light light_;
    glm::dvec3 towards_, half_;  // the light, and half way from it to the eye; eye space, unit
    bool perspective_;
    HalfSpaces clips_;       // in cells
    double nearest_;         // depth
    glm::dvec2 size_;        // of the picture, pixels
    double pixels_;          // a unit of the window
    double stepLength_;      // cells
    float leastExtinction_;  // of a block in which a step of a ray may be counted
    std::optional<DepthSpans> spans_;
};

}  // namespace mote::render
