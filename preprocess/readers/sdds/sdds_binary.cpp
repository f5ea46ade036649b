// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/sdds/sdds_pages.h"
#include "preprocess/readers/text/byte_source.h"
#include "protocol/base/error.h"

namespace mote::prep {
namespace {

/// The bytes of binary SDDS pages, through one buffer, with their place. A compressed file is read
/// again from its beginning where an earlier place is asked for. One owner, one thread; `progress` must
/// outlive it.
class SddsStream {
  public:
    /// Errors as of ByteSource::open.
    static Result<SddsStream> open(const std::filesystem::path& path, Progress& progress);

    const std::string& name() const { return source_->name(); }
    std::uint64_t offset() const { return bufferOffset_ + begin_; }

    /// Whether no byte is left.
    Result<bool> atEnd();
    /// Fills `bytes`. Errors: corrupt (cut short, with the byte), those of ByteSource::read.
    Status read(std::span<char> bytes);
    /// Steps over bytes that must be there. Errors: as of read, cancelled.
    Status skip(std::uint64_t bytes);
    /// Goes to a place. Errors: as of skip.
    Status seek(std::uint64_t offset);

  private:
    Status fill();
    Error cutShort() const;

    std::unique_ptr<ByteSource> source_;
    Progress* progress_ = nullptr;
    std::vector<char> buffer_;
    std::size_t begin_ = 0, end_ = 0;  // what is not yet handed out
    std::uint64_t bufferOffset_ = 0;   // of the buffer's first byte
};

constexpr std::size_t bufferBytes = 256 * 1024;

Result<SddsStream> SddsStream::open(const std::filesystem::path& path, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto source, ByteSource::open(path));
    SddsStream stream;
    stream.source_ = std::move(source);
    stream.progress_ = &progress;
    stream.buffer_.resize(bufferBytes);
    return stream;
}

/// The next bytes, where all of the buffer is handed out.
Status SddsStream::fill() {
    bufferOffset_ += end_;
    begin_ = end_ = 0;
    MOTE_ASSIGN_OR_RETURN(const auto got, source_->read(buffer_));
    end_ = got;
    return success();
}

Error SddsStream::cutShort() const {
    return {ErrorCode::corrupt, name(), "is cut short at byte " + std::to_string(offset() + (end_ - begin_))};
}

Result<bool> SddsStream::atEnd() {
    if (begin_ == end_) MOTE_RETURN_IF_ERROR(fill());
    return begin_ == end_;
}

Status SddsStream::read(std::span<char> bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        MOTE_ASSIGN_OR_RETURN(const auto ended, atEnd());
        if (ended) return cutShort();
        const std::size_t some = std::min(bytes.size() - done, end_ - begin_);
        std::memcpy(bytes.data() + done, buffer_.data() + begin_, some);
        begin_ += some;
        done += some;
    }
    return success();
}

