// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/export/export_job.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "preprocess/draft_file.h"
#include "preprocess/openpmd/particle_file.h"
#include "preprocess/readers/known_species.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/step_range.h"
#include "storage/manifest.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/select_points.h"
#include "storage/storage_error.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t pointsAtOnce = std::uint64_t{1} << 16;  // that are looked at between two questions
constexpr std::size_t rowsAtOnce = std::size_t{1} << 18;        // that are gathered before they are written

/// Without which the file would be of no use to others.
constexpr std::array<std::string_view, 9> always{"x", "y", "z", "t", "px", "py", "pz", "weight", "lost"};

Error noColumns(const std::filesystem::path& dataset) {
    return notFound(
        dataset.filename().string(),
        "was made without columns: make it again from its source (mote-prep particles) to have them");
}

/// The indices of the columns that are written, in the dataset's order.
Result<std::vector<std::size_t>> chosenColumns(const proto::ExportJob& job,
                                               const proto::ParticlesManifest& run) {
    const auto named = [&](const std::string& name) { return std::ranges::count(job.columns(), name) > 0; };
    std::vector<std::size_t> chosen;
    std::set<std::string> there{"id"};
    for (int i = 0; i < run.columns_size(); ++i) {
        const auto& name = run.columns(i).name();
        there.insert(name);
        if (job.columns().empty() || named(name) || std::ranges::count(always, name) > 0)
            chosen.push_back(static_cast<std::size_t>(i));
    }
    for (int i = 0; i < job.columns_size(); ++i) {
        if (!there.contains(job.columns(i)))
            return notFound(fmt::format("columns[{}]", i),
                            fmt::format("the dataset has no column \"{}\"", job.columns(i)));
    }
    return chosen;
}

/// The chosen points of a step, gathered into rows.
class StepRows {
  public:
    StepRows(const storage::ParticleColumns& from, const std::vector<std::size_t>& chosen, ParticleFile& file)
        : from_(from), chosen_(chosen), file_(file), columns_(chosen.size()) {}

    /// Points [begin, begin + count) of the mask. Throws StorageError.
    Status take(const storage::PointMask& mask, std::uint64_t begin, std::uint64_t count) {
        std::vector<std::uint64_t> places;  // within this part
        for (std::uint64_t i = 0; i < count; ++i) {
            if (mask.chosen(begin + i)) places.push_back(i);
        }
        if (places.empty()) return success();
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            values_.resize(count);
            from_.read(chosen_[i], begin, values_);
            for (const auto place : places) columns_[i].push_back(values_[place]);
        }
        if (from_.hasIds()) {
            const auto ids = from_.ids(begin, count);
            for (const auto place : places) ids_.push_back(ids[place]);
        }
        gathered_ += places.size();
        return gathered_ >= rowsAtOnce ? flush() : success();
    }

    Status flush() {
        MOTE_RETURN_IF_ERROR(file_.write(written_, gathered_, columns_, ids_));
        written_ += std::exchange(gathered_, 0);
        for (auto& column : columns_) column.clear();
        ids_.clear();
        return success();
    }

  private:
    const storage::ParticleColumns& from_;
    const std::vector<std::size_t>& chosen_;
    ParticleFile& file_;
    std::vector<std::vector<double>> columns_;
    std::vector<double> values_;  ///< of one column, of a part
    std::vector<std::uint64_t> ids_;
    std::size_t gathered_ = 0;
    std::uint64_t written_ = 0;
};

class Export {
  public:
    Export(const proto::ExportJob& job, std::filesystem::path dataset,
           std::shared_ptr<const proto::Manifest> manifest, Progress& progress)
        : job_(job), dataset_(std::move(dataset)), run_(dataset_, std::move(manifest)), progress_(progress) {}

    /// Finds out what is to be written. Errors: the request's.
    Status prepare() {
        const auto& run = run_.manifest();
        if (run.columns_size() == 0) return noColumns(dataset_);
        MOTE_ASSIGN_OR_RETURN(steps_, selectSteps(job_.steps(), static_cast<std::size_t>(run.steps_size())));
        const auto selection = parseSelection(job_.select());
        if (!selection.ok()) return selection.error().within("select");
        selection_ = *selection;
        MOTE_ASSIGN_OR_RETURN(columns_, chosenColumns(job_, run));
        std::set<std::int64_t> numbers;
        for (const auto step : steps_) numbers.insert(run.steps(static_cast<int>(step)).iteration());
        numbered_ = numbers.size() == steps_.size();
        findSpecies();
        if (run.lost_particles() == "with" && !hasColumn("lost")) {
            progress_.note(
                "which particles are lost is not in the dataset, which is of an earlier version: the file "
                "has no "
                "particleStatus");
        }
        return success();
    }

    Status write(ParticleFile& file) {
        for (done_ = 0; done_ < steps_.size(); ++done_) MOTE_RETURN_IF_ERROR(writeStep(steps_[done_], file));
        return success();
    }

