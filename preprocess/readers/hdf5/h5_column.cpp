// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_column.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace mote::prep {
namespace {

constexpr std::uint64_t maxChunkBytes = 1ull << 30;
constexpr std::uint64_t deflateRatio = 1040;  // zlib's own limit is 1032:1
constexpr std::size_t maxScratchBytes = 16 << 20;
constexpr std::size_t checksumBytes = 4;
constexpr std::size_t maxFilters = 8;

Error corrupt(const std::string& where, std::string message) {
    return {ErrorCode::corrupt, where, std::move(message)};
}

/// Fletcher's checksum over 16-bit words, most significant byte first, as HDF5 computes it.
std::uint32_t fletcher32(std::span<const std::uint8_t> bytes) {
    std::uint64_t sum1 = 0, sum2 = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
        sum1 += static_cast<std::uint64_t>(bytes[i]) << 8 | (i + 1 < bytes.size() ? bytes[i + 1] : 0u);
        sum1 = (sum1 & 0xffff) + (sum1 >> 16);
        sum2 += sum1;
        sum2 = (sum2 & 0xffff) + (sum2 >> 16);
    }
    return static_cast<std::uint32_t>(sum2 << 16 | sum1);
}

constexpr std::size_t maxValueBytes = 16;

Error corrupt(const H5Object& object, std::string message) {
    return {ErrorCode::corrupt, object.where, std::move(message)};
}

Error unsupported(const H5Object& object, std::string message) {
    return {ErrorCode::unsupported, object.where, std::move(message)};
}

Result<std::vector<hsize_t>> extentOf(const H5Object& dataset, hid_t space) {
    const int rank = H5Sget_simple_extent_ndims(space);
    const H5S_class_t kind = H5Sget_simple_extent_type(space);
    if (rank < 0 || rank > H5S_MAX_RANK || kind == H5S_NO_CLASS)
        return corrupt(dataset, "has no valid extent");
    if (kind == H5S_NULL) return std::vector<hsize_t>{0};
    std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
    if (rank > 0 && H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0) {
        return corrupt(dataset, "has no valid extent");
    }
    return extent;
}

std::uint64_t saturatingProduct(std::uint64_t a, std::uint64_t b) {
    return b != 0 && a > std::numeric_limits<std::uint64_t>::max() / b
               ? std::numeric_limits<std::uint64_t>::max()
               : a * b;
}

/// Data that lies in other files is refused before HDF5 looks for it.
Status checkOrigin(const H5Object& dataset, hid_t creation) {
    if (H5Pget_layout(creation) == H5D_VIRTUAL) {
        return unsupported(dataset, "is a virtual dataset, whose data lies in other files");
    }
    if (H5Pget_external_count(creation) != 0) {
        return unsupported(dataset, "keeps its data in another file, which is not opened");
    }
    return success();
}

/// Whether the file can hold what the dataset declares; `ratio` bytes come out of a stored one at most. An
/// edge chunk is stored whole, so that without deflate no less is stored than declared.
Status checkSize(const H5File& file, const H5Object& dataset, std::uint64_t ratio, std::uint64_t rows,
                 std::uint64_t valueBytes) {
    const std::uint64_t declared = saturatingProduct(rows, valueBytes);
    const std::uint64_t stored = H5Dget_storage_size(dataset.handle.get());
    if (stored <= file.bytes() && declared <= saturatingProduct(stored, ratio)) return success();
    return corrupt(dataset,
                   "declares " + std::to_string(declared) + " bytes and holds " +
                       std::to_string(std::min(stored, file.bytes())) +
                       (stored == 0 ? ": nothing was written to it" : ": the file is cut short or damaged"));
}

}  // namespace

Result<H5Chunks> H5Chunks::open(const H5Object& dataset, int axis, std::size_t valueBytes,
                                std::uint64_t fileBytes) {
    const H5Handle creation(H5Dget_create_plist(dataset.handle.get()), H5Pclose);
    const H5Handle type(H5Dget_type(dataset.handle.get()), H5Tclose);
    if (!creation.ok() || !type.ok()) return corrupt(dataset.where, "its layout cannot be read");
    H5Chunks chunks;
    chunks.axis_ = static_cast<std::size_t>(axis);
    chunks.valueBytes_ = valueBytes;
    chunks.fileBytes_ = fileBytes;
    MOTE_RETURN_IF_ERROR(chunks.readShape(dataset, creation.get()));
    MOTE_RETURN_IF_ERROR(chunks.readFilters(dataset, creation.get()));
    chunks.readFillValue(creation.get(), type.get());
    return chunks;
}

