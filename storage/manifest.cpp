// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/manifest.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "protocol/scene/json.h"
#include "storage/files/read_file.h"
#include "storage/files/write_file.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/image/image_limits.h"

namespace mote::storage {
namespace {

Error corrupt(std::string where, std::string message) {
    return {ErrorCode::corrupt, std::move(where), std::move(message)};
}

/// A file directly in the dataset: no name leads out of it.
bool isPlainName(const std::string& name) {
    return !name.empty() && name.size() <= 255 && name != "." && name != ".." && name != manifestName &&
           name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
}

bool isHex32(const std::string& text) {
    return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

using Names = std::set<std::string_view>;

Status checkFiles(const proto::Manifest& manifest, Names& names) {
    for (int i = 0; i < manifest.files_size(); ++i) {
        const auto& file = manifest.files(i);
        const auto where = fmt::format("files[{}]", i);
        if (!isPlainName(file.name()))
            return corrupt(where + ".name", "is not the name of a file in the dataset");
        if (!names.insert(file.name()).second) return corrupt(where + ".name", "names a file twice");
        if (!isHex32(file.xxh3_128())) return corrupt(where + ".xxh3128", "must be 32 hexadecimal digits");
    }
    return success();
}

Status checkAxes(const proto::ParticlesManifest& particles) {
    if (particles.axes_size() != 3) return corrupt("axes", "a particle plot has three axes");
    for (int i = 0; i < 3; ++i) {
        const auto& axis = particles.axes(i);
        if (axis.name().empty()) return corrupt(fmt::format("axes[{}].name", i), "is missing");
        if (!std::isfinite(axis.max() - axis.min()) || !(axis.min() < axis.max())) {
            return corrupt(fmt::format("axes[{}]", i), "the bounds must be finite and min below max");
        }
    }
    return success();
}

Status checkStep(const Names& files, const proto::ParticleStepEntry& step) {
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

Status checkParticles(const Names& files, const proto::ParticlesManifest& particles) {
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
    if (particles.steps_size() < 1 || particles.steps_size() > maxSteps) {
        return corrupt("steps", fmt::format("a dataset has 1 to {} steps", maxSteps));
    }
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto checked = checkStep(files, particles.steps(i));
        if (!checked.ok()) return checked.error().within(fmt::format("steps[{}]", i));
    }
    return success();
}

Status checkStipple(const Names& files, const proto::StippleManifest& stipple) {
    if (!files.contains("hierarchy.h5") || !files.contains("hierarchy.digest")) {
        return corrupt("", "hierarchy.h5 and hierarchy.digest are not among the dataset's files");
    }
    if (stipple.domain() != proto::StippleManifest::PLANE &&
        stipple.domain() != proto::StippleManifest::SURFACE) {
        return corrupt("domain", "must be PLANE or SURFACE");
    }
    if (stipple.points() < 1 || stipple.points() > std::numeric_limits<std::uint32_t>::max()) {
        return corrupt("points", "must be 1 to 2^32 - 1");
    }
    if (stipple.locked() > stipple.points()) return corrupt("locked", "are more than the points");
    if (!(std::isfinite(stipple.area()) && stipple.area() > 0.0)) {
        return corrupt("area", "must be finite and positive");
    }
    if (stipple.rings() < 1 || stipple.rings() > 2) return corrupt("rings", "must be 1 or 2");
    if (!(stipple.relaxation() >= 1.0 && stipple.relaxation() < 2.0)) {
        return corrupt("relaxation", "must be 1 or more and below 2");
    }
    return success();
}

Status checkImage(const Names& files, const proto::ImageManifest& image) {
    if (!files.contains("image.h5") || !files.contains("image.digest")) {
        return corrupt("", "image.h5 and image.digest are not among the dataset's files");
    }
    const auto side = [](std::uint32_t pixels) { return pixels >= 1 && pixels <= maxImageSide; };
    const std::uint64_t pixels = std::uint64_t{image.width()} * image.height();
    if (side(image.width()) && side(image.height()) && pixels <= maxImagePixels) return success();
    return corrupt("width",
                   fmt::format("{} x {} pixels are none, or too many", image.width(), image.height()));
}

Status checkMesh(const Names& files, const proto::MeshManifest& mesh) {
    if (!files.contains("mesh.h5") || !files.contains("mesh.digest")) {
        return corrupt("", "mesh.h5 and mesh.digest are not among the dataset's files");
    }
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (mesh.vertices() < 3 || mesh.vertices() > most) return corrupt("vertices", "must be 3 to 2^32 - 1");
    if (mesh.triangles() < 1 || mesh.triangles() > most) return corrupt("triangles", "must be 1 to 2^32 - 1");
    if (mesh.edges() < 3 || mesh.edges() > 3 * mesh.triangles()) {
        return corrupt("edges", "must be at least 3, and no more than three a triangle");
    }
    if (mesh.bounds_min_size() != 3 || mesh.bounds_max_size() != 3) {
        return corrupt("boundsMin", "the bounds have three axes");
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(mesh.bounds_max(axis) - mesh.bounds_min(axis)) &&
            mesh.bounds_min(axis) <= mesh.bounds_max(axis)) {
            continue;
        }
        return corrupt("boundsMin", "the bounds must be finite, the least not above the greatest");
    }
    if (std::isfinite(mesh.area()) && mesh.area() > 0.0) return success();
    return corrupt("area", "must be finite and positive");
}

Status checkKind(const Names& files, const proto::Manifest& manifest) {
    const auto in = [](const char* field, const Status& checked) {
        return checked.ok() ? checked : Status(checked.error().within(field));
    };
    if (manifest.kind() == "particles" && manifest.has_particles()) {
        return in("particles", checkParticles(files, manifest.particles()));
    }
    if (manifest.kind() == "stipple" && manifest.has_stipple()) {
        const bool surface = manifest.stipple().domain() == proto::StippleManifest::SURFACE;
        if (surface) MOTE_RETURN_IF_ERROR(in("mesh", checkMesh(files, manifest.mesh())));
        return in("stipple", checkStipple(files, manifest.stipple()));
    }
    if (manifest.kind() == "image" && manifest.has_image()) {
        return in("image", checkImage(files, manifest.image()));
    }
    if (manifest.kind() == "mesh" && manifest.has_mesh()) {
        return in("mesh", checkMesh(files, manifest.mesh()));
    }
    if (manifest.kind() == "hybrid" && manifest.has_hybrid()) return in("hybrid", checkHybrid(manifest));
    return Error{ErrorCode::unsupported, "kind",
                 fmt::format("\"{}\" is not a kind of dataset that this version reads", manifest.kind())};
}

Error inFile(const std::filesystem::path& path, Error error) {
    error.where = path.string() + ": " + error.where;
    return error;
}

}  // namespace

Status checkManifest(const proto::Manifest& manifest) {
    if (manifest.format() > formatVersion) {
        return Error{ErrorCode::unsupported, "format",
                     fmt::format("is {}, from a later version of Mote than this one ({})", manifest.format(),
                                 formatVersion)};
    }
    if (manifest.format() != formatVersion) return corrupt("format", "is missing or wrong");
    Names files;
    MOTE_RETURN_IF_ERROR(checkFiles(manifest, files));
    return checkKind(files, manifest);
}

Result<proto::Manifest> readManifest(const std::filesystem::path& directory) {
    const auto path = directory / manifestName;
    const auto text = readWhole(path, manifestLimit);
    if (!text.ok()) return text.error();
    proto::Manifest manifest;
    const auto parsed = parseJson(*text, manifest, path.string());
    // A dataset's own file that is not what it must be is damage, not somebody's wrong argument.
    if (!parsed.ok()) return Error{ErrorCode::corrupt, parsed.error().where, parsed.error().message};
    const auto checked = checkManifest(manifest);
    if (!checked.ok()) return inFile(path, checked.error());
    return manifest;
}

Status writeManifest(const std::filesystem::path& directory, const proto::Manifest& manifest) {
    const auto path = directory / manifestName;
    const auto checked = checkManifest(manifest);
    if (!checked.ok()) return inFile(path, checked.error());
    const std::string text = toJson(manifest);
    if (text.size() > manifestLimit) {
        return Error{ErrorCode::resourceExhausted, path.string(), "would be larger than a manifest may be"};
    }
    return writeNewFile(path, text);
}

const proto::FileEntry* findFile(const proto::Manifest& manifest, const std::string& name) {
    for (const auto& file : manifest.files()) {
        if (file.name() == name) return &file;
    }
    return nullptr;
}

}  // namespace mote::storage
