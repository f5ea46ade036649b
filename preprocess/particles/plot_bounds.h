// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotBounds: the bounds of a plot: those of the request, else by the rule of bounds_rule.h, of all its steps
// together or of each; and what they leave out. Owned by the job, used from its thread.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_reader.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Whether a request's bounds of an axis are those of each step: its unit says "step".
inline bool isOfSteps(const proto::Axis& bounds) {
    return bounds.unit() == "step";
}

class PlotBounds {
  public:
    /// Of the next step.
    void add(const StepBounds& step) { steps_.push_back(step); }
    /// Ends the search, with that many steps. Errors: notFound, of what "no step has a particle" says;
    /// resourceExhausted, with the axis.
    Status find(const proto::ParticlesJob& job, const PlotAxes& axes, std::size_t steps);

    const std::array<Range, 3>& all() const { return all_; }  ///< of all steps together
    bool ofSteps() const { return ofSteps_; }                 ///< some axis has each step's own
    std::size_t steps() const { return bounds_.size(); }
    const std::array<Range, 3>& of(std::size_t step) const { return bounds_[step]; }

    /// A sentence for each axis on which particles were left out that nobody asked to leave out.
    std::vector<std::string> notes(const PlotAxes& axes) const;

  private:
    std::vector<StepBounds> steps_;
    std::array<Range, 3> all_;
    std::vector<std::array<Range, 3>> bounds_;  ///< by step
    bool ofSteps_ = false;
};

}  // namespace mote::prep
