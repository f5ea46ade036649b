// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "preprocess/readers/particle_reader.h"

namespace mote::prep {

extern const ParticleReader openpmdReader, h5partReader, genesisReader, elegantReader, openpmdBelowReader;
extern const ParticleReader npyReader, ocelotReader, npzReader, gdfReader, dstReader, sddsReader;
extern const ParticleReader tfsReader, jsonReader, pyorbitReader, opalReader, gptTextReader;
extern const ParticleReader csvReader, impactZReader, impactTReader, opalRowsReader, astraReader;

namespace {

constexpr std::array readers{
    &openpmdReader, &h5partReader,   &genesisReader, &elegantReader, &openpmdBelowReader, &npyReader,
    &ocelotReader,  &npzReader,      &gdfReader,     &dstReader,     &sddsReader,         &tfsReader,
    &jsonReader,    &pyorbitReader,  &opalReader,    &gptTextReader, &csvReader,          &impactZReader,
    &impactTReader, &opalRowsReader, &astraReader};

}  // namespace

std::span<const ParticleReader* const> particleReaders() {
    return readers;
}

const ParticleReader* particleReader(std::string_view name) {
    const auto found = std::find_if(readers.begin(), readers.end(),
                                    [&](const ParticleReader* reader) { return reader->name == name; });
    return found == readers.end() ? nullptr : *found;
}

std::vector<std::string> particleFormats() {
    std::vector<std::string> names{"auto"};
    for (const ParticleReader* reader : readers) {
        const std::string name(reader->name);
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
}

}  // namespace mote::prep
