// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/dataset_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "protocol/base/most_recent.h"
#include "protocol/base/near_names.h"
#include "protocol/base/utf8.h"
#include "protocol/mote.pb.h"
#include "server/log.h"
#include "storage/manifest.h"
#include "storage/roots.h"

namespace mote::server {
namespace {

std::string withoutSuffix(const std::string& dataset) {
    const std::string_view suffix = storage::datasetSuffix;
    return dataset.ends_with(suffix) ? dataset.substr(0, dataset.size() - suffix.size()) : dataset;
}

/// Names the nearest of those that are there: "beam" is near "data/beam", too.
Error unknownDataset(const std::string& dataset,
                     const std::map<std::string, storage::Catalogue::Entry>& all) {
    std::vector<std::string_view> names;
    names.reserve(all.size());
    for (const auto& [name, entry] : all) names.push_back(name);
    std::string near = nearNames(dataset, names);
    for (const auto name : names) {
        if (near.empty() && name.ends_with("/" + dataset)) near = fmt::format("; near it: {}", name);
    }
    const std::string_view others = near.empty() ? "; the catalogue lists those that are" : "";
    return {ErrorCode::notFound, "dataset",
            toUtf8(fmt::format("there is no dataset \"{}\" here{}{}", dataset.substr(0, 200), near, others))};
}

/// The request for another plot of a dataset's run, as a client may submit it: of its columns, if it keeps
/// all that the run had; else the request that made it, whose inputs are relative to the folder that holds
/// the dataset. The result names inputs "ROOT/PATH" and has no output. Nothing if an input is no longer
/// there or lies beneath no root, or if the request has no inputs.
std::optional<proto::JobRequest> replotOf(const storage::Catalogue::Entry& entry,
                                          const storage::Roots& roots) {
    const auto& request = entry.manifest->request();
    if (!request.has_particles() || request.particles().inputs().empty()) return std::nullopt;
    proto::JobRequest replot = request;
    replot.clear_output();
    auto& job = *replot.mutable_particles();
    const auto self = roots.nameOf(entry.directory.path());
    if (self && !entry.manifest->particles().columns().empty() && job.columns().empty()) {
        job.clear_inputs();
        job.add_inputs(*self);
        // The dataset settles what these chose.
        job.clear_format();
        job.clear_species();
        job.clear_steps();
        job.clear_impact();
        job.clear_lost();
        return replot;
    }
    for (auto& input : *job.mutable_inputs()) {
        const auto name = roots.nameOf((entry.directory.path().parent_path() / input).lexically_normal());
        if (!name || !roots.resolveExisting(*name).ok()) return std::nullopt;
        input = *name;
    }
    return replot;
}

}  // namespace

DatasetService::DatasetService(storage::Roots roots, std::function<void()> changed, std::uint64_t memory,
                               std::function<void()> arrived)
    : catalogue_(std::move(roots)),
      changed_(std::move(changed)),
      known_(std::make_shared<Known>()),
      budget_(std::make_shared<storage::BlockBudget>(memory)),
      steps_(budget_, std::thread::hardware_concurrency(), arrived),
      residency_(budget_, std::min<unsigned>(std::thread::hardware_concurrency(), stepsAhead),
                 std::move(arrived)) {
    thread_ = std::thread([this] { run(); });
}

DatasetService::~DatasetService() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void DatasetService::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [this] { return stopping_ || !work_.empty(); });
        if (stopping_) return;
        const auto work = std::move(work_.front());
        work_.pop_front();
        lock.unlock();
        work();
        lock.lock();
    }
}

void DatasetService::enqueue(std::function<void()> work) {
    {
        const std::lock_guard lock(mutex_);
        work_.push_back(std::move(work));
    }
    wake_.notify_one();
}

void DatasetService::look() {
    const auto begun = std::chrono::steady_clock::now();
    const bool changed = catalogue_.refresh();
    lookTime_ = std::chrono::steady_clock::now() - begun;
    if (!changed) return;
    auto known = std::make_shared<Known>();
    const auto summary = catalogue_.summary();
    for (const auto& entry : summary.datasets()) {
        // A name that is not UTF-8 cannot stand in a message.
        if (isUtf8(entry.name()) && isUtf8(entry.title())) *known->summary.add_datasets() = entry;
    }
    for (const auto& entry : catalogue_.entries()) known->entries.emplace(entry.name, entry);
    {
        const std::lock_guard lock(mutex_);
        known_ = std::move(known);
    }
    changed_();
}

