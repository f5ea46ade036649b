// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

/// OpenImageIO, OpenVDB and HDF5 do not stand any bytes, and are not instrumented.
bool isOfLibrary(const std::string& name, std::string_view bytes) {
    const auto ends = [&](std::string_view ending) { return name.ends_with(ending); };
    return ends(".png") || ends(".tif") || ends(".tiff") || bytes.starts_with("\x89PNG") ||
           bytes.starts_with("II") || bytes.starts_with("MM") || bytes.starts_with(" BDV") ||
           bytes.starts_with("\x89HDF");
}

/// "FORMAT NAME[,NAME...] [FREQUENCY [MASS [ENERGY]]]"
std::string readParticlesIn(const InputFolder& folder, Words words) {
    proto::ParticlesJob job;
    job.set_format(words.next());
    std::vector<std::filesystem::path> inputs;
    for (Words names(words.next(), ','); !names.atEnd();) {
        const std::string name = names.next();
        if (name == "." || isPlainName(name)) inputs.push_back(folder.path() / name);
    }
    if (!words.atEnd()) job.mutable_impact()->set_frequency(words.number(1e9));
    if (!words.atEnd()) job.mutable_impact()->set_mass(words.number(1e6));
    if (!words.atEnd()) job.mutable_impact()->set_kinetic_energy(words.number(1e6));
    return readParticles(job, inputs);
}

/// "FORMAT NAME [FIELD]"
std::string readVolumeIn(const InputFolder& folder, Words words) {
    proto::VolumeSourceOptions options;
    options.set_format(words.next());
    const std::string name = words.next();
    options.set_field(words.next());
    if (!isPlainName(name)) return "no name of a file";
    return readVolume(options, folder.path() / name);
}

}  // namespace

std::string filesInput(std::string_view input) {
    const auto [line, rest] = firstLine(input);
    Words words(line);
    const bool particles = words.next() == "particles";
    if (Words(words).next() == "vdb" || Words(words).next() == "pictures") return "another reader";
    const InputFolder folder;
    for (const auto& [name, bytes] : filesOf(rest)) {
        if (isOfLibrary(name, bytes)) return "another reader";
        folder.write(name, bytes);
    }
    return particles ? readParticlesIn(folder, words) : readVolumeIn(folder, words);
}

}  // namespace mote::test
