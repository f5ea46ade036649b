// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/dicom/dicom_siemens.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "preprocess/readers/text/number.h"
#include "preprocess/volume/volume_shape.h"

namespace mote::prep {
namespace {

constexpr std::string_view siemensForm = "SV10";
constexpr std::size_t siemensHead = 16, nameBytes = 64, tagBytes = 84, itemHead = 16;

/// Goes through elements, each a name, how many items it has, and the items as texts.
class SiemensElements {
  public:
    explicit SiemensElements(std::string_view bytes) : bytes_(bytes), left_(word(8)) {}

    /// False at the end, or where what follows is none.
    bool next() {
        if (left_ == 0 || bytes_.size() - at_ < tagBytes) return false;
        --left_;
        name = textAt(at_, nameBytes);
        const std::uint32_t items = word(at_ + 76);
        at_ += tagBytes;
        numbers.clear();
        for (std::uint32_t i = 0; i < items; ++i) {
            if (bytes_.size() - at_ < itemHead) return false;
            const std::uint64_t length = word(at_ + 4), padded = (length + 3) / 4 * 4;
            at_ += itemHead;
            if (padded > bytes_.size() - at_) return false;
            if (const auto number = parseNumber(trim(textAt(at_, length))); length > 0 && number)
                numbers.push_back(*number);
            at_ += static_cast<std::size_t>(padded);
        }
        return true;
    }

    std::string_view name;
    std::vector<double> numbers;

  private:
    std::uint32_t word(std::size_t at) const { return loadNumber<std::uint32_t>(bytes_.data() + at, false); }
    /// Up to the first zero.
    std::string_view textAt(std::size_t at, std::uint64_t most) const {
        const auto text = bytes_.substr(at, static_cast<std::size_t>(most));
        return text.substr(0, text.find('\0'));
    }

    std::string_view bytes_;
    std::size_t at_ = siemensHead;
    std::uint32_t left_;
};

}  // namespace

std::optional<DicomMosaic> siemensMosaic(std::string_view bytes) {
    if (bytes.size() < siemensHead || !bytes.starts_with(siemensForm)) return std::nullopt;
    DicomMosaic mosaic;
    bool directed = false;
    for (SiemensElements elements(bytes); elements.next();) {
        const auto& numbers = elements.numbers;
        if (elements.name == "NumberOfImagesInMosaic" && !numbers.empty() && numbers[0] >= 1.0 &&
            numbers[0] <= VolumeShape::maxDimension)
            mosaic.tiles = static_cast<std::uint32_t>(numbers[0]);
        if (elements.name == "SliceNormalVector" && numbers.size() == 3) {
            mosaic.normal = {numbers[0], numbers[1], numbers[2]};
            directed = std::abs(glm::length(mosaic.normal) - 1.0) < 1e-2;
        }
    }
    if (mosaic.tiles == 0 || !directed) return std::nullopt;
    mosaic.normal = glm::normalize(mosaic.normal);
    return mosaic;
}

}  // namespace mote::prep
