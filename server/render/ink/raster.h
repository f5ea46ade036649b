// SPDX-License-Identifier: GPL-3.0-or-later
//
// Raster: a picture of one value a pixel, row 0 on top. A value, of which a large one is made in turns
// (plan/long_list.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/render/plan/long_list.h"

namespace mote::render {

template <class T>
struct Raster {
    std::uint32_t width = 0, height = 0;
    std::vector<T> values;  ///< [height][width]

    Raster() = default;
    Raster(std::uint32_t columns, std::uint32_t rows, T fill = T())
        : width(columns), height(rows), values(listInTurns(std::size_t{columns} * rows, fill)) {}

    Raster copy() const {
        Raster made;
        made.width = width;
        made.height = height;
        made.values = copyInTurns(values);
        return made;
    }

    std::size_t index(std::uint32_t column, std::uint32_t row) const {
        return std::size_t{row} * width + column;
    }
    T& at(std::uint32_t column, std::uint32_t row) { return values[index(column, row)]; }
    const T& at(std::uint32_t column, std::uint32_t row) const { return values[index(column, row)]; }
    /// Where a place of the picture lies that may be outside it: the nearest pixel's.
    const T& near(double x, double y) const;

    bool operator==(const Raster&) const = default;
};

template <class T>
const T& Raster<T>::near(double x, double y) const {
    const auto inside = [](double place, std::uint32_t size) {
        if (!(place > 0.0)) return std::uint32_t{0};
        return place < size ? static_cast<std::uint32_t>(place) : size - 1;
    };
    return at(inside(x, width), inside(y, height));
}

}  // namespace mote::render
