// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/impact_deck.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {

std::string tableInput(std::string_view input) {
    const auto [line, bytes] = firstLine(input);
    const std::string format(line);
    const MemoryFile file(bytes);
    if (format == "deck") {
        for (const auto code : {prep::ImpactDeck::Code::impactZ, prep::ImpactDeck::Code::impactT}) {
            const auto deck = prep::ImpactDeck::read(file.path(), code);
            if (deck) return "";
            if (code == prep::ImpactDeck::Code::impactT) return deck.error().toString();
        }
    }
    if (format == "track") {
        const auto track = prep::ReferenceTrack::read(file.path());
        if (!track) return track.error().toString();
        require(track->at(0.5).gamma >= 1.0);
        return "";
    }
    // HDF5 does not stand any bytes: see hdf5Input.
    const bool hdf5 =
        format == "openpmd" || format == "h5part" || format == "genesis4" || format == "elegant";
    if (hdf5 || bytes.starts_with("\x89HDF")) return "another reader";
    proto::ParticlesJob job;
    job.set_format(format);
    job.mutable_impact()->set_frequency(1e9);
    job.mutable_impact()->set_mass(1e6);
    return readParticles(job, {file.path()});
}

}  // namespace mote::test
