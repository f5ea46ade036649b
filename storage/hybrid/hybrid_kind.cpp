// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "storage/dataset_kind.h"
#include "storage/files/packed_file.h"
#include "storage/hybrid/check_hybrid.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status check(const proto::Manifest& manifest, const FileNames& files) {
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

void verify(DatasetVerifier& verifier) {
    verifier.eachStep(verifier.manifest().hybrid().steps_size(),
                      [&](std::uint32_t step) { verifyStep(verifier, step); });
}

std::string sizeText(const google::protobuf::RepeatedField<std::uint32_t>& size) {
    return fmt::format("{} x {} x {}", size.at(0), size.at(1), size.at(2));
}

std::string describe(const proto::Manifest& manifest) {
    const auto& hybrid = manifest.hybrid();
    std::string text;
    const auto out = std::back_inserter(text);
    for (const auto& input : manifest.request().volume().inputs()) {
        fmt::format_to(out, "input    {}\n", input);
    }
    fmt::format_to(out, "source   {} of {}, values from {:.6g} to {:.6g}{}{}\n",
                   sizeText(hybrid.source_size()), hybrid.scalar_type(), hybrid.value_min(),
                   hybrid.value_max(), hybrid.value_unit().empty() ? "" : " ", hybrid.value_unit());
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

DatasetSummary summarize(const proto::Manifest& manifest) {
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

const DatasetKind hybridKind{"hybrid", &proto::Manifest::has_hybrid, check, verify, describe, summarize};

}  // namespace mote::storage
