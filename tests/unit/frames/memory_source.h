// SPDX-License-Identifier: GPL-3.0-or-later
//
// MemorySource: runs of particles that lie in memory, for tests of pictures. One owner, one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/scene/plot_density.h"
#include "server/data/step_source.h"
#include "tests/support/memory_step.h"

namespace mote::server {

class MemorySource final : public StepSource {
  public:
    using Steps = std::vector<std::shared_ptr<const test::MemoryStep>>;

    /// All of one density scale.
    void add(const std::string& name, Steps steps) {
        auto manifest = std::make_shared<proto::Manifest>();
        manifest->set_kind("particles");
        auto& plot = *manifest->mutable_particles();
        for (const char* const axis : {"x", "y", "z"}) {
            auto& added = *plot.add_axes();
            added.set_name(axis);
            added.set_unit("m");
            added.set_min(-1.0);
            added.set_max(1.0);
        }
        plot.set_density_min(steps.front()->logDensity().min);
        plot.set_density_max(steps.front()->logDensity().max);
        for (const auto& step : steps) {
            auto& entry = *plot.add_steps();
            entry.set_particles(step->pointCount());
            entry.set_total_weight(static_cast<double>(step->pointCount()));
            entry.set_time(1e-9 * plot.steps_size());
        }
        runs_[name] = {{name, "/nowhere", std::move(manifest)}, std::move(steps)};
    }
    PlotDensity plot(const std::string& name) const {
        return PlotDensity::of(runs_.at(name).first.manifest->particles());
    }
    const Steps& steps(const std::string& name) const { return runs_.at(name).second; }

    Result<storage::Catalogue::Entry> dataset(const std::string& name) override {
        const auto found = runs_.find(name);
        if (found == runs_.end()) return Error{ErrorCode::notFound, "dataset", name};
        return found->second.first;
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& name,
                                                              std::uint32_t index) override {
        asked.emplace_back(name, index);
        const auto& all = runs_.at(name).second;
        if (index >= all.size()) return Error{ErrorCode::notFound, "step", name};
        return std::shared_ptr<const storage::ParticleStep>(all[index]);
    }
    Result<Resident> resident(const AnyLoadable&) override { return Resident{}; }

    std::vector<std::pair<std::string, std::uint32_t>> asked;  ///< steps, in this order

  private:
    std::map<std::string, std::pair<storage::Catalogue::Entry, Steps>> runs_;
};

}  // namespace mote::server
