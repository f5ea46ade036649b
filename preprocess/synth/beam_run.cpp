// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/beam_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "preprocess/synth/channel_plan.h"
#include "preprocess/synth/openpmd_writer.h"
#include "preprocess/synth/tracker.h"
#include "protocol/scene/check.h"
#include "protocol/scene/error.h"
#include "protocol/scene/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/file_descriptor.h"

namespace mote::prep {
namespace {

/// An output file while it is made: "NAME.partial-PID" beside its final place, published by one
/// rename and removed in every other case. Move-only; one owner, one thread.
class DraftFile {
  public:
    /// An empty file beside `output`, which must not exist. Errors: alreadyExists, notFound (the folder),
    /// permissionDenied, resourceExhausted, internal.
    static Result<DraftFile> create(const std::filesystem::path& output);

    DraftFile(DraftFile&& other) noexcept;
    DraftFile& operator=(DraftFile&&) = delete;
    ~DraftFile();

    const std::filesystem::path& path() const { return path_; }

    /// Takes the disk space for `bytes` now, so that a full disk shows before the work and not after it.
    /// Where the file system cannot, it asks whether there is room. Errors: resourceExhausted, internal.
    Status reserve(std::uint64_t bytes) const;

    /// Puts the file on the disk and gives it its name. Errors: alreadyExists, resourceExhausted, internal.
    Status publish();

  private:
    DraftFile(std::filesystem::path output, std::filesystem::path path)
        : output_(std::move(output)), path_(std::move(path)) {}

    std::filesystem::path output_;
    std::filesystem::path path_;  ///< empty once published or moved from
};

namespace fs = std::filesystem;

Result<DraftFile> DraftFile::create(const fs::path& output) {
    std::error_code ignored;
    if (!output.has_filename()) {
        return Error{ErrorCode::invalidArgument, output.string(), "is no name for a file"};
    }
    if (fs::exists(fs::symlink_status(output, ignored))) {
        return Error{ErrorCode::alreadyExists, output.string(), "exists already and is never replaced"};
    }
    // A process that was killed may have left a file under our number: take the next name, touch nothing.
    for (int attempt = 0; attempt < 100; ++attempt) {
        fs::path path = output;
        path += fmt::format(".partial-{}", ::getpid());
        if (attempt > 0) path += fmt::format("-{}", attempt);
        const storage::FileDescriptor file(
            ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        if (file.valid()) return DraftFile(output, path);
        if (errno != EEXIST) return systemError(errno, output.string(), "cannot be made");
    }
    return Error{ErrorCode::alreadyExists, output.string(), "too many unfinished copies lie beside it"};
}

DraftFile::DraftFile(DraftFile&& other) noexcept
    : output_(std::move(other.output_)), path_(std::exchange(other.path_, {})) {}

DraftFile::~DraftFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

Status DraftFile::reserve(std::uint64_t bytes) const {
    const auto what =
        fmt::format("needs {:.1f} MB, but they cannot be had", static_cast<double>(bytes) / 1e6);
    const storage::FileDescriptor file(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, output_.string(), "cannot be opened");
    rlimit limit{};
    if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && bytes > limit.rlim_cur) {
        return systemError(EFBIG, output_.string(), what);
    }
    int result = 0;
    do {
        result = ::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes));
    } while (result != 0 && errno == EINTR);
    if (result == 0) return success();
    if (errno != EOPNOTSUPP && errno != ENOSYS) return systemError(errno, output_.string(), what);
    std::error_code code;
    const auto space = fs::space(path_, code);
    if (!code && space.available < bytes) return systemError(ENOSPC, output_.string(), what);
    return success();
}

Status DraftFile::publish() {
    MOTE_RETURN_IF_ERROR(storage::syncPath(path_));
    MOTE_RETURN_IF_ERROR(storage::publishByRename(path_, output_));
    path_.clear();
    return success();
}

/// Rows of one task: some milliseconds of work, so that a cancelled job stops at once.
constexpr std::size_t taskRows = 4096;

/// Carries one chunk of particles through the channel and writes it into every step.
class ChunkRunner {
  public:
    ChunkRunner(const ChannelPlan& plan, const BeamRun& run, OpenPmdWriter& writer, Progress& progress)
        : plan_(plan),
          run_(run),
          writer_(writer),
          progress_(progress),
          particles_(std::min<std::uint64_t>(run.chunkRows, run.particles)),
          columns_(particles_.size()) {}

    Status carry(std::uint64_t first, std::size_t rows) {
        for (std::size_t step = 0; step < plan_.dumps.size(); ++step) {
            if (!advance(first, rows, step)) {
                return Error{ErrorCode::cancelled, "", "the job was cancelled"};
            }
            MOTE_RETURN_IF_ERROR(writer_.write(step, first, rows, columns_));
            report(first, rows, step);
        }
        return success();
    }

