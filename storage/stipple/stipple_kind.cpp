// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "storage/dataset_kind.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/verify.h"

namespace mote::storage {
namespace {

Status checkStipple(const proto::StippleManifest& stipple, const FileNames& files) {
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

/// The mesh of a surface lies beside the hierarchy.
Status checkStipple(const proto::Manifest& manifest, const FileNames& files) {
    if (manifest.stipple().domain() == proto::StippleManifest::SURFACE) {
        MOTE_RETURN_IF_ERROR(meshKind.check(manifest, files));
    }
    MOTE_RETURN_IF_ERROR(checkStipple(manifest.stipple(), files), "stipple");
    return success();
}

void verifyStipple(DatasetVerifier& verifier) {
    if (verifier.manifest().has_mesh()) meshKind.verify(verifier);
    if (!verifier.wasCancelled()) verifier.arrayFile(hierarchyName, readHierarchy);
}

std::string describeStipple(const proto::Manifest& manifest) {
    const auto& stipple = manifest.stipple();
    const bool plane = stipple.domain() == proto::StippleManifest::PLANE;
    const auto made =
        plane ? std::string() : fmt::format("mesh     {}\n", manifest.request().stipple().mesh());
    const auto hierarchy = fmt::format(
        "domain   {}, area {:.6g}\npoints   {}, {} of them locked\nmoves    {}, {:.1f} a point\n"
        "rings    {}, relaxation {:.3g}\nseed     {}\n",
        plane ? "periodic unit square" : "surface", stipple.area(), stipple.points(), stipple.locked(),
        stipple.moves(), static_cast<double>(stipple.moves()) / static_cast<double>(stipple.points()),
        stipple.rings(), stipple.relaxation(), stipple.seed());
    return made + hierarchy + (manifest.has_mesh() ? meshKind.describe(manifest) : "");
}

DatasetSummary summarizeStipple(const proto::Manifest& manifest) {
    const auto& stipple = manifest.stipple();
    auto summary = manifest.has_mesh() ? meshKind.summarize(manifest) : DatasetSummary{};
    summary.text = fmt::format("{} points, {} moves", stipple.points(), stipple.moves());
    summary.numbers.insert(
        summary.numbers.end(),
        {{"points", stipple.points()}, {"moves", stipple.moves()}, {"locked", stipple.locked()}});
    return summary;
}

}  // namespace

const DatasetKind stippleKind{
    "stipple", &proto::Manifest::has_stipple, checkStipple, verifyStipple, describeStipple, summarizeStipple};

}  // namespace mote::storage
