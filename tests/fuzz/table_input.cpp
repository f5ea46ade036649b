// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <vector>

#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/particle_source.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

constexpr std::uint64_t mostRows = 10'000;

void checkChunk(const prep::ParticleChunk& chunk, const std::vector<prep::Column>& wanted, std::size_t rows) {
    require(chunk.size == rows && chunk.lost.size() == rows);
    for (const prep::Column column : wanted) {
        require((column == prep::Column::id ? chunk.id.size() : chunk[column].size()) == rows);
    }
    for (const double weight : chunk[prep::Column::weight]) require(!(weight < 0.0));
}

std::string readSource(const std::string& format, const std::filesystem::path& path) {
    proto::ParticlesJob job;
    job.set_format(format);
    job.mutable_impact()->set_frequency(1e9);
    job.mutable_impact()->set_mass(1e6);
    Silent progress;
    auto source = prep::openParticleSource(job, {path}, progress);
    if (!source) return source.error().toString();
    std::vector<prep::Column> wanted = {prep::Column::weight, prep::Column::id};
    for (std::size_t i = 0; i < prep::columnCount; ++i) {
        const auto column = static_cast<prep::Column>(i);
        const bool listed = std::find(wanted.begin(), wanted.end(), column) != wanted.end();
        if ((*source)->has(column) && !listed) wanted.push_back(column);
    }
    const std::size_t rows = std::min((*source)->steps().at(0).particles, mostRows);
    prep::ParticleChunk whole, tail;
    if (const auto status = (*source)->read(0, 0, rows, wanted, whole); !status)
        return status.error().toString();
    checkChunk(whole, wanted, rows);
    // The second half once more: what lies behind must be found again.
    const std::size_t half = rows / 2;
    if (const auto status = (*source)->read(0, half, rows - half, wanted, tail); !status)
        return status.error().toString();
    checkChunk(tail, wanted, rows - half);
    require(std::equal(tail.id.begin(), tail.id.end(), whole.id.begin() + static_cast<std::ptrdiff_t>(half)));
    return "";
}

}  // namespace

std::string tableInput(std::string_view input) {
    const auto [line, bytes] = firstLine(input);
    const std::string format(line);
    const MemoryFile file(bytes);
    if (format == "deck") {
        for (const auto code : {prep::ImpactDeck::Code::impactZ, prep::ImpactDeck::Code::impactT}) {
            const auto deck = prep::ImpactDeck::read(file.path(), code);
            if (deck) return "";
            if (code == prep::ImpactDeck::Code::impactT) return deck.error().toString();
        }
    }
    if (format == "track") {
        const auto track = prep::ReferenceTrack::read(file.path());
        if (!track) return track.error().toString();
        require(track->at(0.5).gamma >= 1.0);
        return "";
    }
    // HDF5 is not what is looked at here, and it is not instrumented.
    const bool hdf5 =
        format == "openpmd" || format == "h5part" || format == "genesis4" || format == "elegant";
    if (hdf5 || bytes.starts_with("\x89HDF")) return "another reader";
    return readSource(format, file.path());
}

}  // namespace mote::test