/// Every broken dataset is said once, not at every look.
void DatasetService::report() {
    std::set<std::string> errors;
    for (const auto& error : catalogue_.errors()) errors.insert(error.toString());
    for (const auto& text : errors) {
        if (!reported_.contains(text)) log::warn("left out of the catalogue: {}", toLogText(text));
    }
    reported_ = std::move(errors);
}

void DatasetService::rescan() {
    {
        const std::lock_guard lock(mutex_);
        if (rescanWaits_) return;
        work_.push_back([this] {
            {
                const std::lock_guard begun(mutex_);
                rescanWaits_ = false;
            }
            look();
            report();
        });
        rescanWaits_ = true;
    }
    wake_.notify_one();
}

void DatasetService::rescan(Answered<Status> answered) {
    rescan();
    enqueue([answered = std::move(answered)] { answered(success()); });
}

std::shared_ptr<const DatasetService::Known> DatasetService::known() const {
    const std::lock_guard lock(mutex_);
    return known_;
}

std::shared_ptr<const proto::Catalogue> DatasetService::catalogue() const {
    const auto all = known();
    return {all, &all->summary};
}

bool DatasetService::contains(const std::string& dataset) const {
    return known()->entries.contains(withoutSuffix(dataset));
}

void DatasetService::describe(std::string dataset, Answered<Result<proto::Description>> answered) {
    if (!contains(dataset)) rescan();
    enqueue([this, dataset = std::move(dataset), answered = std::move(answered)] {
        answered(describeKnown(dataset));
    });
}

Result<storage::Catalogue::Entry> DatasetService::dataset(const std::string& name) {
    const auto all = known();
    const auto found = all->entries.find(withoutSuffix(name));
    if (found == all->entries.end()) return unknownDataset(name, all->entries);
    return found->second;
}

Result<proto::Description> DatasetService::describeKnown(const std::string& name) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, dataset(name));
    proto::Description description;
    description.set_dataset(entry.name);
    *description.mutable_manifest() = *entry.manifest;
    auto replot = replotOf(entry, catalogue_.roots());
    if (replot) *description.mutable_replot() = *std::move(replot);
    return description;
}

Result<proto::Loaded> DatasetService::loaded(const std::string& dataset) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, this->dataset(dataset));
    const auto steps = entry.manifest->has_particles() ? steps_.loaded(entry) : residency_.loadedSteps(entry);
    proto::Loaded loaded;
    loaded.set_dataset(entry.name);
    loaded.mutable_steps()->Add(steps.begin(), steps.end());
    return loaded;
}

Result<std::shared_ptr<const storage::ParticleStep>> DatasetService::step(const std::string& dataset,
                                                                          std::uint32_t index) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, this->dataset(dataset));
    if (!entry.manifest->has_particles()) {
        return Error{ErrorCode::invalidArgument, "dataset",
                     fmt::format("\"{}\" is of kind \"{}\", not particles", dataset, entry.manifest->kind())};
    }
    MOTE_ASSIGN_OR_RETURN(auto step, steps_.step(entry, index));
    return std::shared_ptr<const storage::ParticleStep>(std::move(step));
}

Result<std::shared_ptr<const storage::RunSteps>> DatasetService::run(const std::string& dataset) {
    constexpr std::size_t kept = 8;
    MOTE_ASSIGN_OR_RETURN(const auto entry, this->dataset(dataset));
    if (!entry.manifest->has_particles()) {
        return Error{ErrorCode::invalidArgument, "dataset",
                     fmt::format("holds no particles; it is of kind \"{}\"", entry.manifest->kind())};
    }
    const std::lock_guard lock(mutex_);
    const auto& found = mostRecent(
        runs_, kept, [&](const OpenRun& run) { return run.manifest == entry.manifest; },
        [&] {
            return OpenRun{entry.manifest, std::make_shared<const storage::DatasetSteps>(
                                               entry.directory, entry.manifest, budget_)};
        });
    return std::shared_ptr<const storage::RunSteps>(found.steps);
}

bool DatasetService::want(const storage::ParticleStep& step, const storage::StepNeed& need) {
    return steps_.want(step, need);
}

}  // namespace mote::server
