// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/series_source.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numeric>

namespace mote::prep {
namespace {

constexpr std::size_t maxRowsAtOnce = std::size_t{1} << 22;

bool isDigit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// The name without endings that start with a letter: "fort.101.txt.gz" becomes "fort.101".
std::string withoutEndings(std::string name) {
    for (std::size_t dot = name.rfind('.'); dot != std::string::npos && dot > 0; dot = name.rfind('.')) {
        if (dot + 1 < name.size() && isDigit(name[dot + 1])) break;
        name.resize(dot);
    }
    return name;
}

}  // namespace

std::optional<std::int64_t> fileNumber(const std::filesystem::path& path) {
    const std::string name = withoutEndings(path.filename().string());
    std::size_t end = name.size();
    while (end > 0 && !isDigit(name[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && isDigit(name[begin - 1])) --begin;
    std::int64_t number = 0;
    const auto [last, code] = std::from_chars(name.data() + begin, name.data() + end, number);
    if (code != std::errc() || last != name.data() + end) return std::nullopt;
    return number;
}

std::vector<std::filesystem::path> inOrder(std::vector<std::filesystem::path> files) {
    return inOrder(std::move(files), fileNumber);
}

std::vector<std::filesystem::path> inOrder(
    std::vector<std::filesystem::path> files,
    std::optional<std::int64_t> (*numberOf)(const std::filesystem::path& path)) {
    std::set<std::int64_t> numbers;
    for (const auto& file : files) {
        if (const auto number = numberOf(file)) numbers.insert(*number);
    }
    if (numbers.size() == files.size()) {
        std::sort(files.begin(), files.end(),
                  [&](const auto& a, const auto& b) { return *numberOf(a) < *numberOf(b); });
    }
    return files;
}

Status SeriesSource::read(std::size_t step, std::uint64_t begin, std::size_t count,
                          const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (step >= steps_.size()) return invalid("", "there is no such step");
    const std::uint64_t rows = steps_[step].particles;
    if (count > maxRowsAtOnce || begin > rows || count > rows - begin) {
        return invalid(steps_[step].file,
                       "rows that the step does not have, or too many at once, were asked for");
    }
    chunk.begin = begin;
    chunk.size = count;
    chunk.lost.assign(count, 0);
    for (const Column column : wanted) {
        if (column == Column::id) {
            chunk.id.resize(count);
            std::iota(chunk.id.begin(), chunk.id.end(), begin);
        } else if (column == Column::weight) {
            chunk[column].assign(count, 1.0);
        } else if (isRecord(column) || has(column)) {
            chunk[column].resize(count);
        } else {
            return invalid(steps_[step].file, "has not all columns that were asked for");
        }
    }
    return readRows(step, wanted, chunk);
}

SourceStep SeriesSource::stepOf(const std::filesystem::path& file, std::uint64_t particles,
                                double time) const {
    return {file.filename().string(), fileNumber(file).value_or(static_cast<std::int64_t>(steps_.size())),
            time, particles};
}

Status SeriesSource::leaveOut(const Status& opened) {
    if (opened.ok()) return opened;
    const ErrorCode code = opened.error().code;
    if (code != ErrorCode::corrupt && code != ErrorCode::unsupported && code != ErrorCode::notFound) {
        return opened;
    }
    if (!firstOdd_) firstOdd_ = opened.error();
    ++odd_;
    return success();
}

Status SeriesSource::noteLeftOut() const {
    if (!firstOdd_) return success();
    if (!anyRead()) return *firstOdd_;
    progress_.note(
        (odd_ == 1 ? std::string("a step cannot be read and is left out: ")
                   : std::to_string(odd_) + " steps cannot be read and are left out, the first of them: ") +
        firstOdd_->toString());
    return success();
}

std::vector<std::size_t> SeriesSource::orderOfIterations() const {
    std::vector<std::size_t> order(steps_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return steps_[a].iteration < steps_[b].iteration; });
    return order;
}

Result<std::unique_ptr<ParticleSource>> openSeries(std::unique_ptr<SeriesSource> source,
                                                   const std::vector<std::filesystem::path>& files) {
    for (const std::filesystem::path& file : files) {
        if (source->progress_.cancelled()) return wasCancelled("cancelled while the steps were listed");
        MOTE_RETURN_IF_ERROR(source->leaveOut(source->addFile(file)));
    }
    MOTE_RETURN_IF_ERROR(source->noteLeftOut());
    MOTE_RETURN_IF_ERROR(source->finish());
    for (std::size_t i = 0; i < columnCount; ++i) {
        source->has_[i] = source->hasEverywhere(static_cast<Column>(i));
    }
    source->records_ = source->recordsEverywhere();
    if (source->records_.size() > mostRecords) {
        source->progress_.note("of " + std::to_string(source->records_.size()) +
                               " columns that are no coordinates the first " + std::to_string(mostRecords) +
                               " can be named, up to " + source->records_[mostRecords - 1].name);
        source->records_.resize(mostRecords);
    }
    return std::unique_ptr<ParticleSource>(std::move(source));
}

}  // namespace mote::prep
