// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/written_run.h"

#include <array>
#include <bit>
#include <numeric>

#include "storage/arrays/array_file.h"
#include "storage/dataset_writer.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/step_file.h"
#include "storage/storage_error.h"
#include "tests/support/must.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

constexpr std::uint32_t writtenLeaf = 16, maxLevel = 8;

MemoryRun::Step cloudStep(Random& random, std::uint64_t count, std::uint8_t volumeLevel) {
    std::vector<WeightedPoint> points;
    for (std::uint64_t i = 0; i < count; ++i) {
        const double scale = random.chance(0.5) ? 0.05 : 1.0;
        points.push_back({scale * glm::dvec3(random.unit(), random.unit(), random.unit()), 1.0});
    }
    MemoryRun::Step step;
    step.points = MemoryStep::make(
        points, {.leafCapacity = writtenLeaf, .maxLevel = maxLevel, .volumeLevel = volumeLevel});
    std::vector<MemoryColumns::Column> columns{{{"x", "m", 0.5}, {}},
                                               {{"y", "m", 0.5}, {}},
                                               {{"z", "m", 0.5}, {}},
                                               {{"px", "eV/c", 0.0}, {}},
                                               {{"weight", "1", 1.0}, {}}};
    std::vector<std::uint64_t> ids;
    for (const auto row : step.points->rows(0, count)) {
        for (int axis = 0; axis < 3; ++axis)
            columns[static_cast<std::size_t>(axis)].values.push_back(
                static_cast<float>(points[row].position[axis] - 0.5));
        columns[3].values.push_back(static_cast<float>(random.between(-1.0, 1.0)));
        columns[4].values.push_back(static_cast<float>(random.between(-0.5, 0.5)));
        ids.push_back(3 * row);
    }
    step.columns = std::make_shared<const MemoryColumns>(count, std::move(columns), std::move(ids));
    return step;
}

void writePoints(const std::filesystem::path& directory, const std::string& name, const MemoryStep& step) {
    storage::StepContent content;
    content.axes = {"x", "y", "z"};
    content.boundsMax = {1.0, 1.0, 1.0};
    content.totalWeight = static_cast<double>(step.pointCount());
    content.nodes = step.nodes();
    content.leaves = step.leaves();
    content.positions = step.positions(0, step.pointCount());
    content.rows = step.rows(0, step.pointCount());
    content.volume = step.volume();
    content.volumeSize = step.volumeSize();
    const auto preview = step.preview(storage::Preview::mostPoints);
    content.previewPoints = preview.points;
    content.previewThreshold = preview.threshold;
    must(storage::writeStep(directory, name, content));
}

void writeColumns(const std::filesystem::path& directory, const std::string& name,
                  const MemoryColumns& columns) {
    const auto points = columns.pointCount();
    const auto file = must(storage::ArrayFileWriter::create(
        directory, name, storage::columnsLayout(columns.columns(), true, points)));
    const auto count = columns.columns().size();
    for (std::size_t c = 0; c < count; ++c)
        must(file.write(c, 0, std::as_bytes(columns.values(c, 0, points))));
    must(file.write(count, 0, std::as_bytes(columns.ids(0, points))));
    must(file.write(count + 1, 0, std::as_bytes(columns.pointsById(0, points))));
    must(file.finish());
}

void describeStep(const MemoryRun::Step& step, const std::string& points, const std::string& columns,
                  proto::ParticleStepEntry& entry) {
    entry.set_file(points + ".h5");
    entry.set_digest(points + ".digest");
    entry.set_columns_file(columns + ".h5");
    entry.set_columns_digest(columns + ".digest");
    entry.set_total_weight(static_cast<double>(step.points->pointCount()));
    for (const auto& column : step.columns->columns()) entry.add_column_offset(column.offset);
    for (int bin = 0; bin < storage::densityHistogramBins; ++bin)
        entry.add_density_histogram(bin == 0 ? step.points->pointCount() : 0);
}

}  // namespace

std::shared_ptr<const MemoryRun> cloudRun(std::uint64_t seed, std::uint64_t points, std::uint32_t steps,
                                          std::uint8_t volumeLevel) {
    Random random(seed, 151);
    std::vector<MemoryRun::Step> all;
    for (std::uint32_t i = 0; i < steps; ++i) all.push_back(cloudStep(random, points, volumeLevel));
    return std::make_shared<const MemoryRun>(std::move(all), BeamContext{});
}

void writeRun(const MemoryRun& run, const std::filesystem::path& output) {
    auto writer = must(storage::DatasetWriter::create(output));
    proto::Manifest manifest;
    manifest.set_kind("particles");
    manifest.set_format(storage::formatVersion);
    auto& particles = *manifest.mutable_particles();
    particles = run.manifest();
    for (const char* name : {"x", "y", "z"}) {
        auto& axis = *particles.add_axes();
        axis.set_name(name);
        axis.set_max(1.0);
    }
    const auto& first = *run.at(0).points;
    particles.set_density_min(first.logDensity().min);
    particles.set_density_max(first.logDensity().max);
    particles.set_volume_level(static_cast<std::uint32_t>(std::countr_zero(first.volumeSize())));
    particles.set_leaf_capacity(writtenLeaf);
    particles.set_max_level(maxLevel);
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        const auto points = storage::stepName(index), columns = storage::columnsName(index);
        writePoints(writer.directory(), points, *run.at(index).points);
        writeColumns(writer.directory(), columns, *run.at(index).columns);
        for (const auto& name : {points, columns}) {
            must(writer.add(name + ".h5"));
            must(writer.add(name + ".digest"));
        }
        describeStep(run.at(index), points, columns, *particles.mutable_steps(i));
    }
    must(writer.publish(manifest));
}

}  // namespace mote::test
