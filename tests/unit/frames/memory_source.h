// SPDX-License-Identifier: GPL-3.0-or-later
//
// MemorySource: runs of particles that lie in memory, for tests of pictures. One owner, one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "protocol/scene/plot_density.h"
#include "server/data/load_points.h"
#include "server/data/step_source.h"
#include "tests/support/memory_run.h"
#include "tests/support/memory_step.h"

namespace mote::server {

class MemorySource final : public StepSource {
  public:
    using Steps = std::vector<std::shared_ptr<const test::MemoryStep>>;

    using Columns = std::vector<std::shared_ptr<const test::MemoryColumns>>;

    /// All of one density scale. `columns`: of each step; empty: it has none.
    void add(const std::string& name, Steps steps, const Columns& columns = {}) {
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
        plot.set_ids(!columns.empty() && columns.front()->hasIds());
        std::vector<test::MemoryRun::Step> all;
        for (std::size_t i = 0; i < columns.size(); ++i) all.push_back({steps[i], columns[i]});
        numbers_[name] = std::make_shared<const test::MemoryRun>(std::move(all), storage::BeamContext{});
        std::erase_if(ways_, [&](const auto& ways) { return std::get<0>(ways.first) == name; });
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
    /// Of two steps the ways between them; of chosen points all; nothing else is there.
    Result<Resident> resident(const AnyLoadable& what) override {
        if (what.type == typeid(ChosenPoints)) return Resident{std::make_shared<const ChosenPoints>(), 0};
        if (what.type != typeid(render::StepWays) || waits) return Resident{};
        if (noRoom) return Error{ErrorCode::resourceExhausted, "dataset", "takes more than there is"};
        const auto second = static_cast<std::uint32_t>(std::stoul(what.key.substr(what.key.find(' '))));
        const auto& ways = ways_[{what.dataset.name, what.step, second}];
        if (ways != nullptr) return Resident{ways, 0};
        MOTE_ASSIGN_OR_RETURN(ways_[std::tuple(what.dataset.name, what.step, second)],
                              render::stepWays(*numbers_.at(what.dataset.name), what.step, second, {}));
        return resident(what);
    }

    bool waits = false, noRoom = false;  ///< for what is loaded

    std::vector<std::pair<std::string, std::uint32_t>> asked;  ///< steps, in this order

  private:
    std::map<std::string, std::pair<storage::Catalogue::Entry, Steps>> runs_;
    std::map<std::string, std::shared_ptr<const test::MemoryRun>> numbers_;
    std::map<std::tuple<std::string, std::uint32_t, std::uint32_t>, std::shared_ptr<const render::StepWays>>
        ways_;
};

}  // namespace mote::server
