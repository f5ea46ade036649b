// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotBounds: the bounds of a plot, of all its steps together: those of the request, else by the rule of
// bounds_rule.h; and what they leave out. Owned by the job, used from its thread.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_reader.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

class PlotBounds {
  public:
    void add(const StepBounds& step);
    /// Errors: notFound, of what "no step has a particle" says; resourceExhausted, with the axis.
    Result<std::array<Range, 3>> find(const proto::ParticlesJob& job, const PlotAxes& axes) const;
    /// A sentence for each axis on which particles were left out that nobody asked to leave out.
    std::vector<std::string> notes(const std::array<Range, 3>& bounds, const PlotAxes& axes) const;

  private:
    std::array<Range, 3> found_;
    std::array<Cut, 3> cuts_;
};

}  // namespace mote::prep
