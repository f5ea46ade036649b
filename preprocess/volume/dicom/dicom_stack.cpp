// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>

#include "preprocess/volume/dicom/dicom_volumes.h"

namespace mote::prep {
namespace {

constexpr double tellsApart = 0.05;    // of a slice's step: places nearer than that are one
constexpr double unevenNoted = 0.01;   // of the step: what texts of few digits round
constexpr double unevenRefused = 0.1;  // beyond that no one step fits
constexpr double shearNoted = 1e-3;    // of a right angle, as sine
constexpr double rightAngle = 1e-2, unitLength = 1e-2;

/// The median of what lies between neighbours that are apart.
double usualStep(const std::vector<double>& places, double least) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < places.size(); ++i) {
        if (places[i] - places[i - 1] > least) steps.push_back(places[i] - places[i - 1]);
    }
    if (steps.empty()) return 0.0;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

class StackMaker {
  public:
    StackMaker(const DicomSet& set, const DicomSeries& series) : set_(set), pictures_(series.pictures) {}

    Result<DicomStack> make() {
        MOTE_RETURN_IF_ERROR(findDirections());
        placeThose();
        std::stable_sort(pictures_.begin(), pictures_.end(),
                         [&](const DicomPicture& a, const DicomPicture& b) { return along(a) < along(b); });
        MOTE_RETURN_IF_ERROR(gather());
        MOTE_RETURN_IF_ERROR(findSteps());
        return std::move(stack_);
    }

  private:
    Error corrupt(std::string message) const { return {ErrorCode::corrupt, set_.name, std::move(message)}; }
    void note(const std::string& sentence) { stack_.notes.push_back(set_.name + ": " + sentence); }
    double along(const DicomPicture& picture) const { return glm::dot(*picture.at.position, normal_); }
    std::string nameOf(const DicomPicture& picture) const {
        const auto& header = set_.headers[picture.file];
        const std::string name = set_.files[picture.file].name();
        return header.frameCount > 1 ? fmt::format("{}, frame {}", name, picture.frame + 1) : name;
    }

    Status findDirections() {
        const auto& said = pictures_.front().at.orientation;
        stack_.placed = said.has_value() && pictures_.front().at.position.has_value();
        if (!said) note("says no orientation; rows are taken along x and columns along y");
        const auto of = said.value_or(std::array<double, 6>{1, 0, 0, 0, 1, 0});
        row_ = {of[0], of[1], of[2]};
        column_ = {of[3], of[4], of[5]};
        const double rows = glm::length(row_), columns = glm::length(column_);
        if (!(std::abs(rows - 1.0) < unitLength && std::abs(columns - 1.0) < unitLength &&
              std::abs(glm::dot(row_, column_)) < rightAngle)) {
            return corrupt("says directions of rows and columns that are no unit vectors at right angles");
        }
        row_ /= rows;
        column_ /= columns;
        normal_ = glm::normalize(glm::cross(row_, column_));
        return success();
    }

    /// Where slices lie that do not say it: by their location, else by their numbers.
    void placeThose() {
        const auto lacks = [](const DicomPicture& each) { return !each.at.position.has_value(); };
        if (std::none_of(pictures_.begin(), pictures_.end(), lacks)) return;
        const DicomFrame& first = pictures_.front().at;
        const double step = first.between.value_or(first.thickness.value_or(1.0));
        const bool located = std::all_of(pictures_.begin(), pictures_.end(), [&](const DicomPicture& each) {
            return set_.headers[each.file].sliceLocation && set_.headers[each.file].frameCount == 1;
        });
        note(located ? "says no positions; slices lie where their slice location says"
                     : fmt::format("says no positions; slices lie by their numbers, {:g} apart", step));
        stack_.placed = false;
        for (std::size_t i = 0; i < pictures_.size(); ++i) {
            const auto& header = set_.headers[pictures_[i].file];
            const double number =
                header.frameCount > 1 ? pictures_[i].frame : header.instance.value_or(static_cast<double>(i));
            pictures_[i].at.position = normal_ * (located ? *header.sliceLocation : number * step);
        }
    }

