// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/h5part/h5part_source.h"

#include <algorithm>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/h5part/h5part_step.h"
#include "preprocess/readers/openpmd/layout.h"

namespace mote::prep {
namespace {

constexpr std::string_view stepPattern = "Step#%T";

struct Place {
    std::filesystem::path file;
    std::string group;
};

class H5PartSource : public ParticleSource {
  public:
    explicit H5PartSource(double mass) : wantedMass_(mass) {}
    Status addFile(const std::filesystem::path& path, Progress& progress);
    Status finish(Progress& progress);

    std::string format() const override { return "h5part"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override { return has_[static_cast<std::size_t>(column)]; }
    double mass() const override { return mass_; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    Status addStep(const H5File& file, const std::filesystem::path& path, const std::string& group,
                   std::int64_t number);

    double wantedMass_, mass_ = 0.0;
    bool anyParticles_ = false, unitsGiven_ = true;
    bool has_[columnCount] = {};
    std::vector<SourceStep> steps_;
    std::vector<Place> places_;
    std::size_t openStep_ = static_cast<std::size_t>(-1);
    std::optional<H5PartStep> open_;
};

Status H5PartSource::addFile(const std::filesystem::path& path, Progress& progress) {
    const auto file = H5File::open(path);
    if (!file) return file.error();
    const auto names = file->children(file->root());
    if (!names) return names.error();
    bool any = false;
    for (const std::string& name : *names) {
        const auto number = matchIteration(stepPattern, name);
        if (!number) continue;
        if (progress.cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while the steps were listed"};
        MOTE_RETURN_IF_ERROR(addStep(*file, path, "/" + name, *number));
        any = true;
    }
    if (any) return success();
    return Error{ErrorCode::notFound, file->name(), "has no group Step#0, Step#1, ..."};
}

Status H5PartSource::addStep(const H5File& file, const std::filesystem::path& path, const std::string& group,
                             std::int64_t number) {
    const auto step = H5PartStep::open(file, group, wantedMass_);
    if (!step) return step.error();
    steps_.push_back({file.name(), number, step->time(), step->rows()});
    places_.push_back({path, group});
    if (mass_ == 0.0) mass_ = step->mass();
    unitsGiven_ = unitsGiven_ && step->unitsGiven();
    if (step->rows() == 0 && anyParticles_) return success();
    for (std::size_t i = 0; i < columnCount; ++i) {
        const bool here = step->has(static_cast<Column>(i));
        has_[i] = anyParticles_ ? has_[i] && here : here;
    }
    anyParticles_ = anyParticles_ || step->rows() > 0;
    return success();
}

Status H5PartSource::finish(Progress& progress) {
    std::vector<std::size_t> order(steps_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return steps_[a].iteration < steps_[b].iteration; });
    std::vector<SourceStep> steps;
    std::vector<Place> places;
    for (const std::size_t i : order) {
        steps.push_back(std::move(steps_[i]));
        places.push_back(std::move(places_[i]));
    }
    steps_ = std::move(steps);
    places_ = std::move(places);
    if (!unitsGiven_) progress.note("the H5Part file names no units: m, eV/c, s and C are taken");
    return success();
}

Status H5PartSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                          const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    if (openStep_ != step) {
        openStep_ = static_cast<std::size_t>(-1);
        open_.reset();
        const auto file = H5File::open(places_[step].file);
        if (!file) return file.error();
        auto opened = H5PartStep::open(*file, places_[step].group, wantedMass_);
        if (!opened) return opened.error();
        if (opened->rows() != steps_[step].particles) {
            return Error{ErrorCode::corrupt, steps_[step].file, "has changed since it was opened"};
        }
        open_ = std::move(*opened);
        openStep_ = step;
    }
    return open_->read(begin, count, wanted, chunk);
}

}  // namespace

bool looksLikeH5Part(const H5File& file) {
    const auto names = file.children(file.root());
    return names && std::any_of(names->begin(), names->end(), [](const std::string& name) {
               return matchIteration(stepPattern, name).has_value();
           });
}

Result<std::unique_ptr<ParticleSource>> openH5Part(const std::vector<std::filesystem::path>& files,
                                                   double mass, Progress& progress) {
    auto source = std::make_unique<H5PartSource>(mass);
    for (const std::filesystem::path& file : files) MOTE_RETURN_IF_ERROR(source->addFile(file, progress));
    MOTE_RETURN_IF_ERROR(source->finish(progress));
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
