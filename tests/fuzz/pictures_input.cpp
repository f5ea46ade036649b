// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenImageIO and its libraries do not stand any bytes: they write the pictures that they then read.
#include <tuple>

#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/picture_text.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/words.h"

namespace mote::test {
namespace {

constexpr int mostPictures = 16;

}  // namespace

std::string picturesInput(std::string_view input) {
    auto [line, rest] = firstLine(input);
    Words words(line);
    proto::VolumeSourceOptions options;
    options.set_format(words.next());
    const std::string name = words.next();
    if (options.format() == "vdb" || (name != "." && !isPlainName(name))) return "another reader";
    const InputFolder folder;
    for (int i = 0; i < mostPictures && !rest.empty(); ++i) {
        std::tie(line, rest) = firstLine(rest);
        writePicture(folder, line);
    }
    return readVolume(options, name == "." ? folder.path() : folder.path() / name);
}

}  // namespace mote::test