  private:
    bool hasColumn(std::string_view name) const {
        return std::ranges::count(run_.manifest().columns(), name, &proto::ColumnEntry::name) > 0;
    }

    /// What the dataset does not know is told by what it knows, and said.
    void findSpecies() {
        const auto& run = run_.manifest();
        species_ = {run.species(), run.mass(), run.particle_charge()};
        if (species_.name.empty()) {
            const auto found = speciesOf(run.mass(), run.particle_charge());
            if (found) species_.name = found->name;
            if (found && found->usual) {
                progress_.note(fmt::format(
                    "the dataset does not say what its particles are; \"{}\" is taken after their mass",
                    found->name));
            }
        }
        if (species_.charge == 0.0)
            species_.charge = speciesOf(species_.name).value_or(KnownSpecies()).charge;
        if (hasColumn("weight") && run.weight_unit().empty()) {
            progress_.note(
                "the dataset does not know whether its weights are counts or charges: they are written as "
                "\"weighting\", and no \"weight\"");
        }
    }

    FileStep describe(std::size_t index, std::uint64_t rows) const {
        const auto& run = run_.manifest();
        const auto& entry = run.steps(static_cast<int>(index));
        FileStep step;
        // Files of a series may all call their step the same.
        step.iteration = numbered_ ? entry.iteration() : static_cast<std::int64_t>(index);
        step.time = entry.time();
        step.rows = rows;
        for (const auto column : columns_) {
            const auto& known = run.columns(static_cast<int>(column));
            step.columns.push_back({known.name(), known.unit()});
        }
        step.ids = run.ids();
        step.mass = run.mass();
        step.weightUnit = run.weight_unit();
        step.species = species_.name;
        step.charge = species_.charge;
        step.lost = run.lost_particles() == "only";
        if (run.lost_particles() == "with") step.lost.reset();
        return step;
    }

    Status writeStep(std::size_t index, ParticleFile& file) {
        report(0.0, "selecting particles");
        const auto step = static_cast<std::uint32_t>(index);
        MOTE_ASSIGN_OR_RETURN(const auto mask, storage::selectPoints(selection_, run_, step,
                                                                     [&] { return progress_.cancelled(); }));
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run_.step(step));
        if (!numbers.columns) return noColumns(dataset_);
        MOTE_RETURN_IF_ERROR(file.begin(describe(index, mask.count())));
        StepRows rows(*numbers.columns, columns_, file);
        for (std::uint64_t begin = 0; begin < mask.size(); begin += pointsAtOnce) {
            if (progress_.cancelled()) return wasCancelled();
            report(static_cast<double>(begin) / static_cast<double>(mask.size()), "writing particles");
            MOTE_RETURN_IF_ERROR(rows.take(mask, begin, std::min(pointsAtOnce, mask.size() - begin)));
        }
        numbers.columns->check();
        return rows.flush();
    }

    void report(double share, const char* what) {
        progress_.report((static_cast<double>(done_) + share) / static_cast<double>(steps_.size()),
                         fmt::format("{} of step {}", what, steps_[done_]));
    }

    const proto::ExportJob& job_;
    const std::filesystem::path dataset_;
    const storage::DatasetSteps run_;
    Progress& progress_;
    std::vector<std::size_t> steps_;
    std::size_t done_ = 0;  // of these
    Selection selection_;
    std::vector<std::size_t> columns_;
    bool numbered_ = true;  // steps have numbers of their own
    KnownSpecies species_;
};

Status run(const proto::ExportJob& job, const std::filesystem::path& dataset,
           const std::filesystem::path& output, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto manifest, storage::readManifest(dataset));
    if (manifest.kind() != "particles") {
        return unsupported("dataset",
                           fmt::format("holds no particles: it is of kind \"{}\"", manifest.kind()));
    }
    Export exported(job, dataset, std::make_shared<const proto::Manifest>(std::move(manifest)), progress);
    MOTE_RETURN_IF_ERROR(exported.prepare());
    MOTE_ASSIGN_OR_RETURN(auto draft, DraftFile::create(output));
    MOTE_ASSIGN_OR_RETURN(auto file, ParticleFile::create(draft.path()));
    MOTE_RETURN_IF_ERROR(exported.write(file));
    MOTE_RETURN_IF_ERROR(file.close());
    progress.report(1.0, "done");
    return draft.publish();
}

}  // namespace

Status exportParticles(const proto::ExportJob& job, const std::filesystem::path& dataset,
                       const std::filesystem::path& output, const JobResources& resources,
                       Progress& progress) {
    tbb::task_arena arena(resources.threads > 0 ? resources.threads : tbb::task_arena::automatic);
    return arena.execute([&]() -> Status {
        try {
            return run(job, dataset, output, progress);
        } catch (const storage::StorageError& error) {
            return error.error();
        }
    });
}

}  // namespace mote::prep
