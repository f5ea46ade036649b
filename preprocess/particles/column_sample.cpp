// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/column_sample.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "storage/particles/step_layout.h"

namespace mote::prep {
namespace {

constexpr std::size_t askedEach = 4096;  // rows, between two questions whether to stop

Status readRows(const storage::StepFile& points, std::uint64_t first, std::span<std::uint64_t> rows) {
    return points.read(storage::StepArray::pointRow, first * sizeof(std::uint64_t),
                       std::as_writable_bytes(rows));
}

Status readStrided(const storage::StepFile& points, std::uint64_t stride, std::vector<std::uint64_t>& rows,
                   const Progress& progress) {
    const std::size_t parts = (rows.size() + askedEach - 1) / askedEach;
    std::vector<Status> read(parts, success());
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
        if (progress.cancelled()) read[part] = cancelledError();
        const std::size_t end = std::min(rows.size(), (part + 1) * askedEach);
        for (std::size_t i = part * askedEach; i < end && read[part].ok(); ++i)
            read[part] = readRows(points, i * stride, std::span(rows).subspan(i, 1));
    });
    for (const auto& status : read) MOTE_RETURN_IF_ERROR(status);
    return success();
}

}  // namespace

ColumnSample::ColumnSample(ColumnSample&& other) noexcept
    : wanted_(std::move(other.wanted_)),
      lost_(other.lost_),
      row_(std::move(other.row_)),
      taken_(std::move(other.taken_)),
      chunk_(std::move(other.chunk_)),
      leastWeight_(other.leastWeight_),
      greatestWeight_(other.greatestWeight_) {}

Result<ColumnSample> ColumnSample::make(const storage::StepFile& points, std::uint64_t pointCount,
                                        std::vector<Column> wanted, LostParticles lost,
                                        const Progress& progress) {
    ColumnSample sample;
    sample.lost_ = lost;
    sample.wanted_ = std::move(wanted);
    const std::uint64_t stride = std::max<std::uint64_t>(1, (pointCount + most - 1) / most);
    sample.row_.resize((pointCount + stride - 1) / stride);
    if (stride == 1) MOTE_RETURN_IF_ERROR(readRows(points, 0, sample.row_));
    if (stride > 1) MOTE_RETURN_IF_ERROR(readStrided(points, stride, sample.row_, progress));
    std::sort(sample.row_.begin(), sample.row_.end());
    sample.taken_.assign(sample.row_.size(), 0);
    sample.chunk_.size = sample.row_.size();
    for (const auto column : sample.wanted_) {
        if (column != Column::id) sample.chunk_[column].resize(sample.row_.size());
    }
    return sample;
}

void ColumnSample::take(const ParticleChunk& chunk) {
    const auto first = std::ranges::lower_bound(row_, chunk.begin);
    const auto last = std::lower_bound(first, row_.end(), chunk.begin + chunk.size);
    for (auto it = first; it != last; ++it) {
        const auto i = static_cast<std::size_t>(it - row_.begin());
        for (const auto column : wanted_) {
            if (column != Column::id) chunk_[column][i] = chunk[column][*it - chunk.begin];
        }
        taken_[i] = 1;
    }
    const auto& weights = chunk[Column::weight];
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (std::size_t i = 0; i < std::min(chunk.size, weights.size()); ++i) {
        if (!takesPart(lost_, i < chunk.lost.size() && chunk.lost[i] != 0)) continue;
        least = std::min(least, weights[i]);
        greatest = std::max(greatest, weights[i]);
    }
    const std::lock_guard lock(mutex_);
    leastWeight_ = std::min(leastWeight_, least);
    greatestWeight_ = std::max(greatestWeight_, greatest);
}

Status ColumnSample::share(Communicator& ranks) {
    for (const auto column : wanted_) {
        if (column == Column::id) continue;
        std::vector<double> mine;
        for (std::size_t i = 0; i < row_.size(); ++i) {
            if (taken_[i] != 0) mine.push_back(chunk_[column][i]);
        }
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<double>(ranks, mine));
        chunk_[column].clear();
        for (const auto& part : all) {
            chunk_[column].insert(chunk_[column].end(), part.begin(), part.end());
        }
        chunk_.size = chunk_[column].size();
    }
    const std::array ends{leastWeight_, greatestWeight_};
    MOTE_ASSIGN_OR_RETURN(const auto weights, shareValues<double>(ranks, ends));
    for (const auto& part : weights) {
        leastWeight_ = std::min(leastWeight_, part[0]);
        greatestWeight_ = std::max(greatestWeight_, part[1]);
    }
    return success();
}

}  // namespace mote::prep
