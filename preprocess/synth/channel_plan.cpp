// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/channel_plan.h"

#include <algorithm>
#include <cmath>

namespace mote::prep {
namespace {

/// How many equal slices the channel has for so many dumps.
std::uint64_t sliceCount(std::uint32_t steps) {
    constexpr std::uint64_t coarse = std::uint64_t{channelPeriods} * slicesPerPeriod;
    return coarse * std::max<std::uint64_t>(1, (std::uint64_t{steps} + coarse - 2) / coarse);
}

/// Slices before each dump.
std::vector<std::uint64_t> dumpSlices(std::uint32_t steps, std::uint64_t slices) {
    if (steps == 1) return {slices};
    std::vector<std::uint64_t> result;
    for (std::uint64_t i = 0; i < steps; ++i) result.push_back(i * slices / (steps - 1));
    return result;
}

ChannelMap then(const ChannelMap& earlier, const ChannelMap& later) {
    ChannelMap result{};
    for (std::size_t plane = 0; plane < 3; ++plane) result[plane] = later[plane].after(earlier[plane]);
    return result;
}

bool finite(const Envelope& core) {
    return std::all_of(core.axes.begin(), core.axes.end(),
                       [](double a) { return std::isfinite(a) && a > 0.0 && a < 1.0; });
}

/// Walks the core from slice to slice, and turns every slice into half a map, a kick and half a map.
class Planner {
  public:
    Planner(const EnvelopeModel& model, const Envelope& core, double slice)
        : model_(model), core_(core), slice_(slice) {}

    bool reach(PlanDump& dump) {
        ChannelMap pending{};  // the second half of the slice before, merged with the first of the next
        for (; done_ < dump.slice; ++done_) {
            const double begin = static_cast<double>(done_) * slice_;
            const double middle = begin + 0.5 * slice_, end = static_cast<double>(done_ + 1) * slice_;
            core_ = model_.advance(core_, begin, middle, EnvelopeModel::defaultStep);
            if (!finite(core_)) return false;
            const auto [least, most] = std::minmax_element(core_.axes.begin(), core_.axes.end());
            flattest_ = std::max(flattest_, *most / *least);
            const ChannelMap map = then(pending, model_.channel().map(begin, middle));
            dump.stages.push_back({map, coreKick(core_.axes, model_.perveance() * slice_)});
            pending = model_.channel().map(middle, end);
            core_ = model_.advance(core_, middle, end, EnvelopeModel::defaultStep);
        }
        dump.last = pending;
        dump.place = static_cast<double>(dump.slice) * slice_;
        dump.core = core_;
        return finite(core_);
    }

    double flattest() const { return flattest_; }

  private:
    const EnvelopeModel& model_;
    Envelope core_;
    double slice_;
    std::uint64_t done_ = 0;
    double flattest_ = 1.0;
};

}  // namespace

Result<ChannelPlan> planChannel(const BeamDesign& design, std::uint32_t steps) {
    const EnvelopeModel model(design);
    MOTE_ASSIGN_OR_RETURN(const auto matched, model.matched());

    ChannelPlan plan;
    plan.design = design;
    plan.beam = kinematics(design);
    plan.emittance = model.emittance();
    plan.slices = sliceCount(steps);
    plan.sliceLength = model.channel().periodLength() * channelPeriods / static_cast<double>(plan.slices);
    plan.matched = matched;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        plan.zeroCurrentAdvance[plane] = model.channel().phaseAdvance(plane);
    }
    plan.depressedAdvance = model.depressedAdvance(matched);

    Envelope core = matched;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        core.axes[plane] *= design.mismatch[plane];
        core.slopes[plane] *= design.mismatch[plane];
    }
    Planner planner(model, core, plan.sliceLength);
    for (const std::uint64_t slice : dumpSlices(steps, plan.slices)) {
        PlanDump& dump = plan.dumps.emplace_back();
        dump.slice = slice;
        if (!planner.reach(dump)) {
            return invalid("mismatch", "the core of the beam does not stay together");
        }
    }
    plan.flattest = planner.flattest();
    return plan;
}

}  // namespace mote::prep
