// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/damage/damaged_dataset.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/data/step_source.h"
#include "server/frames/picture_maker.h"
#include "server/render/cpu/cpu_device.h"
#include "storage/manifest.h"
#include "storage/numbers/dataset_steps.h"
#include "storage/numbers/histogram.h"
#include "storage/numbers/point_statistics.h"
#include "storage/particles/mapped_step.h"
#include "storage/storage_error.h"
#include "tests/support/dataset_content.h"
#include "tests/support/must.h"
#include "tests/support/view_text.h"

namespace mote::test {

std::string bytesOfFile(const std::filesystem::path& path) {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return std::move(bytes).str();
}

void writeFile(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

namespace {

using storage::Catalogue;

/// A density that lines are drawn from is as large whatever the dataset is.
constexpr std::uint64_t mostLoadedBytes = 4 * mostSampleBytes;

/// The datasets of a folder, of which all that is asked for is read at once, by whoever asks.
class FolderSource final : public server::StepSource {
  public:
    explicit FolderSource(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Forgets what it knew.
    void beginAnew(bool bounded) {
        entries_.clear();
        budget_ = bounded ? std::make_shared<storage::BlockBudget>(mostSampleBytes) : nullptr;
    }

    Result<Catalogue::Entry> dataset(const std::string& name) override {
        auto& entry = entries_[name];
        if (entry.manifest == nullptr) {
            const auto directory = folder_ / (name + ".mote");
            MOTE_ASSIGN_OR_RETURN(auto manifest, storage::readManifest(directory));
            entry = {name, directory, std::make_shared<const proto::Manifest>(std::move(manifest))};
        }
        return entry;
    }
    Result<std::shared_ptr<const storage::ParticleStep>> step(const std::string& name,
                                                              std::uint32_t index) override {
        MOTE_ASSIGN_OR_RETURN(const auto entry, dataset(name));
        MOTE_ASSIGN_OR_RETURN(auto opened,
                              storage::MappedStep::open(entry.directory, *entry.manifest, index, budget_));
        return std::shared_ptr<const storage::ParticleStep>(std::move(opened));
    }
    Result<server::Resident> resident(const server::AnyLoadable& what) override {
        if (what.expected(what.step) > mostLoadedBytes)
            return Error{ErrorCode::resourceExhausted, "dataset", "takes too much memory"};
        return what.load(what.step, [] { return false; });
    }
    std::shared_ptr<storage::BlockBudget> budget() const { return budget_; }
    void beginPicture() override {
        if (budget_) budget_->beginGeneration();
    }

  private:
    const std::filesystem::path folder_;
    std::map<std::string, Catalogue::Entry> entries_;
    std::shared_ptr<storage::BlockBudget> budget_;
};

std::vector<View> viewsOf(const SampleDataset& sample) {
    std::vector<View> views;
    for (const auto& layer : sample.layers)
        views.push_back(viewOf("{'width': 32, 'height': 32, 'layers': [" + layer + "]}"));
    return views;
}

std::unique_ptr<render::Device> smallDevice() {
    return std::make_unique<render::CpuDevice>(render::CpuOptions{.threads = 1});
}

void countOne(const storage::StepNumbers& step, bool unweighted) {
    must(storage::countHistogram({{"x", 50, 0.0, 1.0}}, unweighted, step, nullptr, {}));
}

void countTwo(const storage::StepNumbers& step, bool unweighted) {
    must(
        storage::countHistogram({{"x", 20, 0.0, 1.0}, {"px", 30, -1.0, 1.0}}, unweighted, step, nullptr, {}));
}

void takeStatistics(const storage::StepNumbers& step, bool sliced) {
    const auto slices = sliced ? std::optional(storage::SlicesWanted{"z", 5}) : std::nullopt;
    must(storage::pointStatistics(step, {}, nullptr, slices, storage::Passes::percentilesToo, {}));
}

using Count = void (*)(const storage::StepNumbers& step, bool way);
constexpr Count counts[] = {countOne, countTwo, takeStatistics};

}  // namespace

class DatasetAsker::Impl {
  public:
    Impl(const SampleDataset& sample, const std::filesystem::path& folder)
        : views_(viewsOf(sample)), source_(folder), counted_(sample.counted) {}

    std::size_t questions() const { return views_.size() + (counted_ ? std::size(counts) : 0); }

    void ask(std::size_t question, Random& random) {
        source_.beginAnew(random.chance(0.5));
        if (question >= views_.size()) return count(counts[question - views_.size()], random);
        draw(views_[question], random.chance(0.3) ? server::Stage::quick : server::Stage::exact);
    }

  private:
    void draw(const View& view, server::Stage stage) {
        auto task = std::make_shared<server::ViewTask>();
        task->view = view;
        {
            server::PictureHistory history{server::QualityController(30.0)};
            const auto made = maker_.make({.session = 1, .task = task, .stage = stage}, history);
            if (!made.ok()) throw storage::StorageError(made.error());
            if (!made->picture) throw std::logic_error("a picture waits for data that are there");
        }
        maker_.trim();
    }

    void count(Count what, Random& random) {
        const auto entry = must(source_.dataset("sample"));
        if (!entry.manifest->has_particles())
            throw storage::StorageError(Error{ErrorCode::invalidArgument, "dataset", "holds no particles"});
        const storage::DatasetSteps run(entry.directory, entry.manifest, source_.budget());
        const auto step = must(run.step(0));
        if (!step.columns) throw storage::StorageError(storage::withoutColumns("dataset"));
        what(step, random.chance(0.5));
    }

    const std::vector<View> views_;
    FolderSource source_;
    const bool counted_;
    server::PictureMaker maker_{smallDevice, source_, render::DeviceCosts{}};
};

DatasetAsker::DatasetAsker(const SampleDataset& sample, const std::filesystem::path& folder)
    : impl_(std::make_unique<Impl>(sample, folder)) {}

DatasetAsker::~DatasetAsker() = default;

std::size_t DatasetAsker::questions() const {
    return impl_->questions();
}

void DatasetAsker::ask(std::size_t question, Random& random) {
    impl_->ask(question, random);
}

namespace {

constexpr std::uint64_t bytesOfAFile = 24, cutsOfAFile = 12;

struct Places {
    std::uint64_t first, stride;
};

/// About so many of a file, beginning anywhere.
Places someOf(std::uint64_t size, std::uint64_t wanted, Random& random) {
    const auto stride = std::max<std::uint64_t>(1, size / wanted);
    return {random.below(stride), stride};
}

void addBits(const std::string& file, std::uint64_t size, Places places, std::vector<Change>& changes) {
    for (auto at = places.first; at < size; at += places.stride) {
        for (unsigned bit = 0; bit < 8; ++bit) changes.push_back({file, at, bit});
    }
}

void addCuts(const std::string& file, std::uint64_t size, Places places, std::vector<Change>& changes) {
    for (auto at = places.first; at < size; at += places.stride) changes.push_back({file, at, std::nullopt});
}

DatasetFiles filesOf(const std::filesystem::path& dataset) {
    DatasetFiles files;
    for (const auto& entry : std::filesystem::directory_iterator(dataset))
        files[entry.path().filename()] = bytesOfFile(entry.path());
    return files;
}

/// Calls what(), and keeps the most seconds that it ever took. False if it threw the error of damage,
/// which tells what is wrong.
template <class What>
bool goesWell(const What& what, double& slowest) {
    using Clock = std::chrono::steady_clock;
    const auto begun = Clock::now();
    bool well = true;
    try {
        what();
    } catch (const storage::StorageError& error) {
        EXPECT_FALSE(error.error().message.empty());
        well = false;
    }
    slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - begun).count());
    return well;
}

std::filesystem::path madeIn(const std::filesystem::path& folder, const SampleDataset& sample) {
    sample.write(folder / "sample.mote");
    writeCompanions(folder);
    return folder;
}

}  // namespace

std::string Change::text() const {
    return bit ? fmt::format("{}: bit {} of byte {}", file, *bit, at)
               : fmt::format("{} cut off at byte {}", file, at);
}

std::vector<Change> changesOf(const DatasetFiles& files, std::uint64_t stride) {
    std::vector<Change> changes;
    for (const auto& [name, bytes] : files) {
        addBits(name, bytes.size(), {0, stride}, changes);
        addCuts(name, bytes.size(), {0, stride}, changes);
    }
    return changes;
}

std::vector<Change> someChangesOf(const DatasetFiles& files, Random& random) {
    std::vector<Change> changes;
    for (const auto& [name, bytes] : files) {
        addBits(name, bytes.size(), someOf(bytes.size(), bytesOfAFile, random), changes);
        addCuts(name, bytes.size(), someOf(bytes.size(), cutsOfAFile, random), changes);
    }
    return changes;
}

DamagedDataset::DamagedDataset(const SampleDataset& sample) : asker_(sample, madeIn(folder_.path(), sample)) {
    files_ = filesOf(dataset_);
    content_ = contentOfDataset(dataset_);
}

void DamagedDataset::apply(const Change& change) const {
    auto bytes = files_.at(change.file);
    if (change.bit) {
        bytes[change.at] =
            static_cast<char>(static_cast<unsigned char>(bytes[change.at]) ^ (1U << *change.bit));
    } else {
        bytes.resize(change.at);
    }
    writeFile(dataset_ / change.file, bytes);
}

void DamagedDataset::restore() const {
    for (const auto& [name, bytes] : files_) writeFile(dataset_ / name, bytes);
}

Outcome DamagedDataset::load() {
    ++tally_.tried;
    std::string loaded;
    if (!goesWell([&] { loaded = contentOfDataset(dataset_); }, tally_.slowestRead)) {
        ++tally_.errors;
        return Outcome::error;
    }
    const bool same = loaded == content_;
    ++(same ? tally_.same : tally_.other);
    return same ? Outcome::same : Outcome::other;
}

void DamagedDataset::ask(Random& random) {
    ++tally_.asked;
    const auto question = random.below(asker_.questions());
    if (goesWell([&] { asker_.ask(question, random); }, tally_.slowestAnswer)) ++tally_.answers;
}

void DamagedDataset::loadAndAsk(Random& random) {
    const auto outcome = load();
    if (outcome == Outcome::other || (outcome == Outcome::error && random.below(8) == 0)) ask(random);
}

long mostMemory() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss >> 10;
}

}  // namespace mote::test
