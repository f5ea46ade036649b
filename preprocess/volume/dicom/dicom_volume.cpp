// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>
#include <set>
#include <utility>

#include "preprocess/volume/dicom/dicom_pixels.h"
#include "protocol/base/mote_check.h"

namespace mote::prep {
namespace {

// Several pictures at each place of a series (times, echoes, weights of diffusion) as volumes, one of each
// place: told apart by what differs. Pure functions.

/// The pictures that lie at one place.
using DicomPlace = std::vector<DicomPicture>;

struct DicomVolumes {
    std::vector<std::vector<DicomPicture>> volumes;
    std::vector<std::optional<double>> times;  ///< of each volume, s, from the first one on
    std::string note;                          ///< by what they were told apart; "" if there is one
};

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

/// Checks that all places have as many pictures as the first one.
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

/// Errors: corrupt (places with more pictures than others).
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

    /// Places slices that do not say where they lie: by their location, else by their numbers.
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

/// A slope of 0 is none: all values would be one.
DicomScale scaleOf(const DicomPicture& picture) {
    const double slope = picture.at.slope.value_or(1.0);
    return {slope == 0.0 ? 1.0 : slope, picture.at.intercept.value_or(0.0)};
}

class DicomVolume : public VolumeSource {
  public:
    /// `slices` are the look's.
    DicomVolume(std::shared_ptr<const DicomLook> look, const std::vector<DicomPicture>& slices)
        : look_(std::move(look)), set_(look_->set), slices_(slices) {}

    std::string format() const override { return "dicom"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return false; }
    std::vector<std::string> takeNotes() override { return std::exchange(notes_, {}); }

    Status open(const DicomStack& stack, const VolumeParts& parts) {
        const DicomHeader& first = headerOf(slices_.front());
        MOTE_RETURN_IF_ERROR(
            setDimensions(shape_, first.sliceColumns(), first.sliceRows(), slices_.size(), set_.name));
        MOTE_RETURN_IF_ERROR(setPlacement(shape_, stack.axes, stack.origin, set_.name));
        for (const auto& slice : slices_) {
            MOTE_RETURN_IF_ERROR(checkPixels(headerOf(slice), set_.files[slice.file].name()));
        }
        if (stack.placed) shape_.space = "left-posterior-superior";
        if (stack.sized) shape_.worldUnit = "mm";
        // PS3.3, C.8.2.1: what CT rescales is in these, where it does not say otherwise.
        const bool hounsfield =
            first.modality == "CT" && !first.saysUnit && slices_.front().at.intercept.has_value();
        shape_.valueUnit = hounsfield ? "HU" : first.valueUnit;
        shape_.time = stack.times[parts.volume];
        shape_.notes = set_.notes;
        shape_.notes.insert(shape_.notes.end(), stack.notes.begin(), stack.notes.end());
        describeValues();
        return success();
    }

    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        MOTE_CHECK(z0 <= z1 && z1 <= shape_.nz && values.size() == shape_.voxelsOfSlice() * (z1 - z0));
        const auto slice = static_cast<std::size_t>(shape_.voxelsOfSlice());
        for (std::uint32_t z = z0; z < z1; ++z) {
            MOTE_RETURN_IF_ERROR(readSlice(slices_[z], values.subspan((z - z0) * slice, slice)));
        }
        return success();
    }

  private:
    const DicomHeader& headerOf(const DicomPicture& picture) const { return set_.headers[picture.file]; }
    void note(std::string_view sentence) {
        shape_.notes.push_back(fmt::format("{}: {}", set_.name, sentence));
    }
    bool any(bool (*holds)(const DicomHeader&)) const {
        return std::any_of(slices_.begin(), slices_.end(),
                           [&](const DicomPicture& each) { return holds(headerOf(each)); });
    }

