// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/read_source.h"

#include <algorithm>
#include <cstring>

#include "preprocess/readers/particle_source.h"
#include "preprocess/volume/volume_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

constexpr std::uint64_t mostRows = 10'000;
constexpr std::uint64_t mostVoxels = 1u << 16;  // of a slice that is read
constexpr std::size_t mostSteps = 4;

void checkChunk(const prep::ParticleChunk& chunk, const std::vector<prep::Column>& wanted, std::size_t rows) {
    require(chunk.size == rows && chunk.lost.size() == rows);
    for (const prep::Column column : wanted) {
        require((column == prep::Column::id ? chunk.id.size() : chunk[column].size()) == rows);
    }
    for (const double weight : chunk[prep::Column::weight]) require(!(weight < 0.0));
}

std::vector<prep::Column> columnsOf(const prep::ParticleSource& source) {
    std::vector<prep::Column> columns = {prep::Column::weight, prep::Column::id};
    for (std::size_t i = 0; i < prep::columnCount; ++i) {
        const auto column = static_cast<prep::Column>(i);
        const bool listed = std::find(columns.begin(), columns.end(), column) != columns.end();
        if (source.has(column) && !listed) columns.push_back(column);
    }
    return columns;
}

/// Rows that a step does not have are refused, and columns that it lacks, but not those that only others
/// lack.
void askForMore(prep::ParticleSource& source, std::size_t step) {
    prep::ParticleChunk chunk;
    require(!source.read(step, source.steps()[step].particles, 1, {prep::Column::weight}, chunk).ok());
    for (std::size_t i = 0; i < prep::columnCount; ++i) {
        const auto column = static_cast<prep::Column>(i);
        const bool always = column == prep::Column::weight || column == prep::Column::id;
        if (always || source.has(column) || source.steps()[step].particles == 0) continue;
        if (source.read(step, 0, 1, {column}, chunk).ok()) checkChunk(chunk, {column}, 1);
    }
}

std::string readStep(prep::ParticleSource& source, std::size_t step,
                     const std::vector<prep::Column>& wanted) {
    const std::size_t rows = std::min(source.steps()[step].particles, mostRows);
    prep::ParticleChunk whole, tail;
    askForMore(source, step);
    if (const auto status = source.read(step, 0, rows, wanted, whole); !status)
        return status.error().toString();
    checkChunk(whole, wanted, rows);
    // The second half once more: what lies behind must be found again.
    const std::size_t half = rows / 2;
    if (const auto status = source.read(step, half, rows - half, wanted, tail); !status)
        return status.error().toString();
    checkChunk(tail, wanted, rows - half);
    require(std::equal(tail.id.begin(), tail.id.end(), whole.id.begin() + static_cast<std::ptrdiff_t>(half)));
    return "";
}

bool withinBounds(std::uint32_t n) {
    return n >= 1 && n <= prep::VolumeShape::maxDimension;
}

std::string readSlices(prep::VolumeSource& source) {
    const prep::VolumeShape& shape = source.shape();
    require(withinBounds(shape.nx) && withinBounds(shape.ny) && withinBounds(shape.nz));
    if (shape.voxelsOfSlice() > mostVoxels) return "too large to be looked at here";
    std::vector<float> first(shape.voxelsOfSlice()), again(first.size());
    if (const auto status = source.read(0, 1, first); !status) return status.error().toString();
    const std::uint32_t last = shape.nz - 1;
    if (const auto status = source.read(last, shape.nz, again); !status) return status.error().toString();
    // The first slice once more: what lies before must be found again.
    if (const auto status = source.read(0, 1, again); !status) return status.error().toString();
    require(std::memcmp(first.data(), again.data(), first.size() * sizeof(float)) == 0);
    return "";
}

}  // namespace

std::string readParticles(const proto::ParticlesJob& job, const std::vector<std::filesystem::path>& inputs) {
    Silent progress;
    auto source = prep::openParticleSource(job, inputs, progress);
    if (!source) return source.error().toString();
    const auto wanted = columnsOf(**source);
    const auto steps = (*source)->steps().size();
    require(steps > 0 && !(*source)->format().empty() && (*source)->mass() >= 0.0);
    require((*source)->has(prep::Column::weight) || (*source)->weightUnit().empty());
    for (std::size_t step = 0; step < std::min(steps, mostSteps); ++step) {
        if (auto error = readStep(**source, step, wanted); !error.empty()) return error;
    }
    return "";
}

std::string readVolume(const proto::VolumeSourceOptions& options, const std::filesystem::path& input) {
    const auto steps = prep::volumeSteps(options, {input});
    if (!steps) return steps.error().toString();
    Silent progress;
    for (std::size_t step = 0; step < std::min(steps->size(), mostSteps); ++step) {
        auto source = prep::openVolumeSource((*steps)[step].options, input, progress);
        auto error = source ? readSlices(**source) : source.error().toString();
        if (!error.empty()) return error;
    }
    return "";
}

}  // namespace mote::test
