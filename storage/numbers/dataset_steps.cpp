// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/dataset_steps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/scene/most_recent.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

/// Weighted mean of |p|; 0 where there is none.
double meanMomentum(const ParticleColumns& columns) {
    const auto weighted = columns.find("weight").has_value();
    std::vector<std::string> names{"p"};
    if (weighted) names.emplace_back("weight");
    const auto reader = QuantityReader::make(columns, {}, names);
    if (!reader.ok()) return 0.0;
    struct Sums {
        double weight = 0.0, momentum = 0.0;
    };
    std::vector<Sums> sums(blockCount(columns.pointCount()));
    forBlocks(sums.size(), {}, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, columns.pointCount());
        std::vector<double> momentum(part.count), weight(part.count, 1.0);
        QuantityReader::Scratch scratch;
        const std::array out{std::span(momentum), std::span(weight)};
        reader->read(part.begin, part.count, scratch, std::span(out).first(names.size()));
        for (std::size_t i = 0; i < momentum.size(); ++i) {
            if (!std::isfinite(momentum[i]) || !std::isfinite(weight[i])) continue;
            sums[block].weight += weight[i];
            sums[block].momentum += weight[i] * momentum[i];
        }
    });
    Sums all;
    for (const auto& one : sums) {
        all.weight += one.weight;
        all.momentum += one.momentum;
    }
    return all.weight != 0.0 ? all.momentum / all.weight : 0.0;
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
    if (entry.columns_file().empty()) return numbers;
    MOTE_ASSIGN_OR_RETURN(numbers.columns, ParticleColumns::open(directory_, *manifest_, index, budget_));
    const auto mean = std::ranges::find(particles.statistic_names(), "mean_p");
    if (mean != particles.statistic_names().end()) {
        numbers.context.meanMomentum =
            entry.statistics(static_cast<int>(mean - particles.statistic_names().begin()));
        return numbers;
    }
    try {
        numbers.context.meanMomentum = meanMomentum(*numbers.columns);
    } catch (const StorageError& error) {
        return error.error();
    }
    return numbers;
}

}  // namespace mote::storage