    /// Pictures by place, and those at one place as volumes.
    Status gather() {
        if (pictures_.size() == 1) {
            return unsupported(nameOf(pictures_.front()),
                               "is a single picture of a series: name its folder, or all of its files");
        }
        std::vector<double> places;
        for (const auto& picture : pictures_) places.push_back(along(picture));
        const double even = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
        const double step = usualStep(places, tellsApart * even);
        std::vector<DicomPlace> slices;
        for (std::size_t i = 0; i < pictures_.size(); ++i) {
            if (i == 0 || places[i] - places[i - 1] > tellsApart * step) slices.emplace_back();
            slices.back().push_back(pictures_[i]);
        }
        MOTE_RETURN_IF_ERROR(checkGaps(slices, step));
        MOTE_ASSIGN_OR_RETURN(auto told, tellApart(set_, std::move(slices)));
        stack_.volumes = std::move(told.volumes);
        stack_.times = std::move(told.times);
        if (!told.note.empty()) note(told.note);
        return success();
    }

    /// A gap of a whole number of steps is what is missing; another one contradicts all grids.
    Status checkGaps(const std::vector<DicomPlace>& slices, double step) const {
        for (std::size_t i = 1; i < slices.size(); ++i) {
            const auto &before = slices[i - 1].front(), &after = slices[i].front();
            const double gap = along(after) - along(before), missing = std::round(gap / step) - 1.0;
            if (std::abs(gap / step - 1.0) <= unevenRefused) continue;
            if (missing >= 1.0 && std::abs(gap / step - 1.0 - missing) <= 2.0 * unevenRefused) {
                return corrupt(fmt::format(
                    "{} missing between {} and {}: they lie {:.6g} mm apart along the normal, most others "
                    "{:.6g}",
                    missing == 1.0 ? std::string("a slice is") : fmt::format("{:.0f} slices are", missing),
                    nameOf(before), nameOf(after), gap, step));
            }
            return corrupt(
                fmt::format("its slices lie unevenly: {:.6g} mm between {} and {}, {:.6g} between most "
                            "others; no one grid "
                            "holds them (dcm2niix makes an even one)",
                            gap, nameOf(before), nameOf(after), step));
        }
        return success();
    }

    /// The steps from voxel to voxel, slices as their places say: a tilted gantry makes a sheared grid.
    Status findSteps() {
        const auto& slices = stack_.volumes.front();
        const DicomFrame& first = slices.front().at;
        stack_.origin = *first.position;
        const auto pixel = first.pixelSpacing.value_or(std::array<double, 2>{1.0, 1.0});
        stack_.sized = first.pixelSpacing.has_value();
        if (!stack_.sized) note("says no size of a pixel, which was taken as 1");
        if (stack_.sized && set_.headers[slices.front().file].looseSpacing) {
            note("the size of a pixel is that at the detector or as it was asked for");
        }
        glm::dvec3 step = normal_;
        if (slices.size() > 1) {
            step = (*slices.back().at.position - stack_.origin) / static_cast<double>(slices.size() - 1);
            for (const auto& volume : stack_.volumes) MOTE_RETURN_IF_ERROR(checkEven(volume, step));
        } else {
            step *= first.between.value_or(first.thickness.value_or(pixel[0]));
            note(fmt::format("is one slice, taken as {:.6g} mm thick", glm::length(step)));
        }
        const double shear = glm::length(step - glm::dot(step, normal_) * normal_) / glm::length(step);
        if (shear > shearNoted) {
            note(fmt::format(
                "its slices are shifted along their planes by {:.2f} degrees (a tilted gantry): the "
                "grid is sheared, as they lie",
                std::asin(std::min(shear, 1.0)) * 180.0 / std::numbers::pi));
        }
        stack_.axes = glm::dmat3(row_ * pixel[1], column_ * pixel[0], step);
        return success();
    }

    Status checkEven(const std::vector<DicomPicture>& slices, const glm::dvec3& step) {
        double worst = 0.0;
        std::size_t at = 0;
        for (std::size_t i = 0; i < slices.size(); ++i) {
            const auto expected = stack_.origin + static_cast<double>(i) * step;
            const double off = glm::length(*slices[i].at.position - expected);
            if (off > worst) worst = off, at = i;
        }
        const double length = glm::length(step);
        if (worst > unevenRefused * length) {
            return corrupt(
                fmt::format("{} lies {:.6g} mm off the line on which slices {:.6g} mm apart would lie",
                            nameOf(slices[at]), worst, length));
        }
        if (worst > unevenNoted * length) {
            note(fmt::format("its slices lie up to {:.4g} mm off an even grid of {:.6g} mm", worst, length));
        }
        return success();
    }

    const DicomSet& set_;
    std::vector<DicomPicture> pictures_;
    glm::dvec3 row_{1, 0, 0}, column_{0, 1, 0}, normal_{0, 0, 1};
    DicomStack stack_;
};

}  // namespace

Result<DicomStack> DicomStack::of(const DicomSet& set, const DicomSeries& series) {
    return StackMaker(set, series).make();
}

}  // namespace mote::prep
