// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace mote::prep {
namespace {

struct MarkKind {
    DicomMark mark;
    const char* name;
    double seconds;  ///< its unit, where it is a time; else 0
};
/// Those that say most come first; a time of the day last, as slices have their own.
constexpr std::array<MarkKind, dicomMarks> kinds{{{DicomMark::segment, "segment number", 0.0},
                                                  {DicomMark::temporal, "temporal position", 0.0},
                                                  {DicomMark::frameTime, "frame reference time", 1e-3},
                                                  {DicomMark::trigger, "trigger time", 1e-3},
                                                  {DicomMark::echo, "echo time", 0.0},
                                                  {DicomMark::diffusion, "diffusion b-value", 0.0},
                                                  {DicomMark::acquisition, "acquisition number", 0.0},
                                                  {DicomMark::kind, "image type", 0.0},
                                                  {DicomMark::clock, "acquisition time", 1.0}}};

std::optional<double> markOf(const DicomPicture& picture, DicomMark mark) {
    return picture.at.marks[static_cast<std::size_t>(mark)];
}

/// Sorts each place by a mark; false where it does not tell all volumes apart in the same way everywhere.
bool sortBy(DicomMark mark, std::vector<DicomPlace>& places) {
    const auto least = [&](const DicomPicture& a, const DicomPicture& b) {
        return *markOf(a, mark) < *markOf(b, mark);
    };
    std::vector<double> wanted;
    for (auto& place : places) {
        for (const auto& picture : place) {
            if (!markOf(picture, mark)) return false;
        }
        std::stable_sort(place.begin(), place.end(), least);
        std::vector<double> there;
        there.reserve(place.size());
        for (const auto& picture : place) there.push_back(*markOf(picture, mark));
        if (std::adjacent_find(there.begin(), there.end()) != there.end()) return false;
        if (wanted.empty()) wanted = there;
        if (there != wanted) return false;
    }
    return true;
}

void sortByNumber(const DicomSet& set, std::vector<DicomPlace>& places) {
    for (auto& place : places) {
        std::stable_sort(place.begin(), place.end(), [&](const DicomPicture& a, const DicomPicture& b) {
            const double first = set.headers[a.file].instance.value_or(0.0);
            const double second = set.headers[b.file].instance.value_or(0.0);
            return first != second ? first < second : a.frame < b.frame;
        });
    }
}

/// All places have as many pictures as the first one.
Status checkCounts(const DicomSet& set, const std::vector<DicomPlace>& places) {
    const auto [least, most] =
        std::minmax_element(places.begin(), places.end(),
                            [](const DicomPlace& a, const DicomPlace& b) { return a.size() < b.size(); });
    if (least->size() == most->size()) return success();
    const auto& a = (*most)[0];
    const auto& b = (*most)[1];
    return Error{
        ErrorCode::corrupt, set.name,
        fmt::format("has {} pictures at one place ({}, {}) and {} at another ({}): a slice is there twice "
                    "or missing",
                    most->size(), set.files[a.file].name(), set.files[b.file].name(), least->size(),
                    set.files[least->front().file].name())};
}

}  // namespace

Result<DicomVolumes> tellApart(const DicomSet& set, std::vector<DicomPlace> places) {
    MOTE_RETURN_IF_ERROR(checkCounts(set, places));
    DicomVolumes told;
    const std::size_t count = places.front().size();
    const MarkKind* by = nullptr;
    if (count > 1) {
        const auto* const found = std::find_if(
            kinds.begin(), kinds.end(), [&](const MarkKind& kind) { return sortBy(kind.mark, places); });
        by = found == kinds.end() ? nullptr : found;
        if (by == nullptr) sortByNumber(set, places);
        told.note =
            fmt::format("has {} pictures at each place: they are as many volumes, told apart by their {}",
                        count, by == nullptr ? "numbers" : by->name);
    }
    told.volumes.resize(count);
    told.times.resize(count);
    for (const auto& place : places) {
        for (std::size_t i = 0; i < count; ++i) told.volumes[i].push_back(place[i]);
    }
    for (std::size_t i = 0; by != nullptr && by->seconds > 0.0 && i < count; ++i) {
        const auto first = markOf(told.volumes[0].front(), by->mark),
                   here = markOf(told.volumes[i].front(), by->mark);
        told.times[i] = (*here - *first) * by->seconds;
    }
    return told;
}

}  // namespace mote::prep
