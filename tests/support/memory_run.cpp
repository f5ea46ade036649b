// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/memory_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace mote::test {
namespace {

/// About 0, of deviation 1, with a far tail.
double spread(Random& random) {
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) sum += random.between(-0.9, 0.9);
    return random.chance(0.03) ? 4.0 * sum : sum;
}

struct Particles {
    std::array<std::vector<double>, 7> columns;  // x y z px py pz weight
    std::vector<std::uint64_t> ids;
};

Particles anyParticles(Random& random, const AnyRun& shape, std::uint64_t count) {
    Particles particles;
    const bool flat = shape.odd && random.chance(0.1);
    for (std::uint64_t i = 0; i < count; ++i) {
        const double q[3] = {spread(random), spread(random), spread(random)};
        for (std::size_t k = 0; k < 3; ++k)
            particles.columns[k].push_back(1e-3 * q[k] + (k == 2 ? 5.0 : 0.0));
        for (std::size_t k = 0; k < 3; ++k) {
            const double p = 0.6 * q[k] + 0.8 * spread(random);
            particles.columns[3 + k].push_back(flat && k == 0 ? 0.0 : 1e4 * p + (k == 2 ? 4e6 : 0.0));
        }
        particles.columns[6].push_back(shape.oddWeights && random.chance(0.05) ? random.oneOf({0.0, -1.5})
                                                                               : random.between(0.5, 2.0));
        if (shape.odd && random.chance(0.01))
            particles.columns[random.below(6)].back() = std::numeric_limits<double>::quiet_NaN();
    }
    return particles;
}

std::vector<std::uint64_t> anyIds(Random& random, std::uint64_t most, std::uint64_t count, bool far) {
    std::vector<std::uint64_t> all(most);
    std::iota(all.begin(), all.end(), 0);
    for (std::uint64_t i = 0; i < count; ++i) std::swap(all[i], all[i + random.below(most - i)]);
    all.resize(count);
    for (auto& id : all) {
        if (random.chance(0.02)) id = all[random.below(count)];  // repeats
    }
    if (far) {
        for (auto& id : all) id = id * 0x9e3779b97f4a7c15ULL;
    }
    return all;
}

/// The places of a plot of x, px, y, into the box.
std::vector<WeightedPoint> placesOf(const Particles& particles, std::uint64_t count) {
    const auto place = [](double value, double center, double half) {
        return std::isfinite(value) ? std::clamp(0.5 + 0.5 * (value - center) / half, 0.0, 1.0) : 0.5;
    };
    std::vector<WeightedPoint> points;
    for (std::uint64_t i = 0; i < count; ++i) {
        points.push_back(
            {{place(particles.columns[0][i], 0.0, 1.2e-2), place(particles.columns[3][i], 0.0, 1.2e5),
              place(particles.columns[1][i], 0.0, 1.2e-2)},
             1.0});
    }
    return points;
}

MemoryRun::Step makeStep(Random& random, const AnyRun& shape, bool far) {
    const auto count = random.chance(0.1) ? random.below(3) : random.below(shape.most + 1);
    const auto particles = anyParticles(random, shape, count);
    MemoryRun::Step step;
    step.points = MemoryStep::make(placesOf(particles, count), {.leafCapacity = 16, .maxLevel = 8});
    const auto rows = step.points->rows(0, count);
    static constexpr std::array names{"x", "y", "z", "px", "py", "pz", "weight"};
    static constexpr std::array units{"m", "m", "m", "eV/c", "eV/c", "eV/c", "1"};
    std::vector<MemoryColumns::Column> columns;
    for (std::size_t k = 0; k < names.size(); ++k) {
        const double offset = k == 2 ? 5.0 : k == 5 ? 4e6 : 0.0;
        MemoryColumns::Column column{{names[k], units[k], offset}, {}};
        for (const auto row : rows)
            column.values.push_back(static_cast<float>(particles.columns[k][row] - offset));
        columns.push_back(std::move(column));
    }
    std::optional<std::vector<std::uint64_t>> ids;
    if (shape.ids) {
        const auto ofRows = anyIds(random, shape.most, count, far);
        ids.emplace();
        for (const auto row : rows) ids->push_back(ofRows[row]);
    }
    step.columns = std::make_shared<const MemoryColumns>(count, std::move(columns), std::move(ids));
    return step;
}

}  // namespace

MemoryColumns::MemoryColumns(std::uint64_t points, std::vector<Column> columns,
                             std::optional<std::vector<std::uint64_t>> ids)
    : points_(points), columns_(std::move(columns)), ids_(std::move(ids)) {
    for (const auto& column : columns_) infos_.push_back(column.info);
    if (!ids_) return;
    byId_.resize(points);
    std::iota(byId_.begin(), byId_.end(), 0U);
    std::ranges::stable_sort(byId_, {}, [&](std::uint32_t point) { return (*ids_)[point]; });
}

MemoryRun::MemoryRun(std::vector<Step> steps, BeamContext context, const std::vector<proto::Axis>& axes)
    : steps_(std::move(steps)), context_(context) {
    manifest_.set_mass(context.mass);
    manifest_.mutable_axes()->Assign(axes.begin(), axes.end());
    for (const auto& step : steps_) {
        auto& entry = *manifest_.add_steps();
        entry.set_particles(step.points->pointCount());
        entry.set_iteration(10 * (manifest_.steps_size() - 1));
        entry.set_time(1e-9 * (manifest_.steps_size() - 1));
    }
    if (steps_.empty() || !steps_.front().columns) return;
    manifest_.set_ids(steps_.front().columns->hasIds());
    const auto& columns = steps_.front().columns->columns();
    for (std::size_t k = 0; k < columns.size(); ++k) {
        auto& entry = *manifest_.add_columns();
        entry.set_name(columns[k].name);
        entry.set_unit(columns[k].unit);
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const auto& step : steps_) {
            for (std::uint64_t i = 0; i < step.columns->pointCount(); ++i) {
                const double value = step.columns->value(k, i);
                if (!std::isfinite(value)) continue;
                low = std::min(low, value);
                high = std::max(high, value);
            }
        }
        entry.set_min(low <= high ? low : 0.0);
        entry.set_max(low <= high ? high : 0.0);
    }
}

Result<storage::StepNumbers> MemoryRun::step(std::uint32_t index) const {
    if (index >= steps_.size()) return Error{ErrorCode::notFound, "run", "has no such step"};
    return storage::StepNumbers{steps_[index].points, steps_[index].columns, context_};
}

std::shared_ptr<const MemoryRun> anyRun(Random& random, const AnyRun& shape) {
    std::vector<MemoryRun::Step> steps;
    const bool far = random.chance(0.3);
    for (std::uint32_t i = 0; i < shape.steps; ++i) steps.push_back(makeStep(random, shape, far));
    return std::make_shared<const MemoryRun>(std::move(steps),
                                             BeamContext{.mass = 0.511e6, .meanMomentum = 4e6});
}

}  // namespace mote::test
