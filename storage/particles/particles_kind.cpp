// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <string>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/quantity/quantity.h"
#include "storage/dataset_kind.h"
#include "storage/manifest.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/mapped_step.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

constexpr int maxColumns = 256;
constexpr int maxStatistics = 1024;
constexpr std::size_t longestName = 63;  // of a unit

bool isName(const std::string& name) {
    return checkColumnName(name, "").ok();
}

bool isUnit(std::string_view unit) {
    return unit.size() <= longestName &&
           std::ranges::all_of(unit, [](char c) { return c >= 0x20 && c < 0x7f; });
}

Status checkColumn(const proto::ColumnEntry& column, std::set<std::string_view>& seen) {
    if (!isName(column.name()) || column.name() == "id") return corrupt("name", "is not a column's name");
    if (!seen.insert(column.name()).second) {
        return corrupt("name", fmt::format("\"{}\" is there twice", column.name()));
    }
    if (!isUnit(column.unit())) return corrupt("unit", "is not a unit's name");
    if (!column.type().empty() && column.type() != "f32" && column.type() != "f64") {
        return corrupt("type", "must be \"f32\" or \"f64\"");
    }
    if (std::isfinite(column.max() - column.min()) && column.min() <= column.max()) return success();
    return corrupt("min", "the range must be finite and min not above max");
}

template <class Names>
Status checkDifferent(const Names& names, int most, const char* field) {
    if (names.size() > most) return corrupt(field, fmt::format("has more than {} entries", most));
    std::set<std::string_view> seen;
    for (int i = 0; i < names.size(); ++i) {
        if (isName(names[i]) && seen.insert(names[i]).second) continue;
        return corrupt(fmt::format("{}[{}]", field, i), "is no name, or there twice");
    }
    return success();
}

/// Columns, ids, mass, units and the names of statistics. Errors: corrupt, with the field.
Status checkColumns(const proto::ParticlesManifest& particles) {
    if (particles.columns_size() > maxColumns) {
        return corrupt("columns", fmt::format("a plot has at most {} columns", maxColumns));
    }
    std::set<std::string_view> seen;
    for (int i = 0; i < particles.columns_size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkColumn(particles.columns(i), seen), fmt::format("columns[{}]", i));
    }
    if (!(std::isfinite(particles.mass()) && particles.mass() >= 0.0)) {
        return corrupt("mass", "must be finite and not negative");
    }
    if (!isUnit(particles.species())) return corrupt("species", "is not a species' name");
    if (!std::isfinite(particles.particle_charge())) return corrupt("particleCharge", "must be finite");
    if (!isUnit(particles.weight_unit())) return corrupt("weightUnit", "is not a unit's name");
    const auto& lost = particles.lost_particles();
    if (!lost.empty() && lost != "without" && lost != "with" && lost != "only") {
        return corrupt("lostParticles", "must be \"without\", \"with\" or \"only\"");
    }
    return checkDifferent(particles.statistic_names(), maxStatistics, "statisticNames");
}

/// What a step has of them. Errors: corrupt, with the field.
Status checkStepColumns(const proto::ParticlesManifest& particles, const proto::ParticleStepEntry& step,
                        const FileNames& files) {
    const bool columns = particles.columns_size() > 0 || particles.ids();
    if (columns && !files.contains(step.columns_file())) {
        return corrupt("columnsFile", "is not among the dataset's files");
    }
    if (columns && !files.contains(step.columns_digest())) {
        return corrupt("columnsDigest", "is not among the dataset's files");
    }
    if (!columns && !step.columns_file().empty()) {
        return corrupt("columnsFile", "is there, though the plot has no columns");
    }
    if (step.column_offset_size() != particles.columns_size()) {
        return corrupt("columnOffset", "must have an entry for each column");
    }
    for (const double offset : step.column_offset()) {
        if (!std::isfinite(offset)) return corrupt("columnOffset", "must be finite");
    }
    if (step.column_resolution_size() != 0 && step.column_resolution_size() != particles.columns_size()) {
        return corrupt("columnResolution", "must have an entry for each column, or none");
    }
    for (const double resolution : step.column_resolution()) {
        if (!(std::isfinite(resolution) && resolution >= 0.0)) {
            return corrupt("columnResolution", "must be finite and not negative");
        }
    }
    // A number that is not defined is none.
    if (step.statistics_size() == particles.statistic_names_size()) return success();
    return corrupt("statistics", "must have an entry for each name");
}

using Axes = google::protobuf::RepeatedPtrField<proto::Axis>;

