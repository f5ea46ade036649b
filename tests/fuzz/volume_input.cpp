// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {

std::string volumeInput(std::string_view input) {
    const auto [line, bytes] = firstLine(input);
    proto::VolumeSourceOptions options;
    options.set_format(std::string(line));
    // OpenVDB, OpenImageIO and HDF5 are not what is looked at here, and they are not instrumented.
    if (options.format() == "vdb" || options.format() == "pictures" || options.format() == "openpmd")
        return "another reader";
    if (options.format() == "raw") {
        for (const std::uint32_t n : {3u, 4u, 5u}) options.add_dimensions(n);
        options.set_type("i16");
    }
    if ((options.format().empty() || options.format() == "auto") &&
        (bytes.starts_with(" BDV") || bytes.starts_with("\x89PNG") || bytes.starts_with("II") ||
         bytes.starts_with("MM") || bytes.starts_with("\x89HDF"))) {
        return "another reader";
    }
    // GDCM decodes what is compressed as JPEG is.
    if (bytes.find("1.2.840.10008.1.2.4.") != std::string_view::npos) return "another reader";
    const MemoryFile file(bytes);
    return readVolume(options, file.path());
}

}  // namespace mote::test
