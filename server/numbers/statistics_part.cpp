// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "protocol/scene/column_name.h"
#include "server/numbers/coarse_notes.h"
#include "server/numbers/query_parts.h"
#include "storage/beam/neutral_species.h"
#include "storage/numbers/point_statistics.h"

namespace mote::server {
namespace {

/// Of statistics while they are summed, a point: moments of blocks, and what lies near a percentile's cut.
constexpr std::uint64_t statisticsShare = 4;

class StatisticsPart final : public QueryPart {
  public:
    StatisticsPart(std::vector<std::string> names, std::optional<storage::SlicesWanted> slices)
        : names_(std::move(names)), slices_(std::move(slices)) {}

    Status answer(const StepQuestion& question, QueryAnswer& answer) override {
        const auto& manifest = question.manifest();
        if (question.everything() && !slices_ && manifest.statistic_names_size() > 0)
            return ofManifest(question, answer);
        MOTE_ASSIGN_OR_RETURN(const auto numbers, question.numbers());
        MOTE_ASSIGN_OR_RETURN(const auto chosen, question.chosen());
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(numbers.columns->pointCount() / statisticsShare));
        storage::BeamFacts facts;
        facts.mass = manifest.mass();
        facts.particleCharge = manifest.particle_charge();
        facts.neutral = storage::isNeutral(manifest.species());
        facts.weightUnit = manifest.weight_unit();
        facts.lost = question.everything() ? question.entry().lost() : 0;
        facts.meanMomentum = numbers.context.meanMomentum;
        MOTE_ASSIGN_OR_RETURN(
            const auto found,
            storage::pointStatistics(numbers, facts, chosen.get(), slices_, passes(), question.cancelled()));
        answer.memory.shrink(0);
        for (auto& note : notesOfStatistics(*numbers.columns, found, names_))
            answer.message.add_notes(std::move(note));
        auto& message = *answer.message.mutable_statistics();
        MOTE_RETURN_IF_ERROR(fill(found, message));
        return success();
    }

  private:
    /// What is asked for of all that there is.
    Result<std::vector<std::size_t>> places() const {
        std::vector<std::size_t> places;
        for (std::size_t i = 0; i < names_.size(); ++i) {
            const auto place = storage::findBeamStatistic(names_[i]);
            if (!place) return unknown(i);
            places.push_back(*place);
        }
        if (!names_.empty()) return places;
        for (std::size_t i = 0; i < storage::beamStatistics().size(); ++i) places.push_back(i);
        return places;
    }

    storage::Passes passes() const {
        const auto isPercentile = [](const std::string& name) { return name.find("_action_") != name.npos; };
        return names_.empty() || std::ranges::any_of(names_, isPercentile) ? storage::Passes::percentilesToo
                                                                           : storage::Passes::momentsAlone;
    }

    Error unknown(std::size_t name) const {
        return {ErrorCode::notFound, fmt::format("names[{}]", name),
                fmt::format("there is no statistic \"{}\"; docs/NUMBERS.md lists them",
                            names_[name].substr(0, 64))};
    }

    Status fill(const storage::PointStatistics& found, proto::Statistics& message) const {
        MOTE_ASSIGN_OR_RETURN(const auto places, this->places());
        for (std::size_t i = 0; i < places.size(); ++i) {
            message.add_names(names_.empty() ? storage::beamStatistics()[places[i]].name : names_[i]);
            message.add_values(found.values[places[i]]);
        }
        message.mutable_slice_edges()->Add(found.edges.begin(), found.edges.end());
        for (const auto& slice : found.slices) {
            auto& values = *message.add_slices();
            for (const auto place : places) values.add_values(slice[place]);
        }
        return success();
    }

    /// As preparation found them, from the source's own values.
    Status ofManifest(const StepQuestion& question, QueryAnswer& answer) const {
        const auto& known = question.manifest().statistic_names();
        auto& message = *answer.message.mutable_statistics();
        if (names_.empty()) {
            *message.mutable_names() = known;
            *message.mutable_values() = question.entry().statistics();
            return success();
        }
        for (std::size_t i = 0; i < names_.size(); ++i) {
            auto at = std::ranges::find(known, names_[i]);
            if (at == known.end()) {
                // A covariance with its names changed about.
                const auto place = storage::findBeamStatistic(names_[i]);
                if (place) at = std::ranges::find(known, storage::beamStatistics()[*place].name);
            }
            if (at == known.end()) return unknown(i);
            message.add_names(names_[i]);
            message.add_values(question.entry().statistics(static_cast<int>(at - known.begin())));
        }
        return success();
    }

    const std::vector<std::string> names_;
    const std::optional<storage::SlicesWanted> slices_;
};

}  // namespace

MadePart statisticsPart(const proto::StatisticsQuery& query) {
    MOTE_RETURN_IF_ERROR(checkNames(query.names()));
    std::optional<storage::SlicesWanted> slices;
    if (!query.slices().empty()) {
        slices.emplace();
        MOTE_ASSIGN_OR_RETURN(slices->column, checkColumnName(query.slices(), "slices"));
        if (query.has_slice_count()) slices->count = query.slice_count();
        if (slices->count < 1 || slices->count > storage::SlicesWanted::most)
            return invalid("sliceCount", fmt::format("must be 1 to {}, not {}", storage::SlicesWanted::most,
                                                     slices->count));
    }
    return MadePart(std::make_unique<StatisticsPart>(
        std::vector<std::string>(query.names().begin(), query.names().end()), std::move(slices)));
}

}  // namespace mote::server
