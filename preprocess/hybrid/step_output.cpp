// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/step_output.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "preprocess/hybrid/point_output.h"
#include "storage/files/packed_file.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/residual_file.h"
#include "storage/hybrid/residual_writer.h"
#include "storage/particles/step_writer.h"

namespace mote::prep {
namespace {

/// The share of the step's time, measured, after which residuals are written.
constexpr double residualsBegin = 0.92;

using Scratches = std::vector<std::unique_ptr<storage::ScratchFile>>;

/// Everyone's, each told whose scratch file it lies in.
template <class T>
Result<std::vector<T>> shareParts(Communicator& ranks, const std::vector<T>& mine) {
    MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<T>(ranks, std::span<const T>(mine)));
    std::vector<T> parts;
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        for (auto part : all[rank]) {
            part.scratch = static_cast<std::uint32_t>(rank);
            parts.push_back(part);
        }
    }
    return parts;
}

class StepOutput {
  public:
    StepOutput(const StepTask& task, const StepContent& content, CollectedErrors all,
               proto::HybridStepEntry& entry)
        : task_(task), plan_(task.plan), content_(content), all_(std::move(all)), entry_(entry) {}

    Status write() {
        for (int rank = 0; rank < task_.ranks.size(); ++rank) {
            MOTE_ASSIGN_OR_RETURN(auto scratch, storage::ScratchFile::open(scratchPath(task_, rank)));
            scratches_.push_back(std::move(scratch));
        }
        MOTE_RETURN_IF_ERROR(writeArrays());
        if (!plan_.residual) return success();
        MOTE_RETURN_IF_ERROR(task_.report(residualsBegin, "writing residuals"));
        std::uint64_t samples = 0;
        std::uint64_t bricks = 0;
        for (const auto& part : all_.residuals) {
            samples += part.samples;
            bricks += part.bricks;
        }
        entry_.set_residual_samples(samples);
        entry_.set_residual_bricks(bricks);
        const auto name = storage::residualName(task_.step);
        MOTE_RETURN_IF_ERROR(
            storage::writeResidual(task_.directory / name, content_.coding, all_.residuals, scratches_));
        return pack(name, *entry_.mutable_residual_file());
    }

  private:
    Status writeArrays() {
        const PointPieces points{std::move(all_.points), scratches_, content_.selection.mostOfLeast};
        if (plan_.pointBytes > 0) entry_.set_points(points.size());
        const auto name = storage::stepName(task_.step);
        const auto file = storage::HybridStepWriter::create(
            task_.directory, name,
            {plan_.low, plan_.valueBits, plan_.pointBytes, plan_.error, entry_.points()});
        if (!file.ok()) return file.error();
        entry_.set_digest(name + ".digest");
        const auto normals = lowNormals(content_.low, gridToWorld(plan_, plan_.low));
        MOTE_RETURN_IF_ERROR(file->writeLow(content_.low.codes(), normals));
        const auto progress = [&] { return task_.report(StepTask::errorsEnd, "writing"); };
        if (plan_.pointBytes > 0) {
            MOTE_RETURN_IF_ERROR(writePoints(points, plan_.error, plan_.pointBytes, progress, *file));
        }
        MOTE_RETURN_IF_ERROR(file->finish());
        return pack(name + ".h5", *entry_.mutable_file());
    }

    /// `packed`: the name that the file has then.
    Status pack(const std::string& name, std::string& packed) const {
        packed = name + std::string(storage::packedSuffix);
        return storage::packFile(task_.directory / name);
    }

    const StepTask& task_;
    const VolumePlan& plan_;
    const StepContent& content_;
    CollectedErrors all_;
    proto::HybridStepEntry& entry_;
    Scratches scratches_;
};

}  // namespace

std::filesystem::path scratchPath(const StepTask& task, int rank) {
    return task.directory / fmt::format("scratch-{}", rank);
}

Status writeStep(const StepTask& task, const StepContent& content, const CollectedErrors& mine,
                 proto::HybridStepEntry& entry) {
    MOTE_ASSIGN_OR_RETURN(auto points, shareParts(task.ranks, mine.points));
    MOTE_ASSIGN_OR_RETURN(auto residuals, shareParts(task.ranks, mine.residuals));
    StepOutput output(task, content, {std::move(points), std::move(residuals)}, entry);
    return agree(task.ranks, task.ranks.first() ? output.write() : success());
}

}  // namespace mote::prep
