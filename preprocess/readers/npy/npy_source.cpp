// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/npy/npy_source.h"

#include <algorithm>
#include <cmath>

#include "preprocess/readers/file_number.h"
#include "preprocess/readers/npy/npy_table.h"

namespace mote::prep {
namespace {

class NpySource : public ParticleSource {
  public:
    explicit NpySource(double mass) : mass_(mass) {}
    Status addFile(const std::filesystem::path& path);
    bool plain() const {
        return std::any_of(tables_.begin(), tables_.end(),
                           [](const NpyTable& table) { return !table.structured(); });
    }

    std::string format() const override { return "npy"; }
    const std::vector<SourceStep>& steps() const override { return steps_; }
    bool has(Column column) const override {
        return std::all_of(tables_.begin(), tables_.end(),
                           [&](const NpyTable& table) { return table.find(column) != nullptr; });
    }
    double mass() const override { return mass_; }
    Status read(std::size_t step, std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                ParticleChunk& chunk) override;

  private:
    Status readColumn(std::size_t step, std::uint64_t begin, Column column, ParticleChunk& chunk);
    Status readLost(const NpyTable& table, std::uint64_t begin, std::vector<std::uint8_t>& lost);

    double mass_;
    std::vector<SourceStep> steps_;
    std::vector<NpyTable> tables_;
    std::vector<double> scratch_;
};

Status NpySource::addFile(const std::filesystem::path& path) {
    auto table = NpyTable::open(path, mass_);
    if (!table) return table.error();
    const auto number = fileNumber(path);
    steps_.push_back({path.filename().string(), number.value_or(static_cast<std::int64_t>(steps_.size())),
                      0.0, table->rows()});
    tables_.push_back(std::move(*table));
    return success();
}

Status NpySource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                       const std::vector<Column>& wanted, ParticleChunk& chunk) {
    MOTE_RETURN_IF_ERROR(checkRange(steps_, step, begin, count));
    chunk.begin = begin;
    chunk.size = count;
    for (const Column column : wanted) MOTE_RETURN_IF_ERROR(readColumn(step, begin, column, chunk));
    chunk.lost.assign(count, 0);
    return readLost(tables_[step], begin, chunk.lost);
}

Status NpySource::readColumn(std::size_t step, std::uint64_t begin, Column column, ParticleChunk& chunk) {
    const NpyTable::Field* field = tables_[step].find(column);
    if (column == Column::id) {
        chunk.id.resize(chunk.size);
        if (field != nullptr) return tables_[step].read(*field, begin, std::span(chunk.id));
        for (std::size_t i = 0; i < chunk.size; ++i) chunk.id[i] = begin + i;
        return success();
    }
    chunk[column].assign(chunk.size, 1.0);
    if (field == nullptr && column == Column::weight) return success();
    if (field == nullptr) {
        return Error{ErrorCode::invalidArgument, steps_[step].file,
                     "has not all columns that were asked for"};
    }
    MOTE_RETURN_IF_ERROR(tables_[step].read(*field, begin, std::span(chunk[column])));
    for (double& value : chunk[column]) {
        value *= field->meaning.factor;
        if (column == Column::weight) value = std::abs(value);
    }
    return success();
}

Status NpySource::readLost(const NpyTable& table, std::uint64_t begin, std::vector<std::uint8_t>& lost) {
    for (const NpyTable::Field& field : table.fields()) {
        if (field.meaning.kind == FieldMeaning::Kind::column) continue;
        scratch_.resize(lost.size());
        MOTE_RETURN_IF_ERROR(table.read(field, begin, std::span(scratch_)));
        for (std::size_t i = 0; i < lost.size(); ++i)
            lost[i] |= saysLost(field.meaning.kind, scratch_[i]) ? 1 : 0;
    }
    return success();
}

}  // namespace

Result<std::unique_ptr<ParticleSource>> openNpy(const std::vector<std::filesystem::path>& files, double mass,
                                                Progress& progress) {
    auto source = std::make_unique<NpySource>(mass);
    for (const std::filesystem::path& file : inOrder(files)) {
        if (progress.cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while the steps were listed"};
        MOTE_RETURN_IF_ERROR(source->addFile(file));
    }
    if (source->plain()) {
        progress.note(
            "an array without field names is taken as x, y, z [m], px, py, pz [eV/c] and perhaps a weight");
    }
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