Status H5Chunks::readShape(const H5Object& dataset, hid_t creation) {
    std::array<hsize_t, H5S_MAX_RANK> shape{};
    const int rank = H5Pget_chunk(creation, H5S_MAX_RANK, shape.data());
    if (rank < 1 || axis_ >= static_cast<std::size_t>(rank))
        return corrupt(dataset.where, "has no valid chunk shape");
    shape_.assign(shape.begin(), shape.begin() + rank);
    chunkBytes_ = valueBytes_;
    for (const hsize_t length : shape_) {
        // What is beyond 1 GiB already needs no exact value.
        chunkBytes_ = length == 0                           ? 0
                      : chunkBytes_ > (1ull << 62) / length ? 1ull << 62
                                                            : chunkBytes_ * length;
    }
    if (chunkBytes_ == 0 || chunkBytes_ > maxChunkBytes) {
        return Error{ErrorCode::unsupported, dataset.where,
                     "has chunks of " + std::to_string(chunkBytes_) + " bytes; at most 1 GiB is read"};
    }
    chunkRows_ = shape_[axis_];
    for (std::size_t i = axis_ + 1; i < shape_.size(); ++i) stride_ *= shape_[i];
    return success();
}

Status H5Chunks::readFilters(const H5Object& dataset, hid_t creation) {
    const int count = H5Pget_nfilters(creation);
    if (count < 0 || static_cast<std::size_t>(count) > maxFilters) {
        return corrupt(dataset.where, "has no valid list of filters");
    }
    for (int i = 0; i < count; ++i) {
        unsigned flags = 0;
        std::array<unsigned, 8> values{};
        std::size_t valueCount = values.size();
        std::array<char, 64> name{};
        const H5Z_filter_t id = H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &valueCount,
                                               values.data(), name.size() - 1, name.data(), nullptr);
        if (id < 0) return corrupt(dataset.where, "has no valid list of filters");
        if (id != H5Z_FILTER_DEFLATE && id != H5Z_FILTER_SHUFFLE && id != H5Z_FILTER_FLETCHER32) {
            return Error{ErrorCode::unsupported, dataset.where,
                         "is compressed by filter " + std::to_string(id) + " '" + name.data() +
                             "', which is not read; repack it (h5repack -f GZIP=1)"};
        }
        // The size of an element is the first parameter of shuffle, set when the dataset is made.
        filters_.push_back({id, valueCount > 0 && values[0] > 0 ? values[0] : valueBytes_});
    }
    return success();
}

void H5Chunks::readFillValue(hid_t creation, hid_t type) {
    fill_.assign(valueBytes_, 0);
    H5D_fill_value_t kind = H5D_FILL_VALUE_UNDEFINED;
    if (H5Pfill_value_defined(creation, &kind) >= 0 && kind == H5D_FILL_VALUE_USER_DEFINED &&
        H5Pget_fill_value(creation, type, fill_.data()) < 0) {
        fill_.assign(valueBytes_, 0);
    }
}

std::uint64_t H5Chunks::greatestRatio() const {
    const bool deflated = std::any_of(filters_.begin(), filters_.end(),
                                      [](const Filter& filter) { return filter.id == H5Z_FILTER_DEFLATE; });
    return deflated ? deflateRatio : 1;
}

Status H5Chunks::read(hid_t dataset, std::uint64_t begin, std::size_t count, std::vector<std::uint8_t>& bytes,
                      const std::string& where) {
    bytes.reserve(bytes.size() + count * valueBytes_);
    for (std::uint64_t row = begin, end = begin + count; row < end;) {
        MOTE_RETURN_IF_ERROR(load(dataset, row / chunkRows_, where));
        const std::uint64_t first = row % chunkRows_;
        const std::uint64_t rows = std::min(chunkRows_ - first, end - row);
        const std::uint8_t* from = chunk_.data() + first * stride_ * valueBytes_;
        if (stride_ == 1) {
            bytes.insert(bytes.end(), from, from + rows * valueBytes_);
        } else {
            for (std::uint64_t i = 0; i < rows; ++i, from += stride_ * valueBytes_) {
                bytes.insert(bytes.end(), from, from + valueBytes_);
            }
        }
        row += rows;
    }
    return success();
}