Status SddsStream::skip(std::uint64_t bytes) {
    if (bytes <= end_ - begin_) {
        begin_ += static_cast<std::size_t>(bytes);
        return success();
    }
    if (!source_->compressed()) {
        const std::uint64_t size = source_->fileBytes();
        if (offset() > size || bytes > size - offset()) {
            return corrupt(name(), "is cut short at byte " + std::to_string(size));
        }
        return seek(offset() + bytes);
    }
    while (bytes > 0) {
        if (progress_->cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while a table was read"};
        MOTE_ASSIGN_OR_RETURN(const auto ended, atEnd());
        if (ended) return cutShort();
        const std::uint64_t some = std::min<std::uint64_t>(bytes, end_ - begin_);
        begin_ += static_cast<std::size_t>(some);
        bytes -= some;
    }
    return success();
}

Status SddsStream::seek(std::uint64_t offset) {
    if (offset >= bufferOffset_ && offset <= bufferOffset_ + end_) {
        begin_ = static_cast<std::size_t>(offset - bufferOffset_);
        return success();
    }
    if (source_->compressed() && offset > this->offset()) return skip(offset - this->offset());
    const std::uint64_t target = source_->compressed() ? 0 : offset;
    MOTE_RETURN_IF_ERROR(source_->seek(target));
    begin_ = end_ = 0;
    bufferOffset_ = target;
    return skip(offset - target);
}

constexpr std::size_t blockBytes = 1u << 20;

class BinaryPages : public SddsPages {
  public:
    BinaryPages(SddsStream stream, const SddsHeader& header, bool big, Progress& progress);
    Status scan();
    Status read(std::size_t page, std::uint64_t begin, std::size_t count,
                const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                SddsRows& rows) override;

  private:
    /// Where the table of a page lies.
    struct Place {
        std::vector<std::uint64_t> columns;  // bytes; of each column's first value, where they lie one by one
        std::vector<std::uint64_t> marks;  // bytes; of every sddsRowsPerMark-th row, else of the first alone
    };
    /// Which value of a row goes where; the ids are slot `columns.size()`.
    struct Slot {
        std::size_t column = 0;
        std::vector<double>* values = nullptr;
        std::vector<std::uint64_t>* ids = nullptr;
    };

    Error corrupt(std::string message) const {
        return {ErrorCode::corrupt, stream_.name(), std::move(message)};
    }
    std::string inPage() const { return "page " + std::to_string(pages_.size() + 1); }
    template <class Number>
    Result<Number> number();
    Status skipText();
    Status skipValues(const SddsField& field, std::uint64_t count);
    Status scanPage();
    Status scanParameters(SddsPage& page);
    Status scanArrays();
    Status scanRows(std::uint64_t rows, Place& place);
    Status scanColumns(std::uint64_t rows, Place& place);
    Status readColumn(const Place& place, std::uint64_t begin, std::size_t count, const Slot& slot);
    Status readRows(const Place& place, std::uint64_t begin, std::size_t count,
                    const std::vector<Slot>& slots);
    Status readWalked(const Place& place, std::uint64_t begin, std::size_t count,
                      const std::vector<Slot>& slots);
    void store(const Slot& slot, std::size_t row, const char* from) const;

    SddsStream stream_;
    SddsHeader header_;
    bool big_;
    Progress& progress_;
    bool texts_ = false;                       // a column of texts: rows differ in length
    std::uint64_t rowBytes_ = 0;               // where they do not
    std::vector<std::uint64_t> columnOffset_;  // bytes, in such a row
    std::vector<Place> places_;
};

BinaryPages::BinaryPages(SddsStream stream, const SddsHeader& header, bool big, Progress& progress)
    : stream_(std::move(stream)), header_(header), big_(big), progress_(progress) {
    for (const SddsField& column : header_.columns) {
        columnOffset_.push_back(rowBytes_);
        rowBytes_ += column.bytes();
        texts_ = texts_ || column.type == SddsType::string;
    }
}

template <class Number>
Result<Number> BinaryPages::number() {
    std::array<char, sizeof(Number)> bytes;
    MOTE_RETURN_IF_ERROR(stream_.read(bytes));
    return loadNumber<Number>(bytes.data(), big_);
}

Status BinaryPages::skipText() {
    const std::uint64_t at = stream_.offset();
    MOTE_ASSIGN_OR_RETURN(const auto length, number<std::int32_t>());
    if (length < 0) {
        return corrupt("has a text of " + std::to_string(length) + " characters at byte " +
                       std::to_string(at));
    }
    return stream_.skip(static_cast<std::uint64_t>(length));
}

Status BinaryPages::skipValues(const SddsField& field, std::uint64_t count) {
    if (field.type != SddsType::string) {
        if (count > std::numeric_limits<std::uint64_t>::max() / field.bytes()) {
            return corrupt("declares more than 2^64 bytes of '" + field.name + "' in " + inPage());
        }
        return stream_.skip(count * field.bytes());
    }
    for (std::uint64_t i = 0; i < count; ++i) {
        if (i % sddsRowsPerMark == sddsRowsPerMark - 1 && progress_.cancelled()) {
            return wasCancelled("cancelled while a table was read");
        }
        MOTE_RETURN_IF_ERROR(skipText());
    }
    return success();
}

Status BinaryPages::scan() {
    MOTE_RETURN_IF_ERROR(stream_.seek(header_.dataOffset));
    for (;;) {
        MOTE_ASSIGN_OR_RETURN(const auto ended, stream_.atEnd());
        if (ended) return success();
        if (pages_.size() == maxSddsPages) return corrupt("has more than 100000 pages");
        if (progress_.cancelled()) return wasCancelled("cancelled while a table was read");
        Status status = scanPage();
        if (status) continue;
        Error error = status.error();
        if (error.message.starts_with("is cut short")) error.message += ", within " + inPage();
        return error;
    }
}

Status BinaryPages::scanPage() {
    const std::uint64_t at = stream_.offset();
    MOTE_ASSIGN_OR_RETURN(const auto few, number<std::int32_t>());
    std::int64_t rows = few;
    // More rows than 32 bits count are announced by the least number of them.
    if (few == std::numeric_limits<std::int32_t>::min()) {
        MOTE_ASSIGN_OR_RETURN(rows, number<std::int64_t>());
    }
    if (rows < 0) {
        return corrupt("declares " + std::to_string(rows) + " rows in " + inPage() + ", at byte " +
                       std::to_string(at));
    }
    SddsPage page;
    Place place;
    page.rows = header_.columns.empty() ? 0 : static_cast<std::uint64_t>(rows);
    MOTE_RETURN_IF_ERROR(scanParameters(page));
    MOTE_RETURN_IF_ERROR(scanArrays());
    MOTE_RETURN_IF_ERROR(header_.columnMajor ? scanColumns(page.rows, place) : scanRows(page.rows, place));
    pages_.push_back(std::move(page));
    places_.push_back(std::move(place));
    return success();
}

Status BinaryPages::scanParameters(SddsPage& page) {
    for (const SddsField& field : header_.parameters) {
        double value = std::numeric_limits<double>::quiet_NaN();
        if (field.fixedValue) {
            value = parseNumber(*field.fixedValue).value_or(value);
        } else if (field.number()) {
            std::array<char, 8> bytes;
            MOTE_RETURN_IF_ERROR(stream_.read(std::span(bytes).first(field.bytes())));
            value = loadStored<double>(bytes.data(), field.stored().value_or(StoredNumber::float64), big_);
        } else {
            MOTE_RETURN_IF_ERROR(skipValues(field, 1));
        }
        if (field.known) page.parameters[*field.known] = value;
    }
    return success();
}

Status BinaryPages::scanArrays() {
    for (const SddsField& field : header_.arrays) {
        std::uint64_t count = 1;
        for (std::uint32_t i = 0; i < field.dimensions; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto length, number<std::int32_t>());
            const std::uint64_t most =
                length > 0 ? std::numeric_limits<std::uint64_t>::max() / static_cast<std::uint64_t>(length)
                           : 0;
            if (length < 0 || (length > 0 && count > most)) {
                return corrupt("has an impossible size of array '" + field.name + "' in " + inPage());
            }
            count *= static_cast<std::uint64_t>(length);
        }
        MOTE_RETURN_IF_ERROR(skipValues(field, count));
    }
    return success();
}

