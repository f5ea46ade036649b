// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_numbers.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

namespace mote::prep {
namespace {

constexpr std::size_t maxValueBytes = 16;

Error corruptObject(const H5Object& object, std::string message) {
    return {ErrorCode::corrupt, object.where, std::move(message)};
}

Error unsupportedObject(const H5Object& object, std::string message) {
    return {ErrorCode::unsupported, object.where, std::move(message)};
}

Result<std::vector<hsize_t>> extentOf(const H5Object& dataset, hid_t space) {
    const int rank = H5Sget_simple_extent_ndims(space);
    const H5S_class_t kind = H5Sget_simple_extent_type(space);
    if (rank < 0 || rank > H5S_MAX_RANK || kind == H5S_NO_CLASS)
        return corruptObject(dataset, "has no valid extent");
    if (kind == H5S_NULL) return std::vector<hsize_t>{0};
    std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
    if (rank > 0 && H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0) {
        return corruptObject(dataset, "has no valid extent");
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
        return unsupportedObject(dataset, "is a virtual dataset, whose data lies in other files");
    }
    if (H5Pget_external_count(creation) != 0) {
        return unsupportedObject(dataset, "keeps its data in another file, which is not opened");
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
    return corruptObject(
        dataset, "declares " + std::to_string(declared) + " bytes and holds " +
                     std::to_string(std::min(stored, file.bytes())) +
                     (stored == 0 ? ": nothing was written to it" : ": the file is cut short or damaged"));
}

/// Where the values of a contiguous dataset lie, if all `bytes` of them lie within the file. HDF5 believes
/// what the file says of it.
std::optional<std::uint64_t> offsetOf(const H5File& file, const H5Object& dataset, std::uint64_t bytes) {
    const haddr_t offset = H5Dget_offset(dataset.handle.get());
    if (offset == HADDR_UNDEF || offset > file.bytes() || bytes > file.bytes() - offset) return std::nullopt;
    return offset;
}

/// The next place of a box, the last dimension first; false behind the last one. `step` along each dimension.
bool advance(std::vector<hsize_t>& place, std::span<const hsize_t> begin, std::span<const hsize_t> end,
             std::span<const hsize_t> step, std::size_t dimensions) {
    for (std::size_t i = dimensions; i-- > 0;) {
        place[i] += step[i];
        if (place[i] < end[i]) return true;
        place[i] = begin[i];
    }
    return false;
}

/// What a box and a chunk have in common, and how it is copied from one to the other.
class ChunkPart {
  public:
    ChunkPart(std::span<const hsize_t> first, std::span<const hsize_t> count,
              const std::vector<hsize_t>& chunk, const std::vector<hsize_t>& shape)
        : first_(first),
          count_(count),
          chunk_(chunk),
          shape_(shape),
          begin_(first.size()),
          end_(first.size()) {
        for (std::size_t i = 0; i < first.size(); ++i) {
            begin_[i] = std::max(first[i], chunk[i]);
            end_[i] = std::min(first[i] + count[i], chunk[i] + shape[i]);
        }
    }

    void copy(std::span<const std::uint8_t> from, std::vector<std::uint8_t>& to,
              std::size_t valueBytes) const {
        const auto last = first_.size() - 1;
        const std::size_t run = (end_[last] - begin_[last]) * valueBytes;
        const std::vector<hsize_t> ones(first_.size(), 1);
        auto place = begin_;
        do {
            std::memcpy(to.data() + offset(place, first_, count_) * valueBytes,
                        from.data() + offset(place, chunk_, shape_) * valueBytes, run);
        } while (advance(place, begin_, end_, ones, last));
    }

  private:
    static std::size_t offset(const std::vector<hsize_t>& place, std::span<const hsize_t> origin,
                              std::span<const hsize_t> size) {
        std::size_t at = 0;
        for (std::size_t i = 0; i < place.size(); ++i) at = at * size[i] + (place[i] - origin[i]);
        return at;
    }

    std::span<const hsize_t> first_, count_;
    const std::vector<hsize_t>&chunk_, &shape_;
    std::vector<hsize_t> begin_, end_;
};

std::size_t product(std::span<const hsize_t> counts) {
    std::size_t all = 1;
    for (const auto count : counts) all *= count;
    return all;
}

}  // namespace

Result<H5Numbers> H5Numbers::open(const H5File& file, H5Object dataset, bool column) {
    if (dataset.group) return corruptObject(dataset, "is a group where a dataset was expected");
    const hid_t id = dataset.handle.get();
    const H5Handle creation(H5Dget_create_plist(id), H5Pclose);
    if (!creation.ok()) return corruptObject(dataset, "its layout cannot be read");
    MOTE_RETURN_IF_ERROR(checkOrigin(dataset, creation.get()));
    H5Numbers numbers;
    numbers.type_ = H5Handle(H5Dget_type(id), H5Tclose);
    numbers.space_ = H5Handle(H5Dget_space(id), H5Sclose);
    if (!numbers.type_.ok() || !numbers.space_.ok()) {
        return corruptObject(dataset, "its type or extent cannot be read");
    }
    const H5T_class_t kind = H5Tget_class(numbers.type_.get());
    if (kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM) {
        return unsupportedObject(dataset, "holds no plain numbers");
    }
    numbers.valueBytes_ = H5Tget_size(numbers.type_.get());
    if (numbers.valueBytes_ == 0 || numbers.valueBytes_ > maxValueBytes) {
        return corruptObject(dataset, "has numbers of an impossible size");
    }
    numbers.float_ = kind == H5T_FLOAT;
    numbers.nativeFloat_ = H5Tequal(numbers.type_.get(), H5T_NATIVE_FLOAT) > 0;
    numbers.signed_ = kind == H5T_INTEGER && H5Tget_sign(numbers.type_.get()) == H5T_SGN_2;
    MOTE_ASSIGN_OR_RETURN(numbers.extent_, extentOf(dataset, numbers.space_.get()));
    const auto isLong = [](hsize_t length) { return length != 1; };
    if (column && std::ranges::count_if(numbers.extent_, isLong) > 1)
        return unsupportedObject(dataset, "is a table of several dimensions, not one column");
    if (file.bp()) {
        MOTE_ASSIGN_OR_RETURN(numbers.bp_, BpValues::open(file.bp(), dataset));
        numbers.dataset_ = std::move(dataset);
        return numbers;
    }
    std::uint64_t ratio = 1, values = 1;
    if (H5Pget_layout(creation.get()) == H5D_CHUNKED) {
        MOTE_ASSIGN_OR_RETURN(auto chunks, H5Chunks::open(dataset, numbers.valueBytes_, file.bytes()));
        if (chunks.shape().size() != numbers.extent_.size())
            return corruptObject(dataset, "has chunks of another number of dimensions");
        ratio = chunks.greatestRatio();
        numbers.chunks_ = std::make_unique<H5Chunks>(std::move(chunks));
    }
    for (const auto length : numbers.extent_) values = saturatingProduct(values, length);
    if (values > 0) MOTE_RETURN_IF_ERROR(checkSize(file, dataset, ratio, values, numbers.valueBytes_));
    if (values > 0 && H5Pget_layout(creation.get()) == H5D_CONTIGUOUS)
        numbers.offset_ = offsetOf(file, dataset, values * numbers.valueBytes_);
    numbers.dataset_ = std::move(dataset);
    return numbers;
}

Status H5Numbers::read(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                       void* values) const {
    silenceHdf5();
    for (std::size_t i = 0; i < count.size(); ++i) {
        if (count[i] == 0) return success();
    }
    if (bp_) return readBp(first, count, memoryType, values);
    return chunks_ ? readChunks(first, count, memoryType, values)
                   : readPlain(first, count, memoryType, values);
}

Status H5Numbers::readBp(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                         void* values) const {
    const auto all = product(count);
    std::vector<std::uint8_t> bytes(all * std::max(valueBytes_, H5Tget_size(memoryType)));
    MOTE_RETURN_IF_ERROR(bp_->read(first, count, bytes.data(), dataset_.where));
    return convert(bytes, all, memoryType, values);
}

/// Numbers as the file has them, in place, and from there.
Status H5Numbers::convert(std::vector<std::uint8_t>& bytes, std::size_t count, hid_t memoryType,
                          void* values) const {
    if (H5Tconvert(type_.get(), memoryType, count, bytes.data(), nullptr, H5P_DEFAULT) < 0) {
        return corruptObject(dataset_, "its numbers cannot be converted");
    }
    std::memcpy(values, bytes.data(), count * H5Tget_size(memoryType));
    return success();
}

Status H5Numbers::readChunks(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                             void* values) const {
    const auto& shape = chunks_->shape();
    const auto all = product(count);
    std::vector<std::uint8_t> bytes(all * std::max(valueBytes_, H5Tget_size(memoryType)));
    std::vector<hsize_t> begin(first.size()), end(first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
        begin[i] = first[i] / shape[i] * shape[i];
        end[i] = first[i] + count[i];
    }
    auto chunk = begin;
    do {
        MOTE_RETURN_IF_ERROR(chunks_->load(dataset_.handle.get(), chunk, dataset_.where, chunk_));
        ChunkPart(first, count, chunk, shape).copy(chunk_.bytes, bytes, valueBytes_);
    } while (advance(chunk, begin, end, shape, chunk.size()));
    return convert(bytes, all, memoryType, values);
}

Status H5Numbers::readPlain(std::span<const hsize_t> first, std::span<const hsize_t> count, hid_t memoryType,
                            void* values) const {
    const hsize_t length = product(count);
    const H5Handle memory(H5Screate_simple(1, &length, nullptr), H5Sclose);
    if (!first.empty() &&
        H5Sselect_hyperslab(space_.get(), H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr) < 0) {
        return corruptObject(dataset_, "its extent is damaged");
    }
    const hid_t selection = first.empty() ? H5S_ALL : space_.get();
    if (!memory.ok() ||
        H5Dread(dataset_.handle.get(), memoryType, memory.get(), selection, H5P_DEFAULT, values) < 0) {
        return corruptObject(
            dataset_, "rows from " + std::to_string(first.empty() ? 0 : *std::ranges::max_element(first)) +
                          " on cannot be read: the file is damaged");
    }
    return success();
}

}  // namespace mote::prep
