// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/usual_range.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <span>
#include <vector>

#include "storage/beam/quantity_reader.h"
#include "storage/numbers/quantity_range.h"
#include "storage/numbers/scan.h"

namespace mote::render {
namespace {

using storage::QuantityReader;

struct Sample {
    double value, weight;

    auto operator<=>(const Sample&) const = default;
};

Error atColumn(const Error& error) {
    return {error.code, "column", "\"" + error.where + "\" " + error.message};
}

bool hasWeights(const storage::ParticleColumns& columns) {
    return std::ranges::any_of(columns.columns(), [](const auto& one) { return one.name == "weight"; });
}

/// What is looked at of one step.
class StepSample {
  public:
    StepSample(const storage::StepNumbers& step, std::uint64_t mostBlocks)
        : step_(step),
          all_((step.columns->pointCount() + RangeSample::block - 1) / RangeSample::block),
          blocks_(std::min(all_, mostBlocks)),
          weighted_(hasWeights(*step.columns)) {}

    /// Adds what has a value. Errors: of the column; cancelled.
    Status addTo(std::vector<Sample>& samples, const std::string& column,
                 const std::function<bool()>& cancelled) const {
        std::vector<std::string> names{column};
        if (weighted_) names.emplace_back("weight");
        const auto reader = QuantityReader::make(*step_.columns, step_.context, names);
        if (!reader.ok()) return atColumn(reader.error());
        std::vector<std::vector<Sample>> found(blocks_);
        const bool whole = storage::forBlocks(blocks_, cancelled, [&](std::uint64_t block) {
            found[block] = samplesOf(*reader, block * all_ / blocks_);
        });
        if (!whole) return Error{ErrorCode::cancelled, "", "cancelled"};
        step_.columns->check();
        for (const auto& some : found) samples.insert(samples.end(), some.begin(), some.end());
        return success();
    }

  private:
    /// Each stands for as many points as are not looked at beside it.
    std::vector<Sample> samplesOf(const QuantityReader& reader, std::uint64_t block) const {
        const std::uint64_t begin = block * RangeSample::block;
        const std::uint64_t count = std::min(RangeSample::block, step_.columns->pointCount() - begin);
        std::vector<double> values(count), weights(count, 1.0);
        QuantityReader::Scratch scratch;
        const std::array<std::span<double>, 2> out{values, weights};
        reader.read(begin, count, scratch, std::span(out).first(weighted_ ? 2 : 1));
        const double others = static_cast<double>(all_) / static_cast<double>(blocks_);
        std::vector<Sample> samples;
        for (std::size_t i = 0; i < count; ++i) {
            const double weight = weights[i] > 0.0 ? weights[i] : 0.0;
            if (std::isfinite(values[i]) && std::isfinite(weight))
                samples.push_back({values[i], others * weight});
        }
        return samples;
    }

    const storage::StepNumbers& step_;
    std::uint64_t all_, blocks_;
    bool weighted_;
};

/// The value below which the share of the weight lies, of samples in their order.
double quantile(const std::vector<Sample>& samples, double whole, double share) {
    double sum = 0.0;
    for (const auto& sample : samples) {
        sum += sample.weight;
        if (sum >= share * whole && sum > 0.0) return sample.value;
    }
    return samples.back().value;
}

ValueRange rangeOf(std::vector<Sample>& samples) {
    constexpr double outliers = 0.01;  // on either side
    if (samples.empty()) return {0.0, 0.0};
    std::ranges::sort(samples);
    double whole = 0.0;
    for (const auto& sample : samples) whole += sample.weight;
    if (!(whole > 0.0)) return {samples.front().value, samples.back().value};
    return {quantile(samples, whole, outliers), quantile(samples, whole, 1.0 - outliers)};
}

Result<ValueRange> extremes(const storage::RunSteps& run, const std::string& column,
                            const std::function<bool()>& cancelled) {
    const auto range = storage::quantityRange(run, column, cancelled);
    if (!range.ok()) return range.error();
    return range->low <= range->high ? ValueRange{range->low, range->high} : ValueRange{0.0, 0.0};
}

}  // namespace

Result<ValueRange> usualRange(const storage::RunSteps& run, const std::string& column,
                              const std::function<bool()>& cancelled) {
    const auto all = static_cast<std::uint32_t>(run.manifest().steps_size());
    const std::uint32_t looked = std::min(all, RangeSample::steps);
    std::vector<Sample> samples;
    for (std::uint32_t i = 0; i < looked; ++i) {
        const std::uint32_t index =
            looked < 2 ? 0 : static_cast<std::uint32_t>(std::uint64_t{i} * (all - 1) / (looked - 1));
        MOTE_ASSIGN_OR_RETURN(const auto step, run.step(index));
        if (!step.columns) return storage::withoutColumns("");
        const auto most =
            std::clamp(RangeSample::blocks / looked, RangeSample::fewest, RangeSample::greatest);
        MOTE_RETURN_IF_ERROR(StepSample(step, most).addTo(samples, column, cancelled));
    }
    const ValueRange range = rangeOf(samples);
    return range.low < range.high || samples.empty() ? Result<ValueRange>(range)
                                                     : extremes(run, column, cancelled);
}

}  // namespace mote::render