Status BinaryPages::scanRows(std::uint64_t rows, Place& place) {
    place.marks.push_back(stream_.offset());
    if (!texts_) {
        if (rowBytes_ > 0 && rows > std::numeric_limits<std::uint64_t>::max() / rowBytes_) {
            return corrupt("declares more than 2^64 bytes of rows in " + inPage());
        }
        return stream_.skip(rows * rowBytes_);
    }
    for (std::uint64_t row = 0; row < rows; ++row) {
        if (row % sddsRowsPerMark == 0 && row > 0) {
            place.marks.push_back(stream_.offset());
            if (progress_.cancelled()) return wasCancelled("cancelled while a table was read");
        }
        for (const SddsField& column : header_.columns) MOTE_RETURN_IF_ERROR(skipValues(column, 1));
    }
    return success();
}

Status BinaryPages::scanColumns(std::uint64_t rows, Place& place) {
    if (rows == 0) return success();
    for (const SddsField& column : header_.columns) {
        place.columns.push_back(stream_.offset());
        MOTE_RETURN_IF_ERROR(skipValues(column, rows));
    }
    return success();
}

void BinaryPages::store(const Slot& slot, std::size_t row, const char* from) const {
    const auto type = header_.columns[slot.column].stored().value_or(StoredNumber::float64);
    if (slot.values != nullptr)
        (*slot.values)[row] = loadStored<double>(from, type, big_);
    else
        (*slot.ids)[row] = loadStored<std::uint64_t>(from, type, big_);
}

