// SPDX-License-Identifier: GPL-3.0-or-later
//
// The points are cut into parts. Within one, the rows of each group are gathered until they fill a block:
// which rows are in which block depends on nothing but the points.
#include "storage/numbers/row_walk.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t mostParts = 64;
constexpr std::size_t blockRows = 4096;  // of one group
constexpr std::size_t groupRows = 512;   // of one of several
constexpr std::array<const char*, BeamRows::coordinates + 1> names{"x",  "y",  "z",  "t",
                                                                   "px", "py", "pz", "weight"};

}  // namespace

/// Rows of one group that are not yet a block.
class RowWalk::Buffer {
  public:
    void take(std::size_t thread, std::uint32_t group, const RowWalk& walk, const Take& take,
              std::uint64_t part) {
        if (size_ == 0) return;
        BeamRows rows;
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (!walk.sources_[c]) continue;
            const auto values = std::span<const double>(columns_[c]).first(size_);
            (c < BeamRows::coordinates ? rows.coordinate[c] : rows.weight) = values;
        }
        rows.size = size_;
        rows.block = part << 40U | blocks_++;
        take(thread, group, rows);
        size_ = 0;
    }

    std::array<std::vector<double>, columnsOfRow> columns_;
    std::size_t size_ = 0;
    std::uint64_t blocks_ = 0;
};

RowWalk::RowWalk(const ParticleColumns& columns, const PointMask* chosen, const BinAxis* groups,
                 const QuantityReader* quantities)
    : columns_(columns), chosen_(chosen), groups_(groups), quantities_(quantities) {
    sources_.back() = columns.find(names.back());
    for (std::size_t c = 0; c + 1 < columnsOfRow; ++c) {
        if (quantities == nullptr) sources_[c] = columns.find(names[c]);
        if (quantities != nullptr && c < quantities->size()) sources_[c] = c;
    }
}

std::size_t RowWalk::threads() {
    return static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency())) + 1;
}

/// A part of the points, on one thread.
class RowWalk::Part {
  public:
    Part(const RowWalk& walk, const Take& take, std::uint64_t part, std::size_t thread)
        : walk_(walk),
          take_(take),
          part_(part),
          thread_(thread),
          capacity_(walk.groups() > 1 ? groupRows : blockRows),
          buffers_(walk.groups()) {}

