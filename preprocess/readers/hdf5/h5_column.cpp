// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/hdf5/h5_column.h"

#include <algorithm>
#include <string>
#include <vector>

namespace mote::prep {

Result<H5Column> H5Column::open(const H5File& file, H5Object dataset) {
    MOTE_ASSIGN_OR_RETURN(auto numbers, H5Numbers::open(file, std::move(dataset), true));
    H5Column column(std::move(numbers));
    const auto& extent = column.numbers_.extent();
    for (std::size_t i = 0; i < extent.size(); ++i) {
        if (extent[i] == 1) continue;
        column.rows_ = extent[i];
        column.axis_ = i;
    }
    return column;
}

Status H5Column::read(std::uint64_t begin, std::size_t count, double* values) const {
    if (!numbers_.isNativeFloat()) return readAs(H5T_NATIVE_DOUBLE, begin, count, values);
    // HDF5 converts in a buffer of its own and copies twice: three times as slow.
    floats_.resize(count);
    MOTE_RETURN_IF_ERROR(readAs(H5T_NATIVE_FLOAT, begin, count, floats_.data()));
    std::copy(floats_.begin(), floats_.end(), values);
    return success();
}

Status H5Column::read(std::uint64_t begin, std::size_t count, std::uint64_t* values) const {
    return readAs(numbers_.isSigned() ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, begin, count, values);
}

Status H5Column::readAs(hid_t memoryType, std::uint64_t begin, std::size_t count, void* values) const {
    if (count == 0) return success();
    if (begin > rows_ || count > rows_ - begin) {
        return corrupt(object().where, "has " + std::to_string(rows_) + " values; more were asked for");
    }
    std::vector<hsize_t> first(numbers_.extent().size(), 0), size(first.size(), 1);
    if (!first.empty()) {
        first[axis_] = begin;
        size[axis_] = count;
    }
    return numbers_.read(first, size, memoryType, values);
}

}  // namespace mote::prep
