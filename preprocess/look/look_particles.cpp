// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "preprocess/kept_notes.h"
#include "preprocess/look/look_at.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/readers/particle_source.h"
#include "preprocess/readers/run_species.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t chunkRows = 1u << 20;

struct Told {
    std::string_view format, by;
};
/// What tells each format, unless --format does.
constexpr std::array<Told, 19> told{{
    {"openpmd", "HDF5 with openPMD's attributes or records"},
    {"h5part", "HDF5 with groups Step#N"},
    {"impactz", "nine columns of numbers, and ImpactZ.in beside it or a frequency"},
    {"impactt", "six columns of numbers, and ImpactT.in beside it"},
    {"sdds", "its first line SDDS"},
    {"elegant", "HDF5 with groups pageN/columns"},
    {"csv", "a table with a line of names, or --map"},
    {"npy", "NumPy's mark of one array"},
    {"npz", "an archive of NumPy's arrays"},
    {"tracewin", "TraceWin's mark in its first bytes"},
    {"astra", "ten columns of numbers, of which the last two can be a species and a status"},
    {"genesis4", "HDF5 with slicelength, slicespacing and beamletsize"},
    {"tfs", "lines '@ NAME' of TFS"},
    {"json", "JSON with lists of numbers"},
    {"gpt", "GPT's mark, or its names in text"},
    {"ocelot", "an archive with the arrays rparticles and E"},
    {"opal", "its first line the number of rows of six numbers"},
    {"pyorbit", "lines '% PARTICLE_ATTRIBUTES'"},
    {"mote", "a dataset of our own"},
}};

std::string toldBy(const proto::ParticlesJob& job, const std::string& format) {
    if (!job.format().empty() && job.format() != "auto") return "--format";
    const auto* const found =
        std::find_if(told.begin(), told.end(), [&](const Told& one) { return one.format == format; });
    return found == told.end() ? "its content" : std::string(found->by);
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

/// "0 to 9", or "0" of one.
template <class T>
std::string ends(const std::vector<T>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *low == *high ? fmt::format("{}", *low) : fmt::format("{} to {}", *low, *high);
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
            if (progress.cancelled()) return cancelledError();
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
    found.told = toldBy(job, found.format);
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
    std::vector<Found> all;
    for (const std::string& each : species) {
        job.set_species(each);
        auto found = lookAtOne(job, input, options.all, progress);
        if (found.ok()) {
            all.push_back(std::move(*found));
            continue;
        }
        if (species.size() == 1 || found.error().code == ErrorCode::cancelled) return found.error();
        Found& broken = all.emplace_back();
        broken.kind = "particles";
        broken.format = "openpmd";
        broken.told = toldBy(job, "openpmd");
        broken.name = each;
        broken.refused.push_back(found.error().toString());
    }
    return all;
}

}  // namespace mote::prep