    void add(PointRange block) {
        chosen_.clear();
        if (walk_.chosen_ != nullptr) {
            const auto words = std::span(walk_.chosen_->words())
                                   .subspan(block.begin / PointMask::wordBits, wordCount(block.count));
            forEachChosen(words, [&](std::size_t i) { chosen_.push_back(static_cast<std::uint32_t>(i)); });
            if (chosen_.empty()) return;
        }
        if (walk_.quantities_ != nullptr) lookAtQuantities(block);
        for (std::size_t c = walk_.quantities_ != nullptr ? columnsOfRow - 1 : 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c]) look(*walk_.sources_[c], block, stored_[c]);
        }
        if (walk_.groups_ == nullptr) return addAll(block);
        bins_.resize(block.count);
        walk_.groups_->find(block, scratch_, bins_);
        const auto one = [&](std::size_t i) {
            if (bins_[i] < walk_.groups()) addOne(buffers_[bins_[i]], bins_[i], i);
        };
        if (walk_.chosen_ != nullptr) {
            for (const auto i : chosen_) one(i);
        } else {
            for (std::size_t i = 0; i < block.count; ++i) one(i);
        }
    }

    void finish() {
        for (std::uint32_t group = 0; group < buffers_.size(); ++group)
            buffers_[group].take(thread_, group, walk_, take_, part_);
    }

  private:
    /// A column of the block, as it lies in the file.
    struct Stored {
        double offset = 0.0;
        std::span<const float> floats;
        std::span<const double> doubles;  ///< instead

        double at(std::size_t i) const {
            return doubles.empty() ? offset + static_cast<double>(floats[i]) : doubles[i];
        }
    };

    void look(std::size_t column, PointRange block, Stored& stored) const {
        const auto& info = walk_.columns_.columns()[column];
        stored.offset = info.offset;
        if (info.doubles)
            stored.doubles = walk_.columns_.doubles(column, block.begin, block.count);
        else
            stored.floats = walk_.columns_.values(column, block.begin, block.count);
    }

    void lookAtQuantities(PointRange block) {
        std::vector<std::span<double>> out;
        for (std::size_t c = 0; c < walk_.quantities_->size(); ++c) {
            made_[c].resize(block.count);
            out.emplace_back(made_[c]);
            stored_[c].doubles = made_[c];
        }
        walk_.quantities_->read(block.begin, block.count, quantityScratch_, out);
    }

    void reserve(Buffer& buffer) const {
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c] && buffer.columns_[c].empty()) buffer.columns_[c].resize(capacity_);
        }
    }

    void addOne(Buffer& buffer, std::uint32_t group, std::size_t i) {
        reserve(buffer);
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c]) buffer.columns_[c][buffer.size_] = stored_[c].at(i);
        }
        if (++buffer.size_ == capacity_) buffer.take(thread_, group, walk_, take_, part_);
    }

    /// All chosen points are of one group: column by column.
    void addAll(PointRange block) {
        auto& buffer = buffers_.front();
        reserve(buffer);
        const std::size_t total = walk_.chosen_ != nullptr ? chosen_.size() : block.count;
        for (std::size_t done = 0; done < total;) {
            const auto count = std::min(total - done, capacity_ - buffer.size_);
            for (std::size_t c = 0; c < columnsOfRow; ++c) {
                if (!walk_.sources_[c]) continue;
                auto* const out = buffer.columns_[c].data() + buffer.size_;
                if (stored_[c].doubles.empty())
                    append(stored_[c].floats, stored_[c].offset, done, count, out);
                else
                    append(stored_[c].doubles, 0.0, done, count, out);
            }
            done += count;
            buffer.size_ += count;
            if (buffer.size_ == capacity_) buffer.take(thread_, 0, walk_, take_, part_);
        }
    }

    template <class T>
    void append(std::span<const T> in, double zero, std::size_t done, std::size_t count, double* out) const {
        if (walk_.chosen_ != nullptr) {
            for (std::size_t k = 0; k < count; ++k)
                out[k] = zero + static_cast<double>(in[chosen_[done + k]]);
        } else {
            for (std::size_t k = 0; k < count; ++k) out[k] = zero + static_cast<double>(in[done + k]);
        }
    }

    const RowWalk& walk_;
    const Take& take_;
    const std::uint64_t part_;
    const std::size_t thread_;
    const std::size_t capacity_;
    std::vector<Buffer> buffers_;  // by group
    std::vector<std::uint32_t> chosen_, bins_;
    std::array<Stored, columnsOfRow> stored_;
    std::array<std::vector<double>, 2> made_;  ///< of the quantities
    QuantityReader::Scratch quantityScratch_;
    BinAxis::Scratch scratch_;
};

bool RowWalk::walk(const std::function<bool()>& cancelled, const Take& take) const {
    const auto points = columns_.pointCount();
    const auto blocks = blockCount(points);
    const auto parts = std::min(mostParts, blocks);
    std::atomic<bool> stop{false};
    const auto stopNow = [&] { return stop || (cancelled && cancelled()); };
    const bool whole = forBlocks(parts, stopNow, [&](std::uint64_t index) {
        const auto thread =
            static_cast<std::size_t>(std::max(0, tbb::this_task_arena::current_thread_index()));
        Part part(*this, take, index, thread);
        for (auto block = index * blocks / parts; block < (index + 1) * blocks / parts; ++block) {
            if (stopNow()) {
                stop = true;
                return;
            }
            part.add(pointsOfBlock(block, points));
        }
        part.finish();
    });
    return whole && !stop;
}

}  // namespace mote::storage
