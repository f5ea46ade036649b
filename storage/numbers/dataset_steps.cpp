// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/dataset_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "protocol/base/most_recent.h"
#include "protocol/quantity/statistic.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

/// The weighted mean of a quantity; NaN where there is none.
double meanOf(const ParticleColumns& columns, const std::string& quantity) {
    const auto weighted = columns.find("weight").has_value();
    std::vector<std::string> names{quantity};
    if (weighted) names.emplace_back("weight");
    const auto reader = QuantityReader::make(columns, {}, names);
    if (!reader.ok()) return std::numeric_limits<double>::quiet_NaN();
    struct Sums {
        double from = 0.0, weight = 0.0, product = 0.0;  // of values less the first: nothing cancels
    };
    std::vector<Sums> sums(blockCount(columns.pointCount()));
    forBlocks(sums.size(), {}, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, columns.pointCount());
        std::vector<double> values(part.count), weight(part.count, 1.0);
        QuantityReader::Scratch scratch;
        const std::array out{std::span(values), std::span(weight)};
        reader->read(part.begin, part.count, scratch, std::span(out).first(names.size()));
        auto& sum = sums[block];
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!std::isfinite(values[i]) || !std::isfinite(weight[i])) continue;
            if (sum.weight == 0.0) sum.from = values[i];
            sum.weight += weight[i];
            sum.product += weight[i] * (values[i] - sum.from);
        }
    });
    Sums all;
    for (const auto& one : sums) {
        if (all.weight == 0.0) all.from = one.from;
        all.weight += one.weight;
        all.product += one.product + one.weight * (one.from - all.from);
    }
    return all.from + all.product / all.weight;
}

/// The means of a step whose dataset was made without statistics.
void setMeansOf(const ParticleColumns& columns, BeamContext& context) {
    setMeans(
        [&](std::string_view name) { return meanOf(columns, parseQuantityStatistic(name)->quantities[0]); },
        context);
}

}  // namespace

DatasetSteps::DatasetSteps(PathBeneath directory, std::shared_ptr<const proto::Manifest> manifest,
                           std::shared_ptr<BlockBudget> budget)
    : directory_(std::move(directory)), manifest_(std::move(manifest)), budget_(std::move(budget)) {}

std::optional<StepNumbers> DatasetSteps::find(std::uint32_t index) const {
    const auto* const found = mostRecent(opened_, [&](const Opened& one) { return one.index == index; });
    if (found == nullptr) return std::nullopt;
    return found->numbers;
}

Result<StepNumbers> DatasetSteps::step(std::uint32_t index) const {
    {
        const std::lock_guard lock(mutex_);
        if (auto found = find(index)) return *std::move(found);
    }
    MOTE_ASSIGN_OR_RETURN(auto numbers, open(index));
    const std::lock_guard lock(mutex_);
    if (auto found = find(index)) return *std::move(found);
    opened_.push_front({index, numbers});
    if (opened_.size() > kept) opened_.pop_back();
    return numbers;
}

Result<StepNumbers> DatasetSteps::open(std::uint32_t index) const {
    StepNumbers numbers;
    MOTE_ASSIGN_OR_RETURN(numbers.points, ParticleStep::open(directory_, *manifest_, index, budget_));
    const auto& particles = manifest_->particles();
    const auto& entry = particles.steps(static_cast<int>(index));
    numbers.context.mass = particles.mass();
    numbers.context.photons = particles.species() == "photon";
    if (entry.columns_file().empty()) return numbers;
    MOTE_ASSIGN_OR_RETURN(numbers.columns, ParticleColumns::open(directory_, *manifest_, index, budget_));
    const auto& names = particles.statistic_names();
    if (!names.empty()) {
        setMeans(
            [&](std::string_view name) {
                const auto found = std::ranges::find(names, name);
                return found == names.end() ? std::numeric_limits<double>::quiet_NaN()
                                            : entry.statistics(static_cast<int>(found - names.begin()));
            },
            numbers.context);
        return numbers;
    }
    try {
        setMeansOf(*numbers.columns, numbers.context);
    } catch (const StorageError& error) {
        return error.error();
    }
    return numbers;
}

}  // namespace mote::storage