  private:
    /// Advances from the dump before (or from nothing) to dump `step`, and into the file's units; false when
    /// cancelled.
    bool advance(std::uint64_t first, std::size_t rows, std::size_t step) {
        std::atomic<bool> stopped = false;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, (rows + taskRows - 1) / taskRows, 1),
                          [&](const tbb::blocked_range<std::size_t>& tasks) {
                              for (std::size_t task = tasks.begin(); task != tasks.end(); ++task) {
                                  if (stopped || progress_.cancelled()) return stopped.store(true);
                                  const std::size_t begin = task * taskRows;
                                  advanceRows(first, begin, std::min(begin + taskRows, rows), step);
                              }
                          });
        return !stopped;
    }

    void advanceRows(std::uint64_t first, std::size_t begin, std::size_t end, std::size_t step) {
        if (step == 0) startParticles(plan_, run_.seed, first, particles_, begin, end);
        trackParticles(plan_.dumps[step], particles_, begin, end);
        fillColumns(plan_, particles_, first, begin, end, columns_);
    }

    void report(std::uint64_t first, std::size_t rows, std::size_t step) const {
        // A step costs its slices, and about 20 more for writing it.
        const auto cost = [&](std::size_t s) {
            return static_cast<double>(plan_.dumps[s].slice) + 20.0 * static_cast<double>(s + 1);
        };
        const double within = cost(step) / cost(plan_.dumps.size() - 1) * static_cast<double>(rows);
        progress_.report((static_cast<double>(first) + within) / static_cast<double>(run_.particles),
                         fmt::format("particles up to {} of {}: step {} of {}", first + rows, run_.particles,
                                     step + 1, plan_.dumps.size()));
    }

    const ChannelPlan& plan_;
    const BeamRun& run_;
    OpenPmdWriter& writer_;
    Progress& progress_;
    ParticleArrays particles_;
    BeamColumns columns_;
};

constexpr std::uint64_t mostParticles = 100'000'000'000;
constexpr std::uint32_t mostSteps = 10'000;
constexpr double leastMismatch = 0.5, greatestMismatch = 2.5, defaultMismatch = 1.5;
/// Above this ratio of the core's axes the kick is off by more than 1e-4, and the model more than that.
constexpr double flattestSound = 6.0;

}  // namespace

Status writeBeamRun(const ChannelPlan& plan, const BeamRun& run, const std::filesystem::path& output,
                    Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto draft, DraftFile::create(output));
    MOTE_ASSIGN_OR_RETURN(auto writer, OpenPmdWriter::create(draft.path()));
    MOTE_RETURN_IF_ERROR(draft.reserve(OpenPmdWriter::fileBytes(plan, run.particles)));
    MOTE_RETURN_IF_ERROR(writer.layOut(plan, run.particles, run.seed));
    ChunkRunner runner(plan, run, writer, progress);
    for (std::uint64_t first = 0; first < run.particles; first += run.chunkRows) {
        MOTE_RETURN_IF_ERROR(
            runner.carry(first, std::min<std::uint64_t>(run.chunkRows, run.particles - first)));
    }
    MOTE_RETURN_IF_ERROR(writer.close());
    return draft.publish();
}

Status synthesizeBeam(const proto::SynthBeamJob& job, const std::filesystem::path& output,
                      Progress& progress) {
    if (job.particles() < 1 || job.particles() > mostParticles) {
        return Error{ErrorCode::invalidArgument, "synthBeam.particles", "must be 1 to 100000000000"};
    }
    if (job.steps() < 1 || job.steps() > mostSteps) {
        return Error{ErrorCode::invalidArgument, "synthBeam.steps", "must be 1 to 10000"};
    }
    MOTE_ASSIGN_OR_RETURN(const auto mismatch,
                          checkRange(job.has_mismatch() ? job.mismatch() : defaultMismatch, leastMismatch,
                                     greatestMismatch, "synthBeam.mismatch"));

    progress.report(0.0, "integrating the beam's envelope");
    MOTE_ASSIGN_OR_RETURN(const auto plan, planChannel(mismatched({}, mismatch), job.steps()));
    if (plan.flattest > flattestSound) {
        progress.note(fmt::format(
            "with this mismatch the core's axes come to differ by a factor of {:.0f}: the beam is "
            "for looking, its physics is rough",
            plan.flattest));
    }
    return writeBeamRun(plan, {job.particles(), job.seed()}, output, progress);
}

}  // namespace mote::prep