Status H5Chunks::load(hid_t dataset, std::uint64_t chunk, const std::string& where) {
    if (loaded_ == chunk) return success();
    loaded_ = static_cast<std::uint64_t>(-1);
    std::vector<hsize_t> offset(shape_.size(), 0);
    offset[axis_] = chunk * chunkRows_;
    hsize_t stored = 0;
    haddr_t address = HADDR_UNDEF;
    std::uint32_t skipped = 0;
    if (H5Dget_chunk_info_by_coord(dataset, offset.data(), &skipped, &address, &stored) < 0) {
        return corrupt(where, "its list of chunks is damaged");
    }
    if (address == HADDR_UNDEF) {
        chunk_.resize(chunkBytes_);
        for (std::size_t at = 0; at < chunk_.size(); at += valueBytes_) {
            std::copy(fill_.begin(), fill_.end(), chunk_.begin() + static_cast<std::ptrdiff_t>(at));
        }
        loaded_ = chunk;
        return success();
    }
    // Deflate adds 5 bytes for each 16 KiB that it cannot make smaller, and a few more.
    if (stored == 0 || stored > fileBytes_ || stored > chunkBytes_ + chunkBytes_ / 1024 + 1024) {
        return corrupt(where, "has a chunk of an impossible size");
    }
    chunk_.resize(stored);
    if (H5Dread_chunk(dataset, H5P_DEFAULT, offset.data(), &skipped, chunk_.data()) < 0) {
        return corrupt(where, "a chunk cannot be read: the file is cut short or damaged");
    }
    MOTE_RETURN_IF_ERROR(decode(skipped, where));
    if (scratch_.capacity() > maxScratchBytes) scratch_ = {};  // a run has many columns
    loaded_ = chunk;
    return success();
}

/// Undoes the filters, the last one first. Bit i of `skipped`: filter i was left out for this chunk.
Status H5Chunks::decode(std::uint32_t skipped, const std::string& where) {
    for (std::size_t i = filters_.size(); i-- > 0;) {
        if ((skipped >> i & 1u) != 0) continue;
        switch (filters_[i].id) {
            case H5Z_FILTER_DEFLATE:
                if (!inflateChunk()) return corrupt(where, "its compressed data is damaged");
                break;
            case H5Z_FILTER_SHUFFLE:
                unshuffle(filters_[i].elementBytes);
                break;
            default:
                if (!checkFletcher()) return corrupt(where, "its checksum does not fit its data");
        }
    }
    if (chunk_.size() == chunkBytes_) return success();
    return corrupt(where, "has a chunk that holds " + std::to_string(chunk_.size()) + " bytes instead of " +
                              std::to_string(chunkBytes_));
}

bool H5Chunks::inflateChunk() {
    // A checksum may stand behind the values.
    scratch_.resize(chunkBytes_ + maxFilters * checksumBytes);
    uLongf size = scratch_.size();
    if (uncompress(scratch_.data(), &size, chunk_.data(), chunk_.size()) != Z_OK) return false;
    scratch_.resize(size);
    chunk_.swap(scratch_);
    return true;
}

/// Shuffle puts the first bytes of all elements first, then all second bytes, and so on.
void H5Chunks::unshuffle(std::size_t elementBytes) {
    const std::size_t elements = chunk_.size() / elementBytes;
    if (elementBytes < 2 || elements < 2) return;
    scratch_ = chunk_;  // what is left over at the end stays where it is
    for (std::size_t byte = 0; byte < elementBytes; ++byte) {
        const std::uint8_t* from = chunk_.data() + byte * elements;
        std::uint8_t* to = scratch_.data() + byte;
        for (std::size_t i = 0; i < elements; ++i) to[i * elementBytes] = from[i];
    }
    chunk_.swap(scratch_);
}

bool H5Chunks::checkFletcher() {
    if (chunk_.size() < checksumBytes) return false;
    const std::size_t size = chunk_.size() - checksumBytes;
    std::uint32_t stored = 0;
    std::memcpy(&stored, chunk_.data() + size, checksumBytes);  // little-endian
    const bool same = stored == fletcher32(std::span(chunk_).first(size));
    chunk_.resize(size);
    return same;
}

