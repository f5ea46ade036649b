// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/reference_track.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "preprocess/readers/text/line_reader.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/text/row_file.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxPoints = 20'000'000;

}  // namespace

ReferenceTrack::Point ReferenceTrack::at(double path) const {
    const auto after =
        std::upper_bound(points.begin(), points.end(), path,
                         [](double wanted, const Point& point) { return wanted < point.path; });
    if (after == points.begin()) return points.front();
    const Point& left = *std::prev(after);
    if (after == points.end()) return left;
    const double part = (path - left.path) / (after->path - left.path);
    return {path, left.phase + part * (after->phase - left.phase),
            left.gamma + part * (after->gamma - left.gamma)};
}

Result<ReferenceTrack> ReferenceTrack::read(const std::filesystem::path& path) {
    auto reader = LineReader::open(path);
    if (!reader) return reader.error();
    ReferenceTrack track;
    for (std::string_view line;;) {
        const auto more = reader->next(line);
        if (!more) return more.error();
        if (!*more) break;
        if (!isRow(line)) continue;
        std::array<std::string_view, 3> fields;
        const std::size_t count = splitFields(line, ' ', fields);
        std::array<double, 3> values{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto value = i < count ? parseNumber(fields[i]) : std::nullopt;
            if (!value || !std::isfinite(*value) || (i == 2 && *value < 1.0)) {
                return Error{ErrorCode::corrupt,
                             reader->name() + ": line " + std::to_string(reader->lineNumber()),
                             "does not begin with path, phase and gamma"};
            }
            values[i] = *value;
        }
        if (!track.points.empty() && values[0] < track.points.back().path) track.points.clear();
        if (track.points.size() >= maxPoints) {
            return Error{ErrorCode::resourceExhausted, reader->name(), "has more than 20 million lines"};
        }
        track.points.push_back({values[0], values[1], values[2]});
    }
    if (track.points.empty()) return Error{ErrorCode::corrupt, reader->name(), "holds no reference particle"};
    return track;
}

}  // namespace mote::prep
