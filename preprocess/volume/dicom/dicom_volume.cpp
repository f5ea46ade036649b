// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "preprocess/volume/dicom/dicom_pixels.h"
#include "preprocess/volume/dicom/dicom_series.h"
#include "preprocess/volume/dicom/dicom_stack.h"
#include "protocol/scene/mote_check.h"

namespace mote::prep {
namespace {

/// An input as it was looked at.
struct Looked {
    DicomSet set;
    DicomStack stack;
};

Result<Looked> lookAt(const DicomInput& input, const Progress& progress) {
    std::vector<DicomFile> files;
    for (const auto& path : input.paths) {
        MOTE_ASSIGN_OR_RETURN(auto some, dicomFiles(path, progress));
        std::move(some.begin(), some.end(), std::back_inserter(files));
    }
    const auto& first = input.paths.front();
    std::string name =
        first.filename().empty() ? first.parent_path().filename().string() : first.filename().string();
    if (input.paths.size() > 1) name = fmt::format("{} and {} more", name, input.paths.size() - 1);
    Looked looked;
    MOTE_ASSIGN_OR_RETURN(looked.set, DicomSet::read(std::move(name), std::move(files), progress));
    MOTE_ASSIGN_OR_RETURN(const auto series, chooseSeries(looked.set, input.series));
    MOTE_ASSIGN_OR_RETURN(looked.stack, DicomStack::of(looked.set, series));
    return looked;
}

DicomScale scaleOf(const DicomPicture& picture) {
    return {picture.at.slope.value_or(1.0), picture.at.intercept.value_or(0.0)};
}

class DicomVolume : public VolumeSource {
  public:
    DicomVolume(DicomSet set, std::vector<DicomPicture> slices)
        : set_(std::move(set)), slices_(std::move(slices)) {}

    std::string format() const override { return "dicom"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return false; }
    std::vector<std::string> takeNotes() override { return std::exchange(notes_, {}); }

    Status open(const DicomStack& stack, const VolumeParts& parts) {
        const DicomHeader& first = headerOf(slices_.front());
        MOTE_RETURN_IF_ERROR(setDimensions(shape_, first.columns, first.rows, slices_.size(), set_.name));
        MOTE_RETURN_IF_ERROR(setPlacement(shape_, stack.axes, stack.origin, set_.name));
        for (const auto& slice : slices_) {
            MOTE_RETURN_IF_ERROR(checkPixels(headerOf(slice), set_.files[slice.file].name()));
        }
        if (stack.placed) shape_.space = "left-posterior-superior";
        if (stack.sized) shape_.worldUnit = "mm";
        shape_.valueUnit = first.valueUnit;
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

    DicomSet set_;
    std::vector<DicomPicture> slices_;
    VolumeShape shape_;
    std::optional<DicomPixels> pixels_;  ///< of the file that was read last
    std::size_t openFile_ = 0;
    bool otherBitsNoted_ = false;
    std::vector<std::string> notes_;
};

}  // namespace

Result<VolumeParts> partsOfDicom(const DicomInput& input, const Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto looked, lookAt(input, progress));
    VolumeParts parts;
    parts.volumes = looked.stack.volumes.size();
    return parts;
}

Result<std::unique_ptr<VolumeSource>> openDicom(const DicomInput& input, const std::string& field,
                                                const Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto looked, lookAt(input, progress));
    VolumeParts all;
    all.volumes = looked.stack.volumes.size();
    MOTE_ASSIGN_OR_RETURN(const auto parts, chooseParts(field, all, looked.set.name));
    auto& slices = looked.stack.volumes[static_cast<std::size_t>(parts.volume)];
    auto volume = std::make_unique<DicomVolume>(std::move(looked.set), std::move(slices));
    MOTE_RETURN_IF_ERROR(volume->open(looked.stack, parts));
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
