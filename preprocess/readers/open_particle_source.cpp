// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <vector>

#include "preprocess/readers/csv/csv_source.h"
#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/input_files.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress) {
    using Format = ParticleFormat;
    MOTE_ASSIGN_OR_RETURN(const auto inputsFound, inputFiles(inputs));
    MOTE_ASSIGN_OR_RETURN(const auto options, tableOptions(job));
    MOTE_ASSIGN_OR_RETURN(const auto found, detectFormat(job, inputsFound, progress));
    const auto& files = found.paths;
    if (!job.species().empty() && found.format != Format::openpmd) {
        return Error{ErrorCode::invalidArgument, "species", "only openPMD files have species"};
    }
    if (!options.map.empty() && found.format != Format::csv) {
        return Error{ErrorCode::invalidArgument, "map", "only tables of text have columns to be named"};
    }
    const double mass = options.mass;
    switch (found.format) {
        case Format::openpmd:
            return openOpenpmd(files, job.species(), mass, progress);
        case Format::h5part:
            return openH5Part(files, mass, progress);
        case Format::impactZ:
            return openImpact(ImpactDeck::Code::impactZ, files, job.impact(), progress);
        case Format::impactT:
            return openImpact(ImpactDeck::Code::impactT, files, job.impact(), progress);
        case Format::sdds:
            return openSdds("sdds", files, mass, progress);
        case Format::elegant:
            return openSdds("elegant", files, mass, progress);
        case Format::tracewin:
            return openDst(files, mass, progress);
        case Format::astra:
            return openAstra(files, mass, progress);
        case Format::genesis:
            return openGenesis(files, mass, progress);
        case Format::csv:
            return openCsv(files, options, progress);
        case Format::npy:
            return openNpy("npy", files, mass, progress);
        case Format::npz:
            if (looksLikeScaledNpz(files.front())) return openScaledNpz(files, mass, progress);
            return openNpy("npz", files, mass, progress);
        case Format::tfs:
            return openTfs(files, mass, progress);
        case Format::json:
            return openJson(files, mass, progress);
        case Format::gpt:
            return openGpt(files, mass, progress);
        case Format::ocelot:
            return openOcelot(files, mass, progress);
        case Format::opal:
            return openOpal(files, mass, progress);
        case Format::pyorbit:
            return openPyorbit(files, mass, progress);
    }
    return Error{ErrorCode::internal, "", "no reader is known for this format"};
}

}  // namespace mote::prep
