// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/step_ways.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/render/layers/particles/point_data.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/id_set.h"
#include "storage/numbers/point_places.h"
#include "storage/numbers/run_steps.h"
#include "storage/numbers/scan.h"

namespace mote::render {
namespace {

/// Tells how fast the points of a step go along those axes of their plot that are places, by their momenta.
class StepSpeeds {
  public:
    /// `seconds`: from the step to another one.
    StepSpeeds(const proto::ParticlesManifest& plot, double seconds);

    bool any() const;
    /// By point: how far it would go meanwhile, in parts of the box; 0 along other axes. Nothing if it was
    /// told to stop.
    std::optional<std::vector<glm::vec3>> of(const storage::StepNumbers& step,
                                             const Cancelled& cancelled) const;

  private:
    glm::vec3 speedOf(const glm::dvec3& momentum) const;

    double mass_;
    std::array<int, 3> momentum_{-1, -1, -1};  // along each axis; below 0: none
    std::array<double, 3> scale_{};
};

/// The momentum along the axes of a plot that are places; empty: along none that says anything.
std::array<std::string, 3> momentaOf(const proto::ParticlesManifest& plot) {
    std::array<std::string, 3> names;
    const auto known = [&](const std::string& name) {
        return std::ranges::any_of(plot.columns(), [&](const auto& column) {
            return column.name() == name && column.unit() == "eV/c";
        });
    };
    const bool all = plot.mass() > 0.0 && known("px") && known("py") && known("pz");
    for (int axis = 0; axis < plot.axes_size() && axis < 3; ++axis) {
        const auto& its = plot.axes(axis);
        const bool place = its.name() == "x" || its.name() == "y" || its.name() == "z";
        if (all && place && its.unit() == "m") names[static_cast<std::size_t>(axis)] = "p" + its.name();
    }
    return names;
}

StepSpeeds::StepSpeeds(const proto::ParticlesManifest& plot, double seconds) : mass_(plot.mass()) {
    constexpr double light = 299792458.0;  // m/s
    const auto names = momentaOf(plot);
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
        if (names[axis].empty() || !std::isfinite(seconds) || seconds == 0.0) continue;
        momentum_[axis] = names[axis][1] - 'x';
        const auto& its = plot.axes(static_cast<int>(axis));
        scale_[axis] = light * seconds / (its.max() - its.min());
    }
}

bool StepSpeeds::any() const {
    return std::ranges::any_of(momentum_, [](int column) { return column >= 0; });
}

std::optional<std::vector<glm::vec3>> StepSpeeds::of(const storage::StepNumbers& step,
                                                     const Cancelled& cancelled) const {
    const std::array<std::string, 3> names{"px", "py", "pz"};
    const auto reader = storage::QuantityReader::make(*step.columns, step.context, names);
    std::vector<glm::vec3> speeds(step.points->pointCount(), glm::vec3(0.0F));
    if (!reader.ok()) return speeds;
    const auto read = [&](std::uint64_t block) {
        const auto part = storage::pointsOfBlock(block, speeds.size());
        std::array<std::vector<double>, 3> momenta;
        std::array<std::span<double>, 3> out;
        for (std::size_t k = 0; k < 3; ++k) {
            momenta[k].resize(part.count);
            out[k] = momenta[k];
        }
        storage::QuantityReader::Scratch scratch;
        reader->read(part.begin, part.count, scratch, out);
        for (std::size_t i = 0; i < part.count; ++i)
            speeds[part.begin + i] = speedOf({momenta[0][i], momenta[1][i], momenta[2][i]});
    };
    const bool whole = storage::forBlocks(storage::blockCount(speeds.size()), cancelled, read);
    return whole ? std::optional(std::move(speeds)) : std::nullopt;
}

/// p / (gamma m), of light's.
glm::vec3 StepSpeeds::speedOf(const glm::dvec3& momentum) const {
    const double energy = std::hypot(mass_, std::hypot(momentum.x, momentum.y, momentum.z));
    glm::vec3 speed(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        if (momentum_[at] >= 0)
            speed[axis] = static_cast<float>(scale_[at] * momentum[momentum_[at]] / energy);
    }
    return speed;
}

using storage::noPoint, storage::StepNumbers;
using Partners = std::vector<std::uint32_t>;  // by point: the point of the other step; noPoint: none

/// Goes through the ids of a step that one point alone has, ascending.
class LoneIds {
  public:
    LoneIds(const storage::ParticleColumns& columns, const std::vector<std::uint64_t>& ids)
        : columns_(columns), ids_(ids) {
        next();
    }

