// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "protocol/quantity/quantity.h"
#include "protocol/quantity/statistic.h"
#include "server/numbers/coarse_notes.h"
#include "server/numbers/query_parts.h"
#include "storage/beam/neutral_species.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/point_statistics.h"

namespace mote::server {
namespace {

/// Of statistics while they are summed, bytes a point: moments of blocks, a sample, and what lies near a
/// percentile's cut.
constexpr std::uint64_t bytesOfPoint = 1;

class StatisticsPart final : public QueryPart {
  public:
    StatisticsPart(std::vector<std::string> names, std::optional<storage::SlicesWanted> slices)
        : names_(std::move(names)), slices_(std::move(slices)) {}

    Status answer(const StepQuestion& question, QueryAnswer& answer) override {
        const auto& manifest = question.manifest();
        auto& message = *answer.message.mutable_statistics();
        const bool kept = question.everything() && !slices_ && manifest.statistic_names_size() > 0;
        MOTE_ASSIGN_OR_RETURN(const auto asked, this->asked());
        if (kept && asked.further.empty()) return ofManifest(question, message);
        MOTE_ASSIGN_OR_RETURN(const auto numbers, question.numbers());
        MOTE_RETURN_IF_ERROR(checkFurther(numbers));
        MOTE_ASSIGN_OR_RETURN(const auto chosen, question.chosen());
        MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(numbers.columns->pointCount() * bytesOfPoint));
        storage::BeamFacts facts;
        facts.mass = manifest.mass();
        facts.particleCharge = manifest.particle_charge();
        facts.neutral = storage::isNeutral(manifest.species());
        facts.weightUnit = manifest.weight_unit();
        facts.lost = question.everything() ? question.entry().lost() : 0;
        facts.meanMomentum = numbers.context.meanMomentum;
        MOTE_ASSIGN_OR_RETURN(const auto found,
                              storage::pointStatistics(numbers, facts, chosen.get(), slices_, passes(),
                                                       question.cancelled(), asked.further));
        answer.memory.shrink(0);
        for (auto& note : notesOfStatistics(*numbers.columns, found, names_))
            answer.message.add_notes(std::move(note));
        fill(found, asked.places, message);
        return kept ? ofManifest(question, message) : success();
    }

  private:
    /// Where the values that are asked for lie among all.
    struct Asked {
        std::vector<std::size_t> places;
        std::vector<QuantityStatistic> further;  ///< that the table does not have
    };
    Result<Asked> asked() const {
        Asked asked;
        const auto known = statistics().size();
        for (std::size_t i = 0; i < names_.size(); ++i) {
            const auto place = findStatistic(names_[i]);
            asked.places.push_back(place.value_or(known + asked.further.size()));
            if (place) continue;
            auto further = parseQuantityStatistic(names_[i]);
            if (!further) return unknown(i);
            asked.further.push_back(*std::move(further));
        }
        if (!names_.empty()) return asked;
        for (std::size_t i = 0; i < known; ++i) asked.places.push_back(i);
        return asked;
    }

    /// Whether the step has the quantities of further statistics.
    Status checkFurther(const storage::StepNumbers& numbers) const {
        for (std::size_t i = 0; i < names_.size(); ++i) {
            const auto further = parseQuantityStatistic(names_[i]);
            if (!further || findStatistic(names_[i])) continue;
            const auto made =
                storage::QuantityReader::make(*numbers.columns, numbers.context, further->quantities);
            if (made.ok()) continue;
            return Error{made.error().code, fmt::format("names[{}]", i),
                         fmt::format("\"{}\" {}", made.error().where, made.error().message)};
        }
        return success();
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

    void fill(const storage::PointStatistics& found, const std::vector<std::size_t>& places,
              proto::Statistics& message) const {
        for (std::size_t i = 0; i < places.size(); ++i) {
            message.add_names(names_.empty() ? statistics()[places[i]].name : names_[i]);
            message.add_values(found.values[places[i]]);
        }
        message.mutable_slice_edges()->Add(found.edges.begin(), found.edges.end());
        for (const auto& slice : found.slices) {
            auto& values = *message.add_slices();
            for (const auto place : places) values.add_values(slice[place]);
        }
    }

    /// As preparation found them, from the source's own values; those that it did not stay.
    Status ofManifest(const StepQuestion& question, proto::Statistics& message) const {
        const auto& known = question.manifest().statistic_names();
        if (names_.empty()) {
            *message.mutable_names() = known;
            *message.mutable_values() = question.entry().statistics();
            return success();
        }
        for (int i = 0; i < static_cast<int>(names_.size()); ++i) {
            const auto& name = names_[static_cast<std::size_t>(i)];
            const auto place = findStatistic(name);
            auto at = std::ranges::find(known, name);
            // A covariance with its names changed about.
            if (at == known.end() && place) at = std::ranges::find(known, statistics()[*place].name);
            if (at == known.end() && i < message.names_size()) continue;
            if (at == known.end()) return unknown(static_cast<std::size_t>(i));
            const double value = question.entry().statistics(static_cast<int>(at - known.begin()));
            if (i == message.names_size()) {
                message.add_names(name);
                message.add_values(value);
            }
            message.set_values(i, value);
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
        if (query.slices_of() == "charge") slices->of = storage::SlicesWanted::Of::charge;
        if (!query.slices_of().empty() && query.slices_of() != "even" && query.slices_of() != "charge")
            return invalid("slicesOf", "is \"even\" or \"charge\"");
        if (slices->count < 1 || slices->count > storage::SlicesWanted::most)
            return invalid("sliceCount", fmt::format("must be 1 to {}, not {}", storage::SlicesWanted::most,
                                                     slices->count));
    }
    return MadePart(std::make_unique<StatisticsPart>(
        std::vector<std::string>(query.names().begin(), query.names().end()), std::move(slices)));
}

}  // namespace mote::server
