// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "storage/dataset_kind.h"
#include "storage/files/packed_file.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status checkHybridKind(const proto::Manifest& manifest, const FileNames& files) {
    MOTE_RETURN_IF_ERROR(checkHybrid(manifest.hybrid(), files), "hybrid");
    return success();
}

void verifyStep(DatasetVerifier& verifier, std::uint32_t step) {
    const auto& directory = verifier.directory();
    const auto& manifest = verifier.manifest();
    const auto& entry = manifest.hybrid().steps(static_cast<int>(step));
    const std::filesystem::path file = entry.file();
    const bool packed = file.extension() == packedSuffix;
    if (packed ? verifier.files({entry.digest(), entry.file()}).value_or(false)
               : verifier.arrayFile(file.stem().string())) {
        verifier.read(HybridStep::open(directory, manifest, step));
    }
    if (verifier.wasCancelled() || entry.residual_file().empty()) return;
    verifier.read(readResidual(
        directory, manifest, step, [](const ResidualBrick&) {}, verifier.cancelled()));
}

void verifyHybrid(DatasetVerifier& verifier) {
    verifier.eachStep(verifier.manifest().hybrid().steps_size(),
                      [&](std::uint32_t step) { verifyStep(verifier, step); });
}

std::string sizeText(const google::protobuf::RepeatedField<std::uint32_t>& size) {
    return fmt::format("{} x {} x {}", size.at(0), size.at(1), size.at(2));
}

/// "right", of the axis of the world that a step of voxels goes along most; patients' worlds have words for
/// it.
std::string directionText(const proto::HybridManifest& hybrid, int axis) {
    const auto at = [&](int row) { return hybrid.index_to_world(4 * row + axis); };
    int most = 0;
    for (int row = 1; row < 3; ++row) most = std::abs(at(row)) > std::abs(at(most)) ? row : most;
    const bool forward = at(most) >= 0.0;
    const bool lps = hybrid.space() == "lps";
    if (hybrid.space().empty()) return fmt::format("{}{}", forward ? "+" : "-", "xyz"[most]);
    static constexpr std::array<std::array<const char*, 2>, 3> words{
        {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}}};
    const bool first = forward != (lps && most < 2);
    return words[static_cast<std::size_t>(most)][first ? 0 : 1];
}

/// Voxel size, place, orientation and space.
void describePlace(const proto::HybridManifest& hybrid, std::string& text) {
    const auto out = std::back_inserter(text);
    const auto unit = hybrid.world_unit().empty() ? "" : " " + hybrid.world_unit();
    std::array<std::string, 3> sizes, origin, axes;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = [&](int row, int column) { return hybrid.index_to_world(4 * row + column); };
        const auto i = static_cast<std::size_t>(axis);
        sizes[i] = fmt::format("{:.6g}", std::hypot(at(0, axis), at(1, axis), at(2, axis)));
        origin[i] = fmt::format("{:.10g}", at(axis, 3));
        axes[i] = fmt::format("{} ({:.6g}, {:.6g}, {:.6g})", directionText(hybrid, axis), at(0, axis),
                              at(1, axis), at(2, axis));
    }
    fmt::format_to(out, "voxels   {}{}{}\n", fmt::join(sizes, " x "), unit,
                   hybrid.world_unit().empty() ? ", of an unknown unit" : "");
    fmt::format_to(out, "origin   {}{}\n", fmt::join(origin, ", "), unit);
    fmt::format_to(out, "axes     {}\n", fmt::join(axes, ", "));
    fmt::format_to(out, "space    {}, the source's {}\n",
                   hybrid.space().empty() ? "as the source has it" : hybrid.space(),
                   hybrid.source_space().empty() ? "is not said" : hybrid.source_space());
    for (const auto& note : hybrid.notes()) fmt::format_to(out, "note     {}\n", note);
}

std::string describeHybrid(const proto::Manifest& manifest) {
    const auto& hybrid = manifest.hybrid();
    std::string text;
    const auto out = std::back_inserter(text);
    for (const auto& input : manifest.request().volume().inputs()) {
        fmt::format_to(out, "input    {}\n", input);
    }
    fmt::format_to(out, "source   {} of {}, values from {:.6g} to {:.6g}{}{}\n",
                   sizeText(hybrid.source_size()), hybrid.scalar_type(), hybrid.value_min(),
                   hybrid.value_max(), hybrid.value_unit().empty() ? "" : " ", hybrid.value_unit());
    describePlace(hybrid, text);
    fmt::format_to(out, "volume   {}, {} bits, {}\n", sizeText(hybrid.low_size()), hybrid.value_bits(),
                   hybrid.filter());
    fmt::format_to(out, "errors   on {}", sizeText(hybrid.error_size()));
    if (hybrid.point_bytes() > 0) fmt::format_to(out, ", as points of {} bytes", hybrid.point_bytes());
    fmt::format_to(out, "{}\n\n", hybrid.residual() ? ", as residuals" : "");
    fmt::format_to(out, "{:>6} {:>10} {:>12} {:>12} {:>12} {:>10} {:>9}\n", "step", "time", "threshold",
                   "points", "residuals", "in bricks", "invalid");
    for (int i = 0; i < hybrid.steps_size(); ++i) {
        const auto& step = hybrid.steps(i);
        fmt::format_to(out, "{:>6} {:>10.5g} {:>12.5g} {:>12} {:>12} {:>10} {:>9}\n", i, step.time(),
                       step.threshold(), step.points(), step.residual_samples(), step.residual_bricks(),
                       step.invalid());
    }
    return text;
}

DatasetSummary summarizeHybrid(const proto::Manifest& manifest) {
    const auto& steps = manifest.hybrid().steps();
    std::uint64_t points = 0, residuals = 0;
    for (const auto& step : steps) {
        points += step.points();
        residuals += step.residual_samples();
    }
    return {
        fmt::format("{}, {} points, {} residuals", stepsText(steps.size()), points, residuals),
        {{"steps", static_cast<std::uint64_t>(steps.size())}, {"points", points}, {"residuals", residuals}}};
}

}  // namespace

const DatasetKind hybridKind{
    "hybrid", &proto::Manifest::has_hybrid, checkHybridKind, verifyHybrid, describeHybrid, summarizeHybrid};

}  // namespace mote::storage