    bool any() const { return begin_ < ids_.size(); }
    std::uint64_t id() const { return ids_[point_]; }
    std::uint32_t point() const { return point_; }
    void next() {
        do {
            begin_ = end_;
            if (!any()) return;
            point_ = end_ == 0 ? columns_.pointOfRank(0) : following_;
            for (++end_; end_ < ids_.size(); ++end_) {
                following_ = columns_.pointOfRank(end_);
                if (ids_[following_] != ids_[point_]) break;
            }
        } while (end_ > begin_ + 1);
    }

  private:
    const storage::ParticleColumns& columns_;
    const std::vector<std::uint64_t>& ids_;  // by point
    std::uint64_t begin_ = 0, end_ = 0;      // ranks of the id
    std::uint32_t point_ = 0, following_ = 0;
};

/// By point; nothing if it was told to stop.
std::optional<std::vector<std::uint64_t>> idsOf(const storage::ParticleColumns& columns,
                                                const Cancelled& cancelled) {
    std::vector<std::uint64_t> ids(columns.pointCount());
    const bool whole =
        storage::forBlocks(storage::blockCount(ids.size()), cancelled, [&](std::uint64_t block) {
            const auto part = storage::pointsOfBlock(block, ids.size());
            std::ranges::copy(columns.ids(part.begin, part.count),
                              ids.begin() + static_cast<std::ptrdiff_t>(part.begin));
        });
    return whole ? std::optional(std::move(ids)) : std::nullopt;
}

/// Of the points of the first step, and how many have any.
std::optional<std::pair<Partners, std::uint64_t>> partnersOf(const StepNumbers& first,
                                                             const StepNumbers& second,
                                                             const Cancelled& cancelled) {
    const auto ids = idsOf(*first.columns, cancelled), others = idsOf(*second.columns, cancelled);
    if (!ids || !others) return std::nullopt;
    std::pair<Partners, std::uint64_t> found(Partners(ids->size(), noPoint), 0);
    LoneIds here(*first.columns, *ids), there(*second.columns, *others);
    for (std::uint64_t i = 0; here.any() && there.any(); ++i) {
        if (i % storage::blockPoints == 0 && cancelled && cancelled()) return std::nullopt;
        if (here.id() == there.id()) {
            found.first[here.point()] = there.point();
            ++found.second;
        }
        const bool ahead = there.id() < here.id(), both = here.id() == there.id();
        if (ahead || both) there.next();
        if (!ahead) here.next();
    }
    return found;
}

/// Calls take(point, place in the plot's box) for all points of a step, on all threads.
template <class Take>
bool forPlaces(const storage::ParticleStep& step, const Cancelled& cancelled, const Take& take) {
    constexpr std::uint64_t blockLeaves = 256;
    const storage::LeafWalk walk(step);
    const std::uint64_t leaves = walk.leaves().size();
    return storage::forBlocks((leaves + blockLeaves - 1) / blockLeaves, cancelled, [&](std::uint64_t block) {
        for (auto leaf = block * blockLeaves; leaf < std::min(leaves, (block + 1) * blockLeaves); ++leaf) {
            const auto cell = walk.cell(leaf);
            auto point = walk.leaves().pointBegin[leaf];
            for (const auto& p : step.positions(point, walk.leaves().pointCount[leaf]))
                take(point++, glm::vec3(0.5 * (cell.at(p) + 1.0)));
        }
    });
}

constexpr float staysAt = std::numeric_limits<float>::quiet_NaN();

/// What the momenta of both steps say of one axis.
struct Bending {
    float begin = 0.0F, end = 0.0F;  ///< tangents beyond the straight way
    float missed = 0.0F;             ///< that the mean of both speeds is off the way
    float longest = 0.0F;            ///< of the way and both tangents

    static Bending of(float way, float speed, float later) {
        return {speed - way, later - way, way - 0.5F * (speed + later),
                std::max({std::abs(way), std::abs(speed), std::abs(later)})};
    }
    /// Whether the curve is one that a particle goes, and does not swing far beyond both ends.
    bool calm() const { return missed >= -0.5F * longest && missed <= 0.5F * longest; }
};

class WayMaker {
  public:
    WayMaker(const proto::ParticlesManifest& plot, const StepNumbers& first, const StepNumbers& second,
             Partners partners, std::uint64_t moving, const Cancelled& cancelled)
        : plot_(plot), first_(first), second_(second), partners_(std::move(partners)), cancelled_(cancelled) {
        out_->moving = moving;
    }

