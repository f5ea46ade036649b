// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/residual_encoder.h"

#include <openvdb/io/Compression.h>
#include <openvdb/io/io.h>
#include <openvdb/util/NodeMasks.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "storage/vdb/vdb_file.h"

namespace mote::storage {
namespace {

using Mask = openvdb::util::NodeMask<3>;
static_assert(Mask::SIZE == residualBrickSamples);

}  // namespace

/// Told what OpenVDB tells a file's.
struct ResidualEncoder::Stream {
    std::ostringstream text;
    Stream() {
        openvdb::io::setDataCompression(text, vdbCompression(VdbValues::plain));
        openvdb::io::setGridBackgroundValuePtr(text, &background);
    }
    float background = 0.0F;
};

/// Halves have 11 bits, so a value is off by at most greatest * step / 2048, less than half a step, and must
/// be a normal number.
bool fitHalves(double greatest, double step) {
    return greatest < 1000.0 && greatest * step <= 65504.0 && step >= 0x1p-14;
}

ResidualEncoder::ResidualEncoder(const ResidualCoding& coding, const GridSize& node)
    : coding_(coding), stream_(std::make_unique<Stream>()) {
    MOTE_CHECK(coding.step > 0.0);
    part_.node = node;
    part_.begin = coding.size;
}

ResidualEncoder::~ResidualEncoder() = default;

void ResidualEncoder::add(const GridSize& brick,
                          std::span<const std::int32_t, residualBrickSamples> multiples) {
    Mask mask;
    std::array<float, residualBrickSamples> values{};
    for (std::uint32_t i = 0; i < residualBrickSamples; ++i) {
        if (multiples[i] == 0) continue;
        MOTE_CHECK(std::abs(multiples[i]) <= maxResidualMultiple);
        values[offsetInBrick(i)] = static_cast<float>(multiples[i] * coding_.step);
        mask.setOn(offsetInBrick(i));
        const GridSize in{i & 7U, i >> 3U & 7U, i >> 6U};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto at = brick[a] * residualBrickSide + in[a];
            part_.begin[a] = std::min(part_.begin[a], at);
            part_.end[a] = std::max(part_.end[a], at + 1);
        }
    }
    if (mask.isOff()) return;
    stream_->text.str({});
    mask.save(stream_->text);
    openvdb::io::writeCompressedValues(stream_->text, values.data(), Mask::SIZE, mask, Mask(),
                                       coding_.halves);
    const auto encoded = stream_->text.view();
    bytes_.insert(bytes_.end(), encoded.begin(), encoded.end());
    constexpr auto side = residualNodeBricks;
    const auto place = (brick[0] % side * side + brick[1] % side) * side + brick[2] % side;
    bricks_.push_back({place, static_cast<std::uint32_t>(encoded.size())});
    ++part_.bricks;
    part_.samples += mask.countOn();
}

Result<std::optional<ResidualPart>> ResidualEncoder::store(ScratchFile& scratch) const {
    if (bricks_.empty()) return std::optional<ResidualPart>();
    std::vector<std::byte> all;
    const auto append = [&](std::span<const std::byte> bytes) {
        all.insert(all.end(), bytes.begin(), bytes.end());
    };
    append(std::as_bytes(std::span(bricks_)));
    append(std::as_bytes(std::span(bytes_)));
    MOTE_ASSIGN_OR_RETURN(const auto at, scratch.append(all));
    auto part = part_;
    part.offset = at;
    part.bytes = all.size();
    return std::optional(part);
}

}  // namespace mote::storage
