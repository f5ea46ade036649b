// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstring>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

constexpr std::uint64_t mostVoxels = 1u << 16;  // of a slice that is read

bool withinBounds(std::uint32_t n) {
    return n >= 1 && n <= prep::VolumeShape::maxDimension;
}

std::string readSlices(prep::VolumeSource& source) {
    const prep::VolumeShape& shape = source.shape();
    require(withinBounds(shape.nx) && withinBounds(shape.ny) && withinBounds(shape.nz));
    if (shape.voxelsOfSlice() > mostVoxels) return "too large to be looked at here";
    std::vector<float> first(shape.voxelsOfSlice()), again(first.size());
    if (const auto status = source.read(0, 1, first); !status) return status.error().toString();
    const std::uint32_t last = shape.nz - 1;
    if (const auto status = source.read(last, shape.nz, again); !status) return status.error().toString();
    // The first slice once more: what lies before must be found again.
    if (const auto status = source.read(0, 1, again); !status) return status.error().toString();
    require(std::memcmp(first.data(), again.data(), first.size() * sizeof(float)) == 0);
    return "";
}

}  // namespace

std::string volumeInput(std::string_view input) {
    const auto [line, bytes] = firstLine(input);
    proto::VolumeSourceOptions options;
    options.set_format(std::string(line));
    // OpenVDB and OpenImageIO are not what is looked at here, and they are not instrumented.
    if (options.format() == "vdb" || options.format() == "pictures") return "another reader";
    if (options.format() == "raw") {
        for (const std::uint32_t n : {3u, 4u, 5u}) options.add_dimensions(n);
        options.set_type("i16");
    }
    if (options.format() == "auto" && (bytes.starts_with(" BDV") || bytes.starts_with("\x89PNG") ||
                                       bytes.starts_with("II") || bytes.starts_with("MM"))) {
        return "another reader";
    }
    const MemoryFile file(bytes);
    Silent progress;
    auto source = prep::openVolumeSource(options, file.path(), progress);
    return source ? readSlices(**source) : source.error().toString();
}

}  // namespace mote::test
