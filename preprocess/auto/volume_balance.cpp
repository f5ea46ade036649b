// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which form of a volume is the best for its bytes: some are made of a part of it, and measured.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <system_error>

#include "preprocess/auto/choice.h"
#include "preprocess/hybrid/volume_job.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/system_error.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t triedVoxels = std::uint64_t{1} << 23;
constexpr std::uint32_t fewestSlices = 16;

/// Slices from the middle of a volume.
class MiddleSource final : public VolumeSource {
  public:
    explicit MiddleSource(std::unique_ptr<VolumeSource> whole)
        : whole_(std::move(whole)), shape_(whole_->shape()) {
        const auto wanted = static_cast<std::uint32_t>(
            std::clamp<std::uint64_t>(triedVoxels / shape_.voxelsOfSlice(), fewestSlices, 1U << 16));
        shape_.nz = std::min(shape_.nz, wanted);
        first_ = (whole_->shape().nz - shape_.nz) / 2;
    }
    std::string format() const override { return whole_->format(); }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return whole_->sequential(); }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        return whole_->read(first_ + z0, first_ + z1, values);
    }

  private:
    std::unique_ptr<VolumeSource> whole_;
    VolumeShape shape_;
    std::uint32_t first_ = 0;
};

/// The folder of datasets that are only tried.
class TrialFolder {
  public:
    explicit TrialFolder(const fs::path& output)
        : path_(output.string() + fmt::format(".partial-trial-{}", ::getpid())) {}
    TrialFolder(const TrialFolder&) = delete;
    TrialFolder& operator=(const TrialFolder&) = delete;
    ~TrialFolder() {
        std::error_code code;
        fs::remove_all(path_, code);
    }
    Status create() const {
        std::error_code code;
        fs::create_directory(path_, code);
        return code ? Status(systemError(code.value(), path_.string(), "make the folder")) : success();
    }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

std::uint64_t bytesIn(const fs::path& folder) {
    std::uint64_t bytes = 0;
    std::error_code code;
    for (const auto& entry : fs::recursive_directory_iterator(folder, code)) {
        if (entry.is_regular_file(code)) bytes += entry.file_size(code);
    }
    return bytes;
}

/// A form of a volume, and how far its pictures are from the volume's: levels of 255, as measured with the
/// curve that a view has that says none (docs/AUTO.md).
struct Form {
    double threshold = 0.0;  ///< 0: exact
    double levels = 0.0;
};
// Half a level is what a picture's own rounding is wrong by; exact volumes take a quarter more time.
constexpr double roundingLevels = 0.5, exactTime = 1.25;
constexpr std::array<Form, 5> forms{{{0.0, 0.0}, {0.01, 14.0}, {0.02, 18.0}, {0.05, 32.0}, {0.1, 53.0}}};

struct Tried {
    Form form;
    std::uint64_t bytes = 0;

    double cost() const {
        return (form.levels + roundingLevels) * static_cast<double>(bytes) *
               (form.threshold == 0.0 ? exactTime : 1.0);
    }
};

std::uint32_t longestOf(const VolumeShape& shape) {
    return std::max({shape.nx, shape.ny, shape.nz});
}

/// A quarter of the samples along the longest axis, a power of two.
std::uint32_t lowFor(std::uint32_t longest) {
    return std::clamp(std::bit_floor(std::max(longest / 3, 1U)), std::min(longest, 32U), 128U);
}

/// `part`: the longest axis of what is made, a part of a volume whose longest axis has `longest` samples.
void ask(const Form& form, std::uint32_t longest, std::uint32_t part, proto::VolumeJob& job) {
    const bool exact = form.threshold == 0.0;
    job.set_low(exact ? part : std::max(1U, lowFor(longest) * part / longest));
    job.set_threshold(exact ? forms.back().threshold : form.threshold);
}

class Balance {
  public:
    Balance(const proto::VolumeJob& job, const fs::path& input, const JobResources& resources,
            Progress& progress)
        : job_(job), input_(input), resources_(resources), silent_(progress) {}

