// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "preprocess/volume/dicom/dicom_pixels.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

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
