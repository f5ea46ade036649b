// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>

#include "protocol/quantity/plot_axes.h"
#include "storage/dataset_kind.h"
#include "storage/manifest.h"
#include "storage/particles/columns_check.h"
#include "storage/particles/mapped_columns.h"
#include "storage/particles/mapped_step.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status checkAxes(const proto::ParticlesManifest& particles) {
    if (particles.axes_size() != axesOfPlot && !boundsOfSteps(particles))
        return corrupt("axes",
                       "a particle plot has three axes, and three for each step where bounds are theirs");
    for (int i = 0; i < particles.axes_size(); ++i) {
        const auto& axis = particles.axes(i);
        if (axis.name().empty()) return corrupt(fmt::format("axes[{}].name", i), "is missing");
        if (!std::isfinite(axis.max() - axis.min()) || !(axis.min() < axis.max())) {
            return corrupt(fmt::format("axes[{}]", i), "the bounds must be finite and min below max");
        }
    }
    return success();
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
    MOTE_RETURN_IF_ERROR(checkAxes(particles));
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
        fmt::format_to(out, "column   {} from {:.6g} to {:.6g} {}", column.name(), column.min(), column.max(),
                       column.unit());
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