Status checkAxes(const Axes& axes) {
    for (int i = 0; i < axes.size(); ++i) {
        const auto& axis = axes[i];
        if (axis.name().empty()) return corrupt(fmt::format("axes[{}].name", i), "is missing");
        if (!std::isfinite(axis.max() - axis.min()) || !(axis.min() < axis.max())) {
            return corrupt(fmt::format("axes[{}]", i), "the bounds must be finite and min below max");
        }
    }
    return success();
}

Status checkAxesOfPlot(const proto::ParticlesManifest& particles) {
    if (particles.axes_size() != axesOfPlot && !stepsBehindAxes(particles))
        return corrupt("axes", "a particle plot has three axes");
    return checkAxes(particles.axes());
}

Status checkAxesOfStep(const proto::ParticlesManifest& particles, const proto::ParticleStepEntry& step) {
    if (step.axes().empty()) return success();
    const auto sameName = [](const proto::Axis& a, const proto::Axis& b) { return a.name() == b.name(); };
    if (step.axes_size() != axesOfPlot ||
        !std::equal(step.axes().begin(), step.axes().end(), particles.axes().begin(), sameName))
        return corrupt("axes", "must be those of the plot, with the step's bounds");
    return checkAxes(step.axes());
}

Status checkStep(const FileNames& files, const proto::ParticleStepEntry& step) {
    if (!files.contains(step.file())) return corrupt("file", "is not among the dataset's files");
    if (!files.contains(step.digest())) return corrupt("digest", "is not among the dataset's files");
    if (!std::isfinite(step.time())) return corrupt("time", "must be finite");
    if (!(std::isfinite(step.total_weight()) && step.total_weight() >= 0.0)) {
        return corrupt("totalWeight", "must be finite and not negative");
    }
    const auto& histogram = step.density_histogram();
    if (histogram.size() != densityHistogramBins) {
        return corrupt("densityHistogram", fmt::format("must have {} bins", densityHistogramBins));
    }
    if (std::accumulate(histogram.begin(), histogram.end(), std::uint64_t{0}) != step.particles()) {
        return corrupt("densityHistogram", "does not add up to the step's particles");
    }
    return success();
}

Status checkParticles(const proto::ParticlesManifest& particles, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkAxesOfPlot(particles));
    const double least = particles.density_min();
    const double greatest = particles.density_max();
    if (!(least > 0.0 && least <= greatest && std::isfinite(greatest))) {
        return corrupt("densityMin",
                       "densities must be positive and finite, the least not above the greatest");
    }
    if (particles.volume_level() < 1 || particles.volume_level() > maxVolumeLevel) {
        return corrupt("volumeLevel", fmt::format("must be 1 to {}", maxVolumeLevel));
    }
    if (particles.max_level() > maxOctreeLevel) {
        return corrupt("maxLevel", fmt::format("must be 0 to {}", maxOctreeLevel));
    }
    if (particles.leaf_capacity() < 1) return corrupt("leafCapacity", "must be at least 1");
    MOTE_RETURN_IF_ERROR(checkColumns(particles));
    if (particles.steps_size() < 1 || particles.steps_size() > maxSteps) {
        return corrupt("steps", fmt::format("a dataset has 1 to {} steps", maxSteps));
    }
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto where = fmt::format("steps[{}]", i);
        MOTE_RETURN_IF_ERROR(checkStep(files, particles.steps(i)), where);
        MOTE_RETURN_IF_ERROR(checkAxesOfStep(particles, particles.steps(i)), where);
        MOTE_RETURN_IF_ERROR(checkStepColumns(particles, particles.steps(i), files), where);
    }
    return success();
}

Status checkParticles(const proto::Manifest& manifest, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkParticles(manifest.particles(), files), "particles");
    return success();
}

void verifyStep(DatasetVerifier& verifier, std::uint32_t step) {
    const auto& entry = verifier.manifest().particles().steps(static_cast<int>(step));
    const auto whole = verifier.files({entry.digest(), entry.file()});
    if (!whole) return;
    // The arrays too: they say which block of which array it is, and what no hash can say of the octree.
    const auto opened = MappedStep::open(verifier.directory(), verifier.manifest(), step);
    if (opened.ok()) {
        verifier.add((*opened)->verify(verifier.cancelled()));
    } else if (*whole) {  // what is not there, or not whole, is said once
        verifier.read(opened);
    }
}

void verifyColumns(DatasetVerifier& verifier, std::uint32_t step) {
    const auto& entry = verifier.manifest().particles().steps(static_cast<int>(step));
    if (entry.columns_file().empty()) return;
    const auto whole = verifier.files({entry.columns_digest(), entry.columns_file()});
    if (!whole) return;
    const auto opened = MappedColumns::open(verifier.directory(), verifier.manifest(), step);
    if (opened.ok()) {
        verifier.add((*opened)->verify(verifier.cancelled()));
    } else if (*whole) {
        verifier.read(opened);
    }
}