Result<H5Column> H5Column::open(const H5File& file, H5Object dataset) {
    if (dataset.group) return corrupt(dataset, "is a group where a dataset was expected");
    const hid_t id = dataset.handle.get();
    const H5Handle creation(H5Dget_create_plist(id), H5Pclose);
    if (!creation.ok()) return corrupt(dataset, "its layout cannot be read");
    MOTE_RETURN_IF_ERROR(checkOrigin(dataset, creation.get()));
    H5Column column;
    column.type_ = H5Handle(H5Dget_type(id), H5Tclose);
    column.space_ = H5Handle(H5Dget_space(id), H5Sclose);
    if (!column.type_.ok() || !column.space_.ok()) {
        return corrupt(dataset, "its type or extent cannot be read");
    }
    const H5T_class_t kind = H5Tget_class(column.type_.get());
    if (kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM) {
        return unsupported(dataset, "holds no plain numbers");
    }
    column.valueBytes_ = H5Tget_size(column.type_.get());
    if (column.valueBytes_ == 0 || column.valueBytes_ > maxValueBytes) {
        return corrupt(dataset, "has numbers of an impossible size");
    }
    column.signed_ = kind == H5T_INTEGER && H5Tget_sign(column.type_.get()) == H5T_SGN_2;
    MOTE_RETURN_IF_ERROR(column.setExtent(dataset));
    std::uint64_t ratio = 1;
    if (H5Pget_layout(creation.get()) == H5D_CHUNKED) {
        MOTE_ASSIGN_OR_RETURN(auto chunks,
                              H5Chunks::open(dataset, column.axis_, column.valueBytes_, file.bytes()));
        ratio = chunks.greatestRatio();
        column.chunks_ = std::make_unique<H5Chunks>(std::move(chunks));
    }
    if (column.rows_ > 0) {
        MOTE_RETURN_IF_ERROR(checkSize(file, dataset, ratio, column.rows_, column.valueBytes_));
    }
    column.dataset_ = std::move(dataset);
    return column;
}

Status H5Column::setExtent(const H5Object& dataset) {
    MOTE_ASSIGN_OR_RETURN(const auto extent, extentOf(dataset, space_.get()));
    rank_ = static_cast<int>(extent.size());
    rows_ = 1;
    for (std::size_t i = 0; i < extent.size(); ++i) {
        const hsize_t length = extent[i];
        if (length == 1) continue;
        if (rows_ != 1) return unsupported(dataset, "is a table of several dimensions, not one column");
        rows_ = length;
        axis_ = static_cast<int>(i);
    }
    return success();
}

Status H5Column::read(std::uint64_t begin, std::size_t count, double* values) const {
    return readAs(H5T_NATIVE_DOUBLE, begin, count, values);
}

Status H5Column::read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const {
    return readAs(signed_ ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, begin, count, values);
}

Status H5Column::readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const {
    if (count == 0) return success();
    silenceHdf5();
    if (begin > rows_ || count > rows_ - begin) {
        return corrupt(dataset_, "has " + std::to_string(rows_) + " values; more were asked for");
    }
    return chunks_ ? readChunks(memoryType, begin, count, values)
                   : readPlain(memoryType, begin, count, values);
}

Status H5Column::readChunks(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const {
    std::vector<std::uint8_t> bytes;
    MOTE_RETURN_IF_ERROR(chunks_->read(dataset_.handle.get(), begin, count, bytes, dataset_.where));
    const std::size_t memoryBytes = H5Tget_size(memoryType);
    bytes.resize(count * std::max(valueBytes_, memoryBytes));  // converted where it stands
    if (H5Tconvert(type_.get(), memoryType, count, bytes.data(), nullptr, H5P_DEFAULT) < 0) {
        return corrupt(dataset_, "its numbers cannot be converted");
    }
    std::memcpy(values, bytes.data(), count * memoryBytes);
    return success();
}

Status H5Column::readPlain(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const {
    const hsize_t length = count;
    const H5Handle memory(H5Screate_simple(1, &length, nullptr), H5Sclose);
    if (rank_ > 0) {
        std::array<hsize_t, H5S_MAX_RANK> start{}, size{};
        size.fill(1);
        start[static_cast<std::size_t>(axis_)] = begin;
        size[static_cast<std::size_t>(axis_)] = length;
        if (H5Sselect_hyperslab(space_.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr) <
            0) {
            return corrupt(dataset_, "its extent is damaged");
        }
    }
    const hid_t selection = rank_ > 0 ? space_.get() : H5S_ALL;
    if (!memory.ok() ||
        H5Dread(dataset_.handle.get(), memoryType, memory.get(), selection, H5P_DEFAULT, values) < 0) {
        return corrupt(dataset_,
                       "rows from " + std::to_string(begin) + " on cannot be read: the file is damaged");
    }
    return success();
}

}  // namespace mote::prep
