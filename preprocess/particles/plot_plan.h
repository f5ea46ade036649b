// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a request for a plot comes to: the memory for each step, and what the manifest says before any step is
// built. Pure functions, but for the machine's size and the names of the file system.
//
// PlotBounds: the bounds of a plot: those of the request, else by the rule of bounds_rule.h, of all its steps
// together or of each; and what they leave out. Owned by the job, used from its thread.
//
// What a particles job knows only when all of its steps are written: histograms of densities on the scale of
// all steps, and how many particles were left out. Functions without state.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_builder.h"
#include "preprocess/particles/step_reader.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

/// Whether a request's bounds of an axis are those of each step, as requests said before bounds_of.
inline bool isOfSteps(const proto::Axis& bounds) {
    return bounds.unit() == "step";
}

class PlotBounds {
  public:
    /// Takes the bounds of the next step.
    void add(const StepBounds& step) { steps_.push_back(step); }
    /// The search goes on for further steps of a plot: what its axes span widens.
    void goOn(const proto::ParticlesManifest& plot);
    /// Ends the search, with that many steps. Errors: notFound, of what "no step has a particle" says;
    /// resourceExhausted, with the axis.
    Status find(const proto::ParticlesJob& job, const PlotAxes& axes, std::size_t steps);

    const std::array<Range, 3>& all() const { return all_; }  ///< of all steps together
    bool ofSteps() const { return ofSteps_; }                 ///< some axis has each step's own
    const std::array<Range, 3>& of(std::size_t step) const { return bounds_[step]; }

    /// A sentence for each axis on which particles were left out that nobody asked to leave out, and for each
    /// along which the beam travels so far that it is small in the plot.
    std::vector<std::string> notes(const PlotAxes& axes) const;

  private:
    /// How many times wider the bounds of an axis are than what the widest step spans; 0 where they were
    /// not found in these steps.
    double travel(std::size_t axis) const;

    std::vector<StepBounds> steps_;
    std::array<Range, 3> before_;  ///< of the steps before; empty: there are none
    std::array<Range, 3> all_;
    std::array<bool, 3> common_{};              ///< found, of all steps together
    std::vector<std::array<Range, 3>> bounds_;  ///< by step
    bool ofSteps_ = false;
};

/// How the steps of a job are built, by what it says and the schema's defaults.
StepOptions stepOptionsOf(const proto::ParticlesJob& job);

struct MemoryPlan {
    std::uint64_t needed = 0;     ///< bytes without which the step cannot be built
    std::uint64_t particles = 0;  ///< bytes left for particles in memory
    std::uint64_t kept = 0;       ///< bytes left for what was read and will be needed again
};

/// The plan for a step of so many particles; `limit` is this process', 0 for three quarters of the machine's
/// memory. Figures measured: docs/JOBS.md.
MemoryPlan planMemory(std::uint64_t particles, const StepOptions& options, std::uint64_t limit, int threads);

struct PlotRequest {
    const proto::JobRequest& request;
    const std::vector<std::filesystem::path>& inputs;
    const std::filesystem::path& output;
};

/// Adds the three axes with these bounds.
void addAxes(const PlotAxes& axes, const std::array<Range, 3>& ranges,
             google::protobuf::RepeatedPtrField<proto::Axis>& to);
proto::Manifest describePlot(const PlotRequest& asked, const PlotAxes& axes, const PlotBounds& bounds,
                             const StepOptions& options);

/// The particles of leaves [begin, end) by the scaled log density of their leaf, from the file of a step.
/// Errors: internal, cancelled.
Result<std::vector<std::uint64_t>> densityHistogram(const storage::StepFile& file, std::uint64_t begin,
                                                    std::uint64_t end, const Range& densities,
                                                    const Progress& progress);

/// Says what the steps leave out; `others`: particles that are not lost, of a plot of those that are.
std::vector<std::string> leftOutNotes(const proto::ParticlesManifest& particles, bool boundsGiven,
                                      std::uint64_t others);
/// Whether it is one of these sentences.
bool isLeftOutNote(std::string_view sentence);

}  // namespace mote::prep