    Status tryAll(const fs::path& folder, std::uint32_t longest, bool exactFits) {
        for (const Form& form : forms) {
            if (form.threshold == 0.0 && !exactFits) continue;
            const auto output = folder / fmt::format("{}.mote", form.threshold);
            proto::JobRequest request;
            *request.mutable_volume() = job_;
            MOTE_ASSIGN_OR_RETURN(auto part, open());
            ask(form, longest, longestOf(part->shape()), *request.mutable_volume());
            const OpenVolume opened = [&](std::size_t) { return Result(std::move(part)); };
            MOTE_RETURN_IF_ERROR(runVolumeJob(request, opened, {input_}, output, resources_, silent_));
            tried_.push_back({form, bytesIn(output)});
        }
        return success();
    }
    const Tried& best() const {
        return *std::min_element(tried_.begin(), tried_.end(),
                                 [](const Tried& a, const Tried& b) { return a.cost() < b.cost(); });
    }
    /// Of the exact form, or of what is tried first.
    const Tried& first() const { return tried_.front(); }

  private:
    Result<std::unique_ptr<VolumeSource>> open() {
        MOTE_ASSIGN_OR_RETURN(const auto steps, volumeSteps(job_.source(), {input_}));
        MOTE_ASSIGN_OR_RETURN(auto whole, openVolumeSource(steps.front(), silent_));
        return std::unique_ptr<VolumeSource>(std::make_unique<MiddleSource>(std::move(whole)));
    }

    const proto::VolumeJob& job_;
    const fs::path& input_;
    const JobResources& resources_;
    SilentNotes silent_;
    std::vector<Tried> tried_;
};

std::string whyOf(const Tried& best, const Tried& exact) {
    const double share =
        static_cast<double>(exact.bytes) / static_cast<double>(std::max<std::uint64_t>(best.bytes, 1));
    if (best.form.threshold == 0.0)
        return "what the others leave out would be seen, and they do not save enough bytes for that";
    if (exact.form.threshold != 0.0)
        return "all its samples do not fit into a quarter of this machine's memory";
    return fmt::format(
        "a {:.0f}th of the bytes of all its samples, for pictures that are wrong by some {:.0f} "
        "levels of 255",
        share, best.form.levels);
}

}  // namespace

Status balanceVolume(const Found& volume, const fs::path& input, const fs::path& output,
                     const JobResources& resources, Progress& progress, AutoChoice& choice) {
    auto& job = *choice.request.mutable_volume();
    job.add_inputs(input.string());
    if (!volume.name.empty()) job.mutable_source()->set_field(volume.name);
    SilentNotes silent(progress);
    MOTE_ASSIGN_OR_RETURN(const auto steps, volumeSteps(job.source(), {input}));
    MOTE_ASSIGN_OR_RETURN(const auto source, openVolumeSource(steps.front(), silent));
    const VolumeShape shape = source->shape();
    // A value of at most two bytes and a normal of one.
    const bool exactFits = shape.voxels() * 3 <= memoryFor(resources.memory) / 4;
    TrialFolder folder(output);
    MOTE_RETURN_IF_ERROR(folder.create());
    progress.report(0.0, "trying forms of the volume");
    Balance balance(job, input, resources, progress);
    MOTE_RETURN_IF_ERROR(balance.tryAll(folder.path(), longestOf(shape), exactFits));
    const Tried& best = balance.best();
    const std::uint32_t longest = longestOf(shape);
    ask(best.form, longest, longest, job);
    const std::string form =
        best.form.threshold == 0.0
            ? fmt::format("all {} samples along its longest axis", longest)
            : fmt::format("{} samples, and residuals above {} of the range", job.low(), best.form.threshold);
    choice.reasons.push_back({"form", form, whyOf(best, balance.first())});
    choice.reasons.push_back({"style", "hybrid", "curve and colours follow its unit and histogram"});
    return success();
}

}  // namespace mote::prep
