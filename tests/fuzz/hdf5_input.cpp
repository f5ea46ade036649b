// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 does not stand any bytes: it writes the files that our readers then read.
#include "tests/fuzz/hdf5_text.h"
#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/words.h"

namespace mote::test {
namespace {

/// "FORMAT [SPECIES [MASS [twice]]]"; "-" is no species.
std::string readParticlesOf(const std::filesystem::path& file, Words words) {
    proto::ParticlesJob job;
    job.set_format(words.next());
    const std::string species = words.next();
    if (species != "-") job.set_species(species);
    if (!words.atEnd()) job.mutable_impact()->set_mass(words.number(0.0));
    std::vector<std::filesystem::path> inputs{file};
    if (words.next() == "twice") inputs.push_back(file);
    return readParticles(job, inputs);
}

}  // namespace

std::string hdf5Input(std::string_view input) {
    const auto [line, text] = firstLine(input);
    Words words(line);
    const std::string bytes = hdf5Of(text);
    if (bytes.empty()) return "HDF5 made no file of it";
    // HDF5 wants a path that stays one when it is resolved.
    const InputFolder folder;
    folder.write("run.h5", bytes);
    const auto file = folder.path() / "run.h5";
    const std::string what = words.next();
    if (what == "particles") return readParticlesOf(file, words);
    proto::VolumeSourceOptions options;
    options.set_format(words.next());
    options.set_field(words.next());
    return readVolume(options, file);
}

}  // namespace mote::test
