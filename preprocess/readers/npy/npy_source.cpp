// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "preprocess/readers/npy/npy_columns.h"
#include "preprocess/readers/npy/npz_tables.h"
#include "preprocess/readers/npy/zip_directory.h"
#include "preprocess/readers/particle_reader.h"
#include "preprocess/readers/series_source.h"
#include "preprocess/readers/table/table_quantity.h"
#include "protocol/scene/error.h"

namespace mote::prep {
namespace {

class NpySource : public SeriesSource {
  public:
    NpySource(std::string format, double mass, Progress& progress)
        : SeriesSource(std::move(format), progress), mass_(mass) {}

    std::vector<SourceRecord> records() const override { return records_; }
    double mass() const override { return files_.front().mass; }
    std::string weightUnit() const override {
        const bool charges = std::all_of(files_.begin(), files_.end(), [](const NpyColumns& file) {
            const auto* const item = file.find(Column::weight);
            return item != nullptr && item->meaning.coulomb;
        });
        return charges ? "C" : "";
    }

  protected:
    Status addFile(const std::filesystem::path& path) override;
    Status finish() override;
    bool hasEverywhere(Column column) const override {
        return std::all_of(files_.begin(), files_.end(),
                           [&](const NpyColumns& file) { return file.find(column) != nullptr; });
    }
    Status readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) override;

  private:
    void noteUnits() const;
    void findRecords();

    struct Place {
        std::size_t file = 0;
        std::uint64_t step = 0;
    };

    Status readColumn(const Place& place, Column column, ParticleChunk& chunk);
    Status readLost(const Place& place, std::uint64_t begin, std::vector<std::uint8_t>& lost);
    template <class Value>
    Status readItem(const Place& place, const NpyColumns::Item& item, std::uint64_t begin,
                    std::span<Value> values);

    double mass_;
    bool numbered_ = true;  // every file says its iterations
    std::vector<Place> places_;
    std::vector<NpyColumns> files_;
    std::vector<SourceRecord> records_;              // of all files
    std::size_t open_ = 0;                           // the file of readers_
    std::vector<std::optional<NpyReader>> readers_;  // by item
    std::vector<double> scratch_;
};

Status NpySource::addFile(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto arrays, openNpyArrays(path));
    const std::string name = path.filename().string();
    MOTE_ASSIGN_OR_RETURN(auto file, NpyColumns::of(std::move(arrays), mass_, name));
    const auto number = file.steps == 1 ? fileNumber(path) : std::nullopt;
    for (std::uint64_t i = 0; i < file.steps; ++i) {
        SourceStep step{name, number.value_or(static_cast<std::int64_t>(steps_.size())), 0.0, file.rows};
        if (!file.iterations.empty()) step.iteration = file.iterations[i];
        if (!file.times.empty()) step.time = file.times[i];
        steps_.push_back(std::move(step));
        places_.push_back({files_.size(), i});
    }
    numbered_ = numbered_ && !file.iterations.empty();
    files_.push_back(std::move(file));
    return success();
}

Status NpySource::finish() {
    const auto is = [&](auto what) { return std::any_of(files_.begin(), files_.end(), what); };
    if (is([](const NpyColumns& file) { return file.unnamed; })) {
        progress_.note(
            "an array without field names is taken as x, y, z [m], and px, py, pz [eV/c] and a weight where "
            "it has so many columns");
    }
    findRecords();
    noteUnits();
    if (is([&](const NpyColumns& file) { return file.mass != files_.front().mass; })) {
        progress_.note("the files' masses differ: that of the first one is taken");
    }
    if (numbered_) sortByIteration(places_);
    return success();
}

void NpySource::findRecords() {
    for (const NpyColumns::Item& item : files_.front().items) {
        if (item.meaning.kind != FieldMeaning::Kind::record || records_.size() == mostRecords) continue;
        auto record = *recordOf(item.name);
        if (std::ranges::all_of(files_,
                                [&](const auto& file) { return file.findRecord(record.name) != nullptr; }))
            records_.push_back(std::move(record));
    }
}

