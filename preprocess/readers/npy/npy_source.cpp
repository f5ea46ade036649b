// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/particle_formats.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/npy/npy_header.h"
#include "preprocess/readers/text/byte_source.h"
#include "preprocess/readers/text/number.h"
#include "protocol/scene/error.h"

namespace mote::prep {
namespace {

/// The array of a .npy file as a table of rows, read piece by piece. Owned by a reader; one thread
/// at a time.
class NpyTable {
  public:
    /// One number of a row that means something to us.
    struct Field {
        FieldMeaning meaning;
        NpyField type;             ///< count 1
        std::uint64_t offset = 0;  ///< bytes, of row 0 in the file
        std::uint64_t stride = 0;  ///< bytes, from row to row
    };

    /// Checks the header against the file's size. `mass` in eV/c^2, 0: unknown. Errors: those of
    /// ByteSource::open and NpyHeader::parse; corrupt (a size that contradicts the file), unsupported
    /// (compressed, another shape).
    static Result<NpyTable> open(const std::filesystem::path& path, double mass);

    std::uint64_t rows() const { return rows_; }
    bool structured() const { return structured_; }
    const std::vector<Field>& fields() const { return fields_; }
    const Field* find(Column column) const;

    /// Values of rows [begin, begin + values.size()). Errors: corrupt, internal.
    Status read(const Field& field, std::uint64_t begin, std::span<double> values) const;
    Status read(const Field& field, std::uint64_t begin, std::span<std::uint64_t> values) const;

  private:
    Status setPlainFields(const NpyHeader& header);
    Status setNamedFields(const NpyHeader& header, double mass);
    template <class Value>
    Status readAs(const Field& field, std::uint64_t begin, std::span<Value> values) const;

    std::filesystem::path path_;
    std::string name_;
    std::uint64_t rows_ = 0;
    bool structured_ = false;
    std::vector<Field> fields_;
};

constexpr std::size_t blockBytes = 1u << 20;
constexpr Column plainOrder[] = {Column::x,  Column::y,  Column::z,     Column::px,
                                 Column::py, Column::pz, Column::weight};

template <class Value>
Value convert(const char* from, const NpyField& type) {
    const bool big = type.bigEndian;
    if (type.kind == 'f') {
        const double value = type.bytes == 4 ? static_cast<double>(loadNumber<float>(from, big))
                                             : loadNumber<double>(from, big);
        if constexpr (std::is_same_v<Value, std::uint64_t>) {
            return value >= 0.0 && value < 18446744073709551616.0 ? static_cast<std::uint64_t>(value) : 0;
        } else {
            return value;
        }
    }
    const bool wide = type.kind == 'i';
    switch (type.bytes) {
        case 1:
            return wide ? static_cast<Value>(loadNumber<std::int8_t>(from, big))
                        : static_cast<Value>(loadNumber<std::uint8_t>(from, big));
        case 2:
            return wide ? static_cast<Value>(loadNumber<std::int16_t>(from, big))
                        : static_cast<Value>(loadNumber<std::uint16_t>(from, big));
        case 4:
            return wide ? static_cast<Value>(loadNumber<std::int32_t>(from, big))
                        : static_cast<Value>(loadNumber<std::uint32_t>(from, big));
        default:
            return wide ? static_cast<Value>(loadNumber<std::int64_t>(from, big))
                        : static_cast<Value>(loadNumber<std::uint64_t>(from, big));
    }
}

Error unreadable(std::string where) {
    return {ErrorCode::unsupported, std::move(where), "holds no integers, f4 or f8"};
}

/// Bytes of the whole array; nothing where the product does not fit.
std::optional<std::uint64_t> arrayBytes(const NpyHeader& header) {
    std::uint64_t bytes = header.itemBytes;
    for (const std::uint64_t length : header.shape) {
        if (length != 0 && bytes > std::numeric_limits<std::uint64_t>::max() / length) return std::nullopt;
        bytes *= length;
    }
    return bytes;
}

Result<NpyTable> NpyTable::open(const std::filesystem::path& path, double mass) {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path));
    NpyTable table;
    table.path_ = path;
    table.name_ = source->name();
    if (source->compressed()) {
        return Error{ErrorCode::unsupported, table.name_, "is a gzipped .npy file; unpack it first (gunzip)"};
    }
    std::vector<char> bytes(
        static_cast<std::size_t>(std::min<std::uint64_t>(source->fileBytes(), NpyHeader::maxBytes)));
    MOTE_ASSIGN_OR_RETURN(const auto got, source->read(bytes));
    MOTE_ASSIGN_OR_RETURN(const auto header, NpyHeader::parse({bytes.data(), got}, table.name_));
    const auto declared = arrayBytes(header);
    const std::uint64_t held = source->fileBytes() - std::min(source->fileBytes(), header.dataOffset);
    if (!declared || *declared != held) {
        return Error{ErrorCode::corrupt, table.name_,
                     "its header declares " + (declared ? std::to_string(*declared) : "more than 2^64") +
                         " bytes of data, and it holds " + std::to_string(held)};
    }
    table.structured_ = header.structured();
    table.rows_ = header.shape.empty() ? 0 : header.shape[0];
    MOTE_RETURN_IF_ERROR(table.structured_ ? table.setNamedFields(header, mass)
                                           : table.setPlainFields(header));
    return table;
}