    /// Null if it was told to stop.
    std::shared_ptr<const StepWays> make(double seconds) {
        if (!findEnds()) return nullptr;
        leaveJumps();
        const StepSpeeds speeds(plot_, seconds);
        if (out_->moving > 0 && speeds.any() && !bend(speeds)) return nullptr;
        swing();
        return out_;
    }

  private:
    bool findEnds() {
        std::vector<glm::vec3> places;
        const auto read = [&](const storage::ParticleStep& step) {
            places.resize(step.pointCount());
            return forPlaces(step, cancelled_,
                             [&](std::uint64_t point, const auto& place) { places[point] = place; });
        };
        auto &there = out_->there.ends, &back = out_->back.ends;
        back.assign(second_.points->pointCount(), glm::vec3(staysAt));
        if (!read(*first_.points)) return false;
        for (std::size_t point = 0; point < partners_.size(); ++point)
            if (partners_[point] != noPoint) back[partners_[point]] = places[point];
        there.assign(partners_.size(), glm::vec3(staysAt));
        if (!read(*second_.points)) return false;
        for (std::size_t point = 0; point < partners_.size(); ++point)
            if (partners_[point] != noPoint) there[point] = places[partners_[point]];
        return true;
    }

    /// What goes around an angle's end is not seen to cross the plot.
    void leaveJumps() {
        glm::vec3 most(std::numeric_limits<float>::infinity());
        for (int axis = 0; axis < plot_.axes_size() && axis < 3; ++axis) {
            const auto& its = plot_.axes(axis);
            if (its.unit() == "rad")
                most[axis] = static_cast<float>(std::numbers::pi / (its.max() - its.min()));
        }
        for (std::size_t point = 0; point < partners_.size(); ++point) {
            if (partners_[point] == noPoint) continue;
            auto &end = out_->there.ends[point], &begin = out_->back.ends[partners_[point]];
            const glm::vec3 way = end - begin;
            const auto far = [&](int axis) { return std::abs(way[axis]) > most[axis]; };
            if (!far(0) && !far(1) && !far(2)) continue;
            begin = end = glm::vec3(staysAt);
            partners_[point] = noPoint;
            --out_->moving;
        }
    }

    bool bend(const StepSpeeds& speeds) {
        const auto before = speeds.of(first_, cancelled_), after = speeds.of(second_, cancelled_);
        if (!before || !after) return false;
        const auto forMoving = [&](const auto& take) {
            for (std::size_t point = 0; point < partners_.size(); ++point) {
                const auto other = partners_[point];
                if (other == noPoint) continue;
                const glm::vec3 way = out_->there.ends[point] - out_->back.ends[other];
                for (int axis = 0; axis < 3; ++axis)
                    take(point, axis, Bending::of(way[axis], (*before)[point][axis], (*after)[other][axis]));
            }
        };
        // Along which axes the momenta tell the way: all in all they are off by less than a quarter of it.
        constexpr double most = 1.0 / 16.0;
        glm::dvec3 missed(0.0), longest(0.0);
        forMoving([&](std::size_t, int axis, const Bending& bending) {
            if (!std::isfinite(bending.missed)) return;
            missed[axis] += double{bending.missed} * bending.missed;
            longest[axis] += double{bending.longest} * bending.longest;
        });
        const auto tells = [&](int axis) { return missed[axis] < most * longest[axis]; };
        const auto told = [&](int axis, const Bending& bending) { return tells(axis) && bending.calm(); };
        float greatest = 0.0F;
        forMoving([&](std::size_t, int axis, const Bending& bending) {
            if (told(axis, bending))
                greatest = std::max({greatest, std::abs(bending.begin), std::abs(bending.end)});
        });
        if (!(greatest > 0.0F)) return true;
        begin(greatest);
        for (int axis = 0; axis < 3; ++axis) bent_[static_cast<std::size_t>(axis)] = tells(axis);
        forMoving([&](std::size_t point, int axis, const Bending& bending) {
            if (told(axis, bending)) put(point, static_cast<std::size_t>(axis), bending);
        });
        return true;
    }

    void begin(float greatest) {
        out_->there.unit = out_->back.unit = greatest / 32767.0F;
        out_->there.bends.resize(out_->there.ends.size());
        out_->back.bends.resize(out_->back.ends.size());
    }