/// Says which units are assumed.
void NpySource::noteUnits() const {
    std::map<std::string, std::set<std::string>> byUnit;
    for (const NpyColumns& file : files_) {
        for (const NpyColumns::Item& item : file.items) {
            // "position" and "momentum" are vectors.
            for (const std::string& name : {item.name, item.name + "_x"}) {
                const auto meaning = tableMeaning(name, "");
                if (!meaning || !meaning->has_value() || (*meaning)->unitGiven) continue;
                byUnit[std::string(assumedUnit((*meaning)->quantity))].insert(item.name);
                break;
            }
        }
    }
    for (const auto& [unit, names] : byUnit) {
        std::string all;
        for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
        progress_.note("no unit is given for " + all + ": taken as " + unit);
    }
}

Status NpySource::readRows(std::size_t step, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    const Place& place = places_[step];
    if (open_ != place.file) readers_.clear();
    open_ = place.file;
    readers_.resize(files_[place.file].items.size());
    for (const Column column : wanted) MOTE_RETURN_IF_ERROR(readColumn(place, column, chunk));
    return readLost(place, chunk.begin, chunk.lost);
}

/// Every item has a reader of its own, so that each goes through its bytes once.
template <class Value>
Status NpySource::readItem(const Place& place, const NpyColumns::Item& item, std::uint64_t begin,
                           std::span<Value> values) {
    if (values.empty()) return success();
    const NpyColumns& file = files_[place.file];
    auto& reader = readers_[static_cast<std::size_t>(&item - file.items.data())];
    if (!reader) {
        MOTE_ASSIGN_OR_RETURN(reader, NpyReader::open(file.arrays[item.array], item.numbers));
    }
    const bool lastStep = item.numbers.stepStride == 0 || place.step + 1 == file.steps;
    return reader->read(place.step, begin, lastStep && begin + values.size() == file.rows, values);
}

Status NpySource::readColumn(const Place& place, Column column, ParticleChunk& chunk) {
    const NpyColumns& file = files_[place.file];
    const NpyColumns::Item* item =
        isRecord(column) ? file.findRecord(records_[static_cast<std::size_t>(column) - columnCount].name)
                         : file.find(column);
    if (item == nullptr) return success();
    if (column == Column::id) return readItem(place, *item, chunk.begin, std::span(chunk.id));
    MOTE_RETURN_IF_ERROR(readItem(place, *item, chunk.begin, std::span(chunk[column])));
    for (double& value : chunk[column]) {
        value *= item->meaning.factor;
        if (column == Column::weight) value = std::abs(value);
    }
    return success();
}

Status NpySource::readLost(const Place& place, std::uint64_t begin, std::vector<std::uint8_t>& lost) {
    for (const NpyColumns::Item& item : files_[place.file].items) {
        using Kind = FieldMeaning::Kind;
        if (item.meaning.kind == Kind::column || item.meaning.kind == Kind::record) continue;
        scratch_.resize(lost.size());
        MOTE_RETURN_IF_ERROR(readItem(place, item, begin, std::span(scratch_)));
        for (std::size_t i = 0; i < lost.size(); ++i)
            lost[i] |= saysLost(item.meaning.kind, scratch_[i]) ? 1 : 0;
    }
    return success();
}

Result<std::unique_ptr<ParticleSource>> openNpy(const char* format, const AskedRun& run, Progress& progress) {
    return openSeries(std::make_unique<NpySource>(format, run.mass, progress), inOrder(run.files));
}

}  // namespace

extern const ParticleReader npyReader;
constinit const ParticleReader npyReader{
    "npy", "NumPy's mark of one array", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return file.begin.starts_with("\x93NUMPY"); },
    [](const AskedRun& run, Progress& progress) { return openNpy("npy", run, progress); }};
extern const ParticleReader npzReader;
constinit const ParticleReader npzReader{
    "npz", "an archive of NumPy's arrays", ParticleReader::Kind::bytes,
    [](const AskedFile& file) -> Result<bool> { return looksLikeZip(file.begin); },
    [](const AskedRun& run, Progress& progress) {
        return isScaledNpz(run.files.front()) ? openScaledNpz(run, progress) : openNpy("npz", run, progress);
    }};

}  // namespace mote::prep
