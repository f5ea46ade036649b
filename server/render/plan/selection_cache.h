// SPDX-License-Identifier: GPL-3.0-or-later
//
// A SelectionCache keeps the latest volumes and point selections, so that a camera that moves around the
// same particles computes them once. Owned by whoever makes plans; one thread. It holds no step alive.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <vector>

#include "protocol/scene/transfer_function.h"
#include "server/render/plan/moved_points.h"
#include "server/render/plan/point_selection.h"
#include "server/render/plan/point_values.h"

namespace mote::render {

class SelectionCache {
  public:
    using Step = std::shared_ptr<const storage::ParticleStep>;

    /// Throws as selectPoints.
    std::shared_ptr<const PointSelection> of(const Step& step, const PointChoice& choice);
    /// The volume of a step that a transfer function shows among such a share of points; null where it shows
    /// nothing. `rough`: without the octree. `values`: by leaf, that colour it; null: none. Throws as
    /// stepVolume.
    std::shared_ptr<const StepVolume> volume(const Step& step, const TransferFunction& transfer,
                                             const Curve& fraction, bool rough = false,
                                             const std::shared_ptr<const PointValues>& values = nullptr);
    /// The points that may be drawn of any share. Throws as neededPoints.
    std::vector<storage::PointRange> needed(const Step& step, const PointChoice& choice);
    /// What the points of a step weigh; `rough`: without the octree. Throws as stepWeight.
    StepWeight weight(const Step& step, double meanWeight, bool rough);
    /// The means of a step's values by leaf (leaf_means.h). Throws as leafMeans.
    std::shared_ptr<const PointValues> leafMeans(const Step& step,
                                                 const std::shared_ptr<const PointValues>& values);
    /// What of a step is selected, on its way; `values`: null, or of the step. Throws as movePoints.
    MovedPoints moved(const Step& step, const std::shared_ptr<const PointSelection>& selection,
                      const std::shared_ptr<const PointWays>& ways, double share,
                      const std::shared_ptr<const PointValues>& values);
    /// What clips leave of that. Throws as cutPoints.
    MovedPoints cut(const Step& step, const std::shared_ptr<const PointSelection>& selection,
                    const HalfSpaces& clips, const std::shared_ptr<const PointValues>& values);

  private:
    static constexpr std::size_t kept = 4;  // quick, intermediate and exact of one style, and one more
    static constexpr std::size_t keptVolumes = 8;
    static constexpr std::size_t keptMoved = 4;                         // of both steps, moved and cut
    static constexpr std::uint64_t mostMoved = std::uint64_t{1} << 21;  // of more, none are kept

    struct Entry {
        std::weak_ptr<const storage::ParticleStep> step;
        PointChoice choice;
        std::shared_ptr<const PointSelection> selection;
    };
    struct Volume {
        std::weak_ptr<const storage::ParticleStep> step;
        Curve opacity, fraction;
        bool rough;
        std::shared_ptr<const PointValues> values;
        std::shared_ptr<const StepVolume> grid;
    };
    struct Weight {
        std::weak_ptr<const storage::ParticleStep> step;
        double meanWeight;
        bool rough;
        StepWeight weight;
    };
    struct Needed {
        std::weak_ptr<const storage::ParticleStep> step;
        Curve fraction;
        std::shared_ptr<const StepVolume> volume;
        std::vector<storage::PointRange> ranges;
    };
    struct Means {
        std::weak_ptr<const storage::ParticleStep> step;
        std::weak_ptr<const PointValues> of;
        std::shared_ptr<const PointValues> means;
    };
    struct Moved {
        std::weak_ptr<const PointSelection> selection;
        std::weak_ptr<const PointWays> ways;  // of what is moved
        double share;                         // likewise
        HalfSpaces clips;                     // of what is cut
        std::weak_ptr<const PointValues> values;
        MovedPoints points;
    };
    std::list<Entry> entries_;   // the latest first
    std::list<Volume> volumes_;  // likewise
    std::list<Means> means_;     // likewise
    std::list<Weight> weights_;  // likewise
    std::list<Needed> needed_;   // likewise
    std::list<Moved> moved_;     // likewise

    template <class Make>
    MovedPoints moved(Moved wanted, const Make& make);
};

}  // namespace mote::render