Status BinaryPages::read(std::size_t page, std::uint64_t begin, std::size_t count,
                         const std::vector<std::size_t>& columns, std::optional<std::size_t> idColumn,
                         SddsRows& rows) {
    std::vector<Slot> slots;
    rows.columns.resize(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
        rows.columns[i].resize(count);
        slots.push_back({columns[i], &rows.columns[i], nullptr});
    }
    rows.ids.resize(idColumn ? count : 0);
    if (idColumn) slots.push_back({*idColumn, nullptr, &rows.ids});
    // In the order of the file: a compressed one is read once.
    std::sort(slots.begin(), slots.end(), [](const Slot& a, const Slot& b) { return a.column < b.column; });
    if (count == 0) return success();
    const Place& place = places_[page];
    if (!header_.columnMajor) {
        return texts_ ? readWalked(place, begin, count, slots) : readRows(place, begin, count, slots);
    }
    for (const Slot& slot : slots) MOTE_RETURN_IF_ERROR(readColumn(place, begin, count, slot));
    return success();
}

Status BinaryPages::readColumn(const Place& place, std::uint64_t begin, std::size_t count, const Slot& slot) {
    const std::size_t bytes = header_.columns[slot.column].bytes();
    MOTE_RETURN_IF_ERROR(stream_.seek(place.columns[slot.column] + begin * bytes));
    std::array<char, 8> value;
    for (std::size_t row = 0; row < count; ++row) {
        MOTE_RETURN_IF_ERROR(stream_.read(std::span(value).first(bytes)));
        store(slot, row, value.data());
    }
    return success();
}

Status BinaryPages::readRows(const Place& place, std::uint64_t begin, std::size_t count,
                             const std::vector<Slot>& slots) {
    const std::size_t rowBytes = static_cast<std::size_t>(rowBytes_);
    const std::size_t most = std::max<std::size_t>(1, blockBytes / rowBytes);
    MOTE_RETURN_IF_ERROR(stream_.seek(place.marks[0] + begin * rowBytes_));
    std::vector<char> block(std::min(most, count) * rowBytes);
    for (std::size_t done = 0; done < count;) {
        const std::size_t some = std::min(most, count - done);
        MOTE_RETURN_IF_ERROR(stream_.read(std::span(block).first(some * rowBytes)));
        for (const Slot& slot : slots) {
            const char* from = block.data() + columnOffset_[slot.column];
            for (std::size_t row = 0; row < some; ++row) store(slot, done + row, from + row * rowBytes);
        }
        done += some;
    }
    return success();
}

/// Rows of different lengths, value by value from the nearest mark on.
Status BinaryPages::readWalked(const Place& place, std::uint64_t begin, std::size_t count,
                               const std::vector<Slot>& slots) {
    std::uint64_t row = begin / sddsRowsPerMark * sddsRowsPerMark;
    MOTE_RETURN_IF_ERROR(stream_.seek(place.marks[static_cast<std::size_t>(begin / sddsRowsPerMark)]));
    std::array<char, 8> value;
    for (; row < begin + count; ++row) {
        auto slot = slots.begin();
        for (std::size_t i = 0; i < header_.columns.size(); ++i) {
            if (row < begin || slot == slots.end() || slot->column != i) {
                MOTE_RETURN_IF_ERROR(skipValues(header_.columns[i], 1));
                continue;
            }
            MOTE_RETURN_IF_ERROR(stream_.read(std::span(value).first(header_.columns[i].bytes())));
            for (; slot != slots.end() && slot->column == i; ++slot) {
                store(*slot, static_cast<std::size_t>(row - begin), value.data());
            }
        }
    }
    return success();
}

}  // namespace

Result<std::unique_ptr<SddsPages>> openSddsBinary(const std::filesystem::path& path, const SddsHeader& header,
                                                  Progress& progress) {
    const auto open = [&](bool big) -> Result<std::unique_ptr<SddsPages>> {
        MOTE_ASSIGN_OR_RETURN(auto stream, SddsStream::open(path, progress));
        auto pages = std::make_unique<BinaryPages>(std::move(stream), header, big, progress);
        MOTE_RETURN_IF_ERROR(pages->scan());
        return std::unique_ptr<SddsPages>(std::move(pages));
    };
    auto pages = open(header.bigEndian.value_or(false));
    if (pages || header.bigEndian || pages.error().code != ErrorCode::corrupt) return pages;
    auto other = open(true);
    if (!other) return pages;
    progress.note(path.filename().string() +
                  " does not say its byte order; it makes sense as big-endian only");
    return other;
}

}  // namespace mote::prep
