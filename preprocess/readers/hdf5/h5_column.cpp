// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_column.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace mote::prep {
namespace {

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
        auto chunks = H5Chunks::open(dataset, column.axis_, column.valueBytes_, file.bytes());
        if (!chunks) return chunks.error();
        ratio = chunks->greatestRatio();
        column.chunks_ = std::make_unique<H5Chunks>(std::move(*chunks));
    }
    if (column.rows_ > 0) {
        MOTE_RETURN_IF_ERROR(checkSize(file, dataset, ratio, column.rows_, column.valueBytes_));
    }
    column.dataset_ = std::move(dataset);
    return column;
}

Status H5Column::setExtent(const H5Object& dataset) {
    const auto extent = extentOf(dataset, space_.get());
    if (!extent) return extent.error();
    rank_ = static_cast<int>(extent->size());
    rows_ = 1;
    for (std::size_t i = 0; i < extent->size(); ++i) {
        const hsize_t length = (*extent)[i];
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