    /// The way back has its tangents the other way round.
    void put(std::size_t point, std::size_t axis, const Bending& bending) {
        const auto parts = [&](float value) {
            return static_cast<std::int16_t>(std::lround(value / out_->there.unit));
        };
        const auto first = parts(bending.begin), last = parts(bending.end);
        auto& there = out_->there.bends[point];
        auto& back = out_->back.bends[partners_[point]];
        there[axis] = first;
        there[axis + 3] = last;
        back[axis] = static_cast<std::int16_t>(-last);
        back[axis + 3] = static_cast<std::int16_t>(-first);
    }

    /// If momenta do not tell the way: of so many particles that their means tell how all of them go.
    void swing() {
        constexpr std::uint64_t few = 1000;
        constexpr double farthest = -0.5;  // correlation: 120 degrees
        if (out_->moving < few) return;
        for (int axis = 0; axis < 3; ++axis) {
            if (bent_[static_cast<std::size_t>(axis)]) continue;
            const auto moments = momentsOf(axis);
            const double both = moments.spread * moments.endSpread;
            const double alike = both > 0.0 ? moments.product / both : 1.0;
            if (alike < farthest) return stay();
            const double angle = std::acos(std::min(alike, 1.0));
            if (angle < 1e-3) continue;
            out_->there.swings[static_cast<std::size_t>(axis)] = {angle, moments.mean, moments.spread,
                                                                  moments.endMean, moments.endSpread};
            out_->back.swings[static_cast<std::size_t>(axis)] = {angle, moments.endMean, moments.endSpread,
                                                                 moments.mean, moments.spread};
        }
    }

    void stay() {
        out_->swung = true;
        out_->moving = 0;
        out_->there = out_->back = {};
    }

    struct Moments {
        double mean = 0.0, spread = 0.0, endMean = 0.0, endSpread = 0.0, product = 0.0;
    };
    Moments momentsOf(int axis) const {
        Moments moments;
        const auto forMoving = [&](const auto& take) {
            for (std::size_t point = 0; point < partners_.size(); ++point) {
                if (partners_[point] == noPoint) continue;
                take(static_cast<double>(out_->back.ends[partners_[point]][axis]),
                     static_cast<double>(out_->there.ends[point][axis]));
            }
        };
        const auto count = static_cast<double>(out_->moving);
        forMoving([&](double begin, double end) {
            moments.mean += begin / count;
            moments.endMean += end / count;
        });
        forMoving([&](double begin, double end) {
            const double from = begin - moments.mean, to = end - moments.endMean;
            moments.spread += from * from / count;
            moments.endSpread += to * to / count;
            moments.product += from * to / count;
        });
        moments.spread = std::sqrt(moments.spread);
        moments.endSpread = std::sqrt(moments.endSpread);
        return moments;
    }

    const proto::ParticlesManifest& plot_;
    const StepNumbers &first_, &second_;
    Partners partners_;
    const Cancelled& cancelled_;
    std::array<bool, 3> bent_{};  // by axis
    std::shared_ptr<StepWays> out_ = std::make_shared<StepWays>();
};

}  // namespace

std::uint64_t StepWays::bytes() const {
    const auto of = [](const PointWays& ways) {
        return ways.ends.capacity() * sizeof(glm::vec3) + ways.bends.capacity() * sizeof(PointWays::Bend);
    };
    return of(there) + of(back);
}

Result<std::shared_ptr<const StepWays>> stepWays(const storage::RunSteps& run, std::uint32_t first,
                                                 std::uint32_t second, const Cancelled& cancelled) {
    MOTE_ASSIGN_OR_RETURN(const auto one, run.step(first));
    MOTE_ASSIGN_OR_RETURN(const auto other, run.step(second));
    for (const auto* const step : {&one, &other}) {
        if (!step->columns || !step->columns->hasIds()) return storage::withoutIds("towards");
    }
    auto partners = partnersOf(one, other, cancelled);
    if (!partners) return wasCancelled();
    const auto& plot = run.manifest();
    const auto timeOf = [&](std::uint32_t step) { return plot.steps(static_cast<int>(step)).time(); };
    auto ways = WayMaker(plot, one, other, std::move(partners->first), partners->second, cancelled)
                    .make(timeOf(second) - timeOf(first));
    if (ways == nullptr) return wasCancelled();
    for (const auto* const step : {&one, &other}) {
        step->columns->check();
        step->points->check();
    }
    return ways;
}

}  // namespace mote::render