    /// Which kind of numbers they are, and what was done with them.
    void describeValues() {
        const DicomScale first = scaleOf(slices_.front());
        bool sameScale = true;
        shape_.type = typeOf(headerOf(slices_.front()));
        for (const auto& slice : slices_) {
            const DicomScale scale = scaleOf(slice);
            sameScale &= scale.slope == first.slope && scale.intercept == first.intercept;
            if (typeOf(headerOf(slice)) != shape_.type) shape_.type = ScalarType::f32;
        }
        const bool integers = shape_.type != ScalarType::f32 && shape_.type != ScalarType::f64;
        if (sameScale && integers) shape_.valueStep = std::abs(first.slope);
        // Values of differing slopes have no step of their own.
        if (!sameScale && integers) shape_.type = ScalarType::f32;
        if (!sameScale) note("slope and intercept of values differ from slice to slice; each has its own");
        if (any(isInverted)) {
            note(
                "its greys are darker the greater (MONOCHROME1); the stored numbers were turned round within "
                "their bits");
        }
        if (any([](const DicomHeader& header) { return header.lossy; }))
            note("its pixels were compressed with losses");
        if (any([](const DicomHeader& header) { return header.hasTable; })) {
            note("a table of values (Modality LUT) is not applied: values are the stored numbers");
        }
        if (any([](const DicomHeader& header) { return header.photometric.starts_with("PALETTE"); })) {
            note("its numbers are those of a palette's colours, which are not looked up");
        }
        const auto flat = [](const DicomPicture& each) { return each.at.slope == 0.0; };
        if (std::any_of(slices_.begin(), slices_.end(), flat))
            note("says a slope of 0, which was taken as 1");
        if (any([](const DicomHeader& header) { return header.samples > 1; })) {
            note("its pictures are in colour; their luminance is read");
        }
    }

    Status readSlice(const DicomPicture& slice, std::span<float> values) {
        if (!pixels_ || openFile_ != slice.file) {
            pixels_.reset();
            MOTE_ASSIGN_OR_RETURN(auto pixels, DicomPixels::open(set_.files[slice.file], headerOf(slice)));
            pixels_.emplace(std::move(pixels));
            openFile_ = slice.file;
        }
        MOTE_RETURN_IF_ERROR(pixels_->read(slice.frame, scaleOf(slice), values));
        if (pixels_->hadOtherBits() && !otherBitsNoted_) {
            otherBitsNoted_ = true;
            notes_.push_back(fmt::format(
                "{}: bits of pixels outside of those stored (overlays) were left out", set_.name));
        }
        return success();
    }

    std::shared_ptr<const DicomLook> look_;
    const DicomSet& set_;
    const std::vector<DicomPicture>& slices_;
    VolumeShape shape_;
    std::optional<DicomPixels> pixels_;  ///< of the file that was read last
    std::size_t openFile_ = 0;
    bool otherBitsNoted_ = false;
    std::vector<std::string> notes_;
};

}  // namespace

Result<DicomStack> DicomStack::of(const DicomSet& set, const DicomSeries& series) {
    return StackMaker(set, series).make();
}

Result<std::shared_ptr<const DicomLook>> lookAtDicom(const DicomInput& input, const Progress& progress) {
    std::vector<DicomFile> files;
    for (const auto& path : input.paths) {
        MOTE_ASSIGN_OR_RETURN(auto some, dicomFiles(path, progress));
        std::move(some.begin(), some.end(), std::back_inserter(files));
    }
    const auto& first = input.paths.front();
    std::string name = (first.filename().empty() ? first.parent_path() : first).filename().string();
    if (input.paths.size() > 1) name = fmt::format("{} and {} more", name, input.paths.size() - 1);
    auto look = std::make_shared<DicomLook>();
    MOTE_ASSIGN_OR_RETURN(look->set, DicomSet::read(std::move(name), std::move(files), progress));
    MOTE_ASSIGN_OR_RETURN(const auto series, chooseSeries(look->set, input.series));
    MOTE_ASSIGN_OR_RETURN(look->stack, DicomStack::of(look->set, series));
    return std::shared_ptr<const DicomLook>(std::move(look));
}

VolumeParts partsOfDicom(const DicomLook& look) {
    VolumeParts parts;
    parts.volumes = look.stack.volumes.size();
    return parts;
}

Result<std::unique_ptr<VolumeSource>> openDicom(const std::shared_ptr<const DicomLook>& look,
                                                const std::string& field) {
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, partsOfDicom(*look), look->set.name));
    const auto& slices = look->stack.volumes[static_cast<std::size_t>(parts.volume)];
    auto volume = std::make_unique<DicomVolume>(look, slices);
    MOTE_RETURN_IF_ERROR(volume->open(look->stack, parts));
    return std::unique_ptr<VolumeSource>(std::move(volume));
}

bool areDicomSlices(const std::vector<std::filesystem::path>& paths) {
    for (const auto& path : paths) {
        auto file = fileStream(path);
        if (!file) return false;
        const auto head = readHead(**file, DicomHeader::headBytes);
        if (!head || !DicomHeader::begins(*head)) return false;
        if (!(*file)->seek(0)) return false;
        // One that cannot be read is told of where the others are.
        const auto header = DicomHeader::parse(std::move(file).value());
        if (header && header->frameCount > 1) return false;
    }
    return true;
}

}  // namespace mote::prep
