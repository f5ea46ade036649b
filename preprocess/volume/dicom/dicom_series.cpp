// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "preprocess/volume/volume_shape.h"

namespace mote::prep {
namespace {

constexpr std::size_t mostSeries = 4096, mostListed = 12;
// Of cosines: programs write them with five digits and more.
constexpr double sameCosine = 1e-3;
constexpr double sameSpacing = 1e-3;  // of itself

/// What one frame says, and the file for all where it says nothing.
DicomFrame merged(const DicomFrame& common, DicomFrame frame) {
    const auto fill = [](auto& value, const auto& otherwise) {
        if (!value) value = otherwise;
    };
    fill(frame.position, common.position);
    fill(frame.orientation, common.orientation);
    fill(frame.pixelSpacing, common.pixelSpacing);
    fill(frame.between, common.between);
    fill(frame.thickness, common.thickness);
    fill(frame.slope, common.slope);
    fill(frame.intercept, common.intercept);
    for (std::size_t i = 0; i < dicomMarks; ++i) fill(frame.marks[i], common.marks[i]);
    return frame;
}

/// Frames of a file that says one place lie behind it: at their offsets, or as far apart as slices are.
void placeFrames(const DicomHeader& header, std::vector<DicomFrame>& frames) {
    const auto& common = header.common;
    if (frames.size() < 2 || !common.position || !common.orientation) return;
    const auto normal = normalOf(*common.orientation);
    const bool offsets = header.frameOffsets.size() == frames.size();
    const double step = common.between.value_or(common.thickness.value_or(0.0));
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const double along =
            offsets ? header.frameOffsets[i] - header.frameOffsets[0] : step * static_cast<double>(i);
        frames[i].position = *common.position + along * normal;
    }
}

/// The slices of a mosaic. Its position is that of the first pixel of a picture of its size around the middle
/// of the first slice.
std::vector<DicomFrame> tilesOf(const DicomHeader& header) {
    std::vector<DicomFrame> frames(header.tiles.tiles, header.common);
    const auto& at = header.common;
    const auto& [rowX, rowY, rowZ, columnX, columnY, columnZ] = *at.orientation;
    const glm::dvec3 aside =
        0.5 * (header.columns - header.sliceColumns()) * (*at.pixelSpacing)[1] * glm::dvec3(rowX, rowY, rowZ);
    const glm::dvec3 down = 0.5 * (header.rows - header.sliceRows()) * (*at.pixelSpacing)[0] *
                            glm::dvec3(columnX, columnY, columnZ);
    const double step = at.between ? *at.between : *at.thickness;
    for (std::size_t i = 0; i < frames.size(); ++i)
        frames[i].position =
            *at.position + aside + down + static_cast<double>(i) * step * header.tiles.normal;
    return frames;
}

std::vector<DicomFrame> framesOf(const DicomHeader& header) {
    if (header.tiles.tiles > 0) return tilesOf(header);
    std::vector<DicomFrame> frames;
    for (const auto& frame : header.frames) frames.push_back(merged(header.common, frame));
    if (!frames.empty()) return frames;
    frames.assign(std::max(header.frameCount, 1u), header.common);
    placeFrames(header, frames);
    return frames;
}

template <std::size_t count>
bool alike(const std::optional<std::array<double, count>>& a,
           const std::optional<std::array<double, count>>& b, double tolerance) {
    if (!a || !b) return a.has_value() == b.has_value();
    for (std::size_t i = 0; i < count; ++i) {
        if (std::abs((*a)[i] - (*b)[i]) > tolerance) return false;
    }
    return true;
}

bool belongs(const DicomHeader& header, const DicomFrame& frame, const DicomSeries& series) {
    const DicomFrame& first = series.pictures.front().at;
    const double spacing = first.pixelSpacing ? sameSpacing * std::abs((*first.pixelSpacing)[0]) : 0.0;
    return series.uid == header.series && series.columns == header.sliceColumns() &&
           series.rows == header.sliceRows() && alike(first.orientation, frame.orientation, sameCosine) &&
           alike(first.pixelSpacing, frame.pixelSpacing, spacing);
}

Result<std::vector<DicomSeries>> seriesOf(const DicomSet& set) {
    std::vector<DicomSeries> all;
    std::size_t last = 0;
    for (std::size_t file = 0; file < set.files.size(); ++file) {
        const DicomHeader& header = set.headers[file];
        const auto frames = framesOf(header);
        for (std::uint32_t i = 0; i < frames.size(); ++i) {
            // Most are of the same as the one before.
            if (all.empty() || !belongs(header, frames[i], all[last])) {
                const auto found = std::find_if(all.begin(), all.end(), [&](const DicomSeries& each) {
                    return belongs(header, frames[i], each);
                });
                last = static_cast<std::size_t>(found - all.begin());
                if (found == all.end()) {
                    all.push_back({header.series,
                                   header.modality,
                                   header.seriesNumber,
                                   "",
                                   header.sliceColumns(),
                                   header.sliceRows(),
                                   {}});
                }
            }
            all[last].pictures.push_back({file, i, frames[i]});
        }
        if (all.size() <= mostSeries) continue;
        return Error{ErrorCode::resourceExhausted, set.name,
                     fmt::format("holds pictures of more than {} orientations", mostSeries)};
    }
    return all;
}

/// Labels them by the scanner's numbers if these tell all apart, else by their order.
void label(std::vector<DicomSeries>& all) {
    std::stable_sort(all.begin(), all.end(), [](const DicomSeries& a, const DicomSeries& b) {
        return a.number.value_or(INFINITY) < b.number.value_or(INFINITY);
    });
    std::set<double> numbers;
    for (const auto& each : all) {
        if (each.number && std::floor(*each.number) == *each.number) numbers.insert(*each.number);
    }
    const bool distinct = numbers.size() == all.size();
    for (std::size_t i = 0; i < all.size(); ++i) {
        all[i].label = fmt::format("{:.0f}", distinct ? *all[i].number : static_cast<double>(i + 1));
    }
}

std::string listOf(const std::vector<const DicomSeries*>& all) {
    std::string list;
    for (std::size_t i = 0; i < std::min(all.size(), mostListed); ++i) {
        const DicomSeries& each = *all[i];
        list += fmt::format("{}{} ({}, {} {} of {} x {})", i == 0 ? "" : ", ", each.label,
                            each.modality.empty() ? "no modality" : each.modality, each.pictures.size(),
                            each.pictures.size() == 1 ? "picture" : "pictures", each.columns, each.rows);
    }
    return all.size() > mostListed ? fmt::format("{}, and {} more", list, all.size() - mostListed) : list;
}

Error several(const DicomSet& set, const std::vector<const DicomSeries*>& all) {
    return unsupported(set.name,
                       fmt::format("holds {} series, by their numbers: {}; choose one by --series NUMBER",
                                   all.size(), listOf(all)));
}

/// What a file lacks to be a picture that is read; "" where nothing.
std::string lack(const DicomHeader& header) {
    if (header.pixels == DicomHeader::Pixels::none || header.rows == 0 || header.columns == 0)
        return "pixels";
    if (header.frameCount == 0) return "frames";
    return "";
}

}  // namespace

