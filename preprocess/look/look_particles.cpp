// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "preprocess/kept_notes.h"
#include "preprocess/look/look_at.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t chunkRows = 1u << 20;

std::string toldByReader(const proto::ParticlesJob& job, const std::string& format) {
    const ParticleReader* reader = particleReader(format);
    return toldBy(job.format(), reader == nullptr ? "its content" : reader->told);
}

struct ColumnFact {
    Column column;
    const char* name;
    const char* unit;
};
constexpr std::array<ColumnFact, columnCount - 1> columns{{{Column::x, "x", "m"},
                                                           {Column::y, "y", "m"},
                                                           {Column::z, "z", "m"},
                                                           {Column::t, "t", "s"},
                                                           {Column::px, "px", "eV/c"},
                                                           {Column::py, "py", "eV/c"},
                                                           {Column::pz, "pz", "eV/c"},
                                                           {Column::weight, "weight", ""}}};

/// For people, whom more digits tell nothing.
std::string shortText(double value) {
    return fmt::format("{:.6g}", value);
}
template <class T>
std::string shortText(T value) {
    return fmt::format("{}", value);
}

/// "0 to 9", or "0" of one.
template <class T>
std::string ends(const std::vector<T>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *low == *high ? shortText(*low) : shortText(*low) + " to " + shortText(*high);
}

/// How many steps there are, of which times, with how many particles.
void addSteps(const ParticleSource& source, Found& found) {
    std::vector<double> times;
    std::vector<std::int64_t> iterations;
    std::vector<std::uint64_t> counts;
    std::uint64_t all = 0;
    for (const SourceStep& step : source.steps()) {
        times.push_back(step.time);
        iterations.push_back(step.iteration);
        counts.push_back(step.particles);
        all += step.particles;
    }
    const auto steps = static_cast<std::uint64_t>(counts.size());
    std::string text = fmt::format("{}", steps);
    std::string rows = fmt::format("{} particles", all);
    if (steps > 0) text += fmt::format(", iteration {}, time {} s", ends(iterations), ends(times));
    if (steps > 1) rows = fmt::format("{} in a step, {} in all", ends(counts), all);
    found.facts.push_back({"steps", steps, "steps", text});
    found.facts.push_back({"particles", all, "rows", rows});
    found.facts.push_back({"iterations", std::move(iterations)});
    found.facts.push_back({"times", std::move(times)});
    found.facts.push_back({"counts", std::move(counts)});
}

void addParticle(const ParticleSource& source, Found& found) {
    const std::string species = source.species();
    const double mass = source.mass(), charge = source.particleCharge();
    const std::string unit = source.weightUnit();
    found.facts.push_back({"species", species, "species", species});
    found.facts.push_back(
        {"mass", mass, "mass", mass > 0.0 ? fmt::format("{:.10g} eV/c^2", mass) : "not known, or 0"});
    found.facts.push_back({"particleCharge", charge, "charge",
                           charge != 0.0 ? fmt::format("{:.10g} C of one particle", charge) : ""});
    found.facts.push_back({"weightUnit", unit, "weights",
                           unit == "1"   ? "count real particles"
                           : unit == "C" ? "are charges"
                                         : ""});
}

/// The ranges of what the run has, of the first step that is not empty, or of all.
Status readRanges(ParticleSource& source, bool all, Progress& progress, Found& found) {
    std::vector<Column> wanted;
    for (const ColumnFact& one : columns) {
        if (!source.has(one.column)) continue;
        wanted.push_back(one.column);
        const bool weight = one.column == Column::weight;
        found.columns.push_back({one.name, weight ? source.weightUnit() : one.unit});
    }
    const bool ids = source.has(Column::id);
    found.facts.push_back({"ids", ids, "ids", ids ? "the source's own" : "none: the rows' numbers"});
    std::uint64_t lost = 0;
    ParticleChunk chunk;
    for (std::size_t step = 0; step < source.steps().size(); ++step) {
        const std::uint64_t rows = source.steps()[step].particles;
        for (std::uint64_t begin = 0; begin < rows; begin += chunkRows) {
            if (progress.cancelled()) return wasCancelled();
            const auto count = static_cast<std::size_t>(std::min(chunkRows, rows - begin));
            MOTE_RETURN_IF_ERROR(source.read(step, begin, count, wanted, chunk));
            for (std::size_t i = 0; i < wanted.size(); ++i) {
                for (const double value : chunk[wanted[i]]) found.columns[i].take(value);
            }
            lost += static_cast<std::uint64_t>(std::count(chunk.lost.begin(), chunk.lost.end(), 1));
            progress.report(static_cast<double>(begin + count) / static_cast<double>(rows), "reading");
        }
        if (!all && rows > 0) break;
    }
    found.facts.push_back({"lost", lost, "lost", lost > 0 ? fmt::format("{}", lost) : ""});
    const bool every = all || source.steps().size() < 2;
    found.facts.push_back({"rangesOf", std::string(every ? "all" : "first"), "ranges",
                           every ? "" : "of the first step alone (--all: of every step)"});
    return success();
}

Result<Found> lookAtOne(const proto::ParticlesJob& job, const std::filesystem::path& input, bool all,
                        Progress& progress) {
    SilentNotes silent(progress);
    KeptNotes notes(silent);
    MOTE_ASSIGN_OR_RETURN(const auto source, openParticleSource(job, {input}, notes));
    Found found;
    found.kind = "particles";
    found.format = source->format();
    found.told = toldByReader(job, found.format);
    found.name = job.species();
    addParticle(*source, found);
    addSteps(*source, found);
    const Status read = readRanges(*source, all, notes, found);
    if (!read.ok() && read.error().code == ErrorCode::cancelled) return read.error();
    if (!read.ok()) found.refused.push_back(read.error().toString());
    found.notes = notes.notes();
    return found;
}

}  // namespace

Result<std::vector<Found>> lookAtParticles(const std::filesystem::path& input, const LookOptions& options,
                                           Progress& progress) {
    proto::ParticlesJob job = options.particles;
    std::vector<std::string> species{job.species()};
    if (job.species().empty()) {
        SilentNotes silent(progress);
        MOTE_ASSIGN_OR_RETURN(auto several, runSpecies(job, {input}, silent));
        if (several.size() > 1) species = std::move(several);
    }
    const Found whole{"particles", "openpmd", toldByReader(job, "openpmd"), "", {}, {}, {}, {}};
    return lookAtEach(species, whole, [&](const std::string& name) {
        job.set_species(name);
        return lookAtOne(job, input, options.all, progress);
    });
}

}  // namespace mote::prep