void verifyParticles(DatasetVerifier& verifier) {
    verifier.eachStep(verifier.manifest().particles().steps_size(), [&](std::uint32_t step) {
        verifyStep(verifier, step);
        verifyColumns(verifier, step);
    });
}

/// What the particles are, each with its column, and what the job had to say.
std::string describeParticles(const proto::ParticlesManifest& particles) {
    std::string text;
    const auto out = std::back_inserter(text);
    if (particles.live()) text += "live     more steps may come\n";
    if (!particles.species().empty()) fmt::format_to(out, "species  {}\n", particles.species());
    if (particles.mass() > 0.0) fmt::format_to(out, "mass     {:.10g} eV/c^2\n", particles.mass());
    if (particles.particle_charge() != 0.0)
        fmt::format_to(out, "charge   {:.10g} C of one particle\n", particles.particle_charge());
    const auto& unit = particles.weight_unit();
    fmt::format_to(out, "weights  {}\n",
                   unit == "1"   ? "count real particles"
                   : unit == "C" ? "are charges in C"
                                 : "of no known unit");
    fmt::format_to(out, "lost     {} those that the source marks as lost\n",
                   particles.lost_particles().empty() ? "without" : particles.lost_particles());
    for (int i = 0; i < particles.columns_size(); ++i) {
        const auto& column = particles.columns(i);
        double resolution = 0.0;
        for (const auto& step : particles.steps()) {
            if (i < step.column_resolution_size())
                resolution = std::max(resolution, step.column_resolution(i));
        }
        fmt::format_to(out, "column   {} from {:.6g} to {:.6g}", column.name(), column.min(), column.max());
        if (!column.unit().empty() && column.unit() != "1") fmt::format_to(out, " {}", column.unit());
        if (resolution > 0.0) fmt::format_to(out, ", in steps of at most {:.2g}", resolution);
        text += '\n';
    }
    if (particles.columns_size() > 0)
        fmt::format_to(out, "ids      {}\n", particles.ids() ? "the source's own" : "none");
    for (const auto& note : particles.notes()) fmt::format_to(out, "note     {}\n", note);
    return text;
}

std::string describeRun(const proto::Manifest& manifest) {
    const auto& particles = manifest.particles();
    std::string text;
    const auto out = std::back_inserter(text);
    for (const auto& input : manifest.request().particles().inputs()) {
        fmt::format_to(out, "input    {}\n", input);
    }
    for (int a = 0; a < axesOfPlot; ++a) {
        const auto& axis = particles.axes(a);
        fmt::format_to(out, "axis     {} from {:.6g} to {:.6g} {}\n", axis.name(), axis.min(), axis.max(),
                       axis.unit());
    }
    text += describeParticles(particles);
    const auto size = 1U << particles.volume_level();
    fmt::format_to(out, "volume   {0} x {0} x {0}\noctree   at most {1} particles a leaf, to level {2}\n",
                   size, particles.leaf_capacity(), particles.max_level());
    fmt::format_to(out, "density  {:.4g} to {:.4g}\n\n", particles.density_min(), particles.density_max());
    fmt::format_to(out, "{:>6} {:>10} {:>12} {:>12} {:>9} {:>9} {:>9} {:>12}\n", "step", "iteration",
                   "time/s", "particles", "lost", "invalid", "outside", "weight");
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto& step = particles.steps(i);
        fmt::format_to(out, "{:>6} {:>10} {:>12.5g} {:>12} {:>9} {:>9} {:>9} {:>12.5g}\n", i,
                       step.iteration(), step.time(), step.particles(), step.lost(), step.invalid(),
                       step.outside(), step.total_weight());
    }
    return text;
}

DatasetSummary summarizeParticles(const proto::Manifest& manifest) {
    const auto& steps = manifest.particles().steps();
    std::uint64_t particles = 0, lost = 0, invalid = 0, outside = 0;
    for (const auto& step : steps) {
        particles += step.particles();
        lost += step.lost();
        invalid += step.invalid();
        outside += step.outside();
    }
    return {fmt::format("{}, {} particles in leaves", stepsText(steps.size()), particles),
            {{"steps", static_cast<std::uint64_t>(steps.size())},
             {"particles", particles},
             {"lost", lost},
             {"invalid", invalid},
             {"outside", outside}}};
}

}  // namespace

const DatasetKind particlesKind{"particles",    &proto::Manifest::has_particles,
                                checkParticles, verifyParticles,
                                describeRun,    summarizeParticles};

}  // namespace mote::storage