Result<DicomSet> DicomSet::read(std::string name, std::vector<DicomFile> files, const Progress& progress) {
    DicomSet set;
    set.name = std::move(name);
    std::set<std::string> known;
    std::size_t bare = 0, twice = 0, odd = 0, pictures = 0;
    std::optional<Error> first;
    for (auto& file : files) {
        if (progress.cancelled())
            return Error{ErrorCode::cancelled, "", "cancelled while DICOM files were read"};
        auto stream = file.open();
        auto header =
            stream ? DicomHeader::parse(std::move(stream).value()) : Result<DicomHeader>(stream.error());
        if (header && header->frameCount > VolumeShape::maxDimension) {
            header = Error{ErrorCode::resourceExhausted, file.name(),
                           fmt::format("says {} frames", header->frameCount)};
        }
        if (!header) {
            ++odd;
            if (!first) first = header.error();
            continue;
        }
        if (!lack(*header).empty()) {
            ++bare;
            continue;
        }
        if (!header->sopInstance.empty() && !known.insert(header->sopInstance).second) {
            ++twice;
            continue;
        }
        pictures += std::max(header->frameCount, header->tiles.tiles);
        if (pictures > mostPictures) {
            return Error{ErrorCode::resourceExhausted, set.name,
                         fmt::format("holds more than {} pictures", mostPictures)};
        }
        set.files.push_back(std::move(file));
        set.headers.push_back(std::move(header).value());
    }
    if (set.files.empty() && first) return *first;
    if (set.files.empty()) {
        return unsupported(set.name, files.empty()       ? "holds no DICOM files"
                                     : files.size() == 1 ? "holds no picture (of a DICOMDIR, name the folder)"
                                                         : "holds DICOM files, and no pictures in them");
    }
    const auto note = [&](std::size_t count, std::string_view what) {
        if (count > 0)
            set.notes.push_back(
                fmt::format("{}: {} DICOM {} {}", set.name, count, count == 1 ? "file" : "files", what));
    };
    note(bare, "without a picture left out");
    note(twice, "left out, being copies of others");
    note(odd, first ? fmt::format("left out, which cannot be read (the first: {})", first->toString()) : "");
    return set;
}

Result<DicomSeries> chooseSeries(const DicomSet& set, std::string_view wanted) {
    MOTE_ASSIGN_OR_RETURN(auto all, seriesOf(set));
    label(all);
    std::vector<const DicomSeries*> chosen;
    for (const auto& each : all) {
        if (wanted.empty() || each.label == wanted) chosen.push_back(&each);
    }
    const bool byUid = chosen.empty();
    for (const auto& each : all) {
        if (byUid && each.uid == wanted) chosen.push_back(&each);
    }
    if (chosen.size() == 1) return *chosen.front();
    if (!chosen.empty()) return several(set, chosen);
    for (const auto& each : all) chosen.push_back(&each);
    return notFound(set.name, fmt::format("has no series of the number or UID \"{:.64}\"; it holds {}",
                                          wanted, listOf(chosen)));
}

}  // namespace mote::prep