/// An array N x 6 or N x 7: x, y, z, px, py, pz and the weight.
Status NpyTable::setPlainFields(const NpyHeader& header) {
    const std::uint64_t columns = header.shape.size() == 2 ? header.shape[1] : 0;
    if (columns != 6 && columns != 7) {
        return Error{ErrorCode::unsupported, name_,
                     "is an array without field names whose shape is not N x 6 (x, y, z, px, py, pz) or N x "
                     "7 (and weight)"};
    }
    const NpyField& type = header.fields[0];
    if (type.kind == NpyField::other) return unreadable(name_);
    for (std::uint64_t i = 0; i < columns; ++i) {
        Field field;
        field.meaning.column = plainOrder[i];
        field.type = type;
        field.stride = header.fortranOrder ? type.bytes : type.bytes * columns;
        field.offset = header.dataOffset + i * type.bytes * (header.fortranOrder ? rows_ : 1);
        fields_.push_back(std::move(field));
    }
    return success();
}

/// An array of named fields. Of "position" and "momentum" with three numbers each, every number has its
/// column.
Status NpyTable::setNamedFields(const NpyHeader& header, double mass) {
    if (header.shape.size() != 1) {
        return Error{ErrorCode::unsupported, name_,
                     "is an array of named fields with more than one dimension"};
    }
    for (const NpyField& type : header.fields) {
        const bool vector = type.count == 3;
        if (type.count != 1 && !vector) continue;
        for (std::size_t i = 0; i < type.count; ++i) {
            const std::string name = vector ? type.name + "_" + "xyz"[i] : type.name;
            MOTE_ASSIGN_OR_RETURN(const auto meaning,
                                  fieldMeaning(name, mass, name_ + ", field '" + type.name + "'"));
            if (!meaning) continue;
            if (type.kind == NpyField::other) return unreadable(name_ + ", field '" + type.name + "'");
            Field field{*meaning, type, header.dataOffset + type.offset + i * type.bytes, header.itemBytes};
            field.type.count = 1;
            if (field.meaning.kind == FieldMeaning::Kind::column && find(field.meaning.column) != nullptr) {
                return Error{ErrorCode::corrupt, name_,
                             "has two fields of the same meaning as '" + type.name + "'"};
            }
            fields_.push_back(std::move(field));
        }
    }
    if (fields_.empty()) {
        return Error{ErrorCode::corrupt, name_, "has none of the fields x, y, z, t, px, py, pz"};
    }
    return success();
}

const NpyTable::Field* NpyTable::find(Column column) const {
    for (const Field& field : fields_) {
        if (field.meaning.kind == FieldMeaning::Kind::column && field.meaning.column == column) return &field;
    }
    return nullptr;
}

Status NpyTable::read(const Field& field, std::uint64_t begin, std::span<double> values) const {
    return readAs(field, begin, values);
}

Status NpyTable::read(const Field& field, std::uint64_t begin, std::span<std::uint64_t> values) const {
    return readAs(field, begin, values);
}

template <class Value>
Status NpyTable::readAs(const Field& field, std::uint64_t begin, std::span<Value> values) const {
    MOTE_ASSIGN_OR_RETURN(const auto source, ByteSource::open(path_));
    // Whole rows, so that fields that lie side by side cost no more than one pass over a block.
    const std::size_t rowsPerBlock = std::max<std::size_t>(1, blockBytes / field.stride);
    std::vector<char> block(rowsPerBlock * field.stride);
    for (std::size_t done = 0; done < values.size();) {
        const std::size_t rows = std::min(rowsPerBlock, values.size() - done);
        const std::size_t bytes = (rows - 1) * field.stride + field.type.bytes;
        MOTE_RETURN_IF_ERROR(source->seek(field.offset + (begin + done) * field.stride));
        MOTE_ASSIGN_OR_RETURN(const auto got, source->read({block.data(), bytes}));
        if (got != bytes) return Error{ErrorCode::corrupt, name_, "has changed since it was opened"};
        for (std::size_t i = 0; i < rows; ++i) {
            values[done + i] = convert<Value>(block.data() + i * field.stride, field.type);
        }
        done += rows;
    }
    return success();
}

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
    MOTE_ASSIGN_OR_RETURN(auto table, NpyTable::open(path, mass_));
    const auto number = fileNumber(path);
    steps_.push_back({path.filename().string(), number.value_or(static_cast<std::int64_t>(steps_.size())),
                      0.0, table.rows()});
    tables_.push_back(std::move(table));
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
