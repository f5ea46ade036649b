// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <system_error>

#include "preprocess/readers/csv/csv_source.h"
#include "preprocess/readers/format.h"
#include "preprocess/readers/h5part/h5part_source.h"
#include "preprocess/readers/impact/impact_source.h"
#include "preprocess/readers/npy/npy_source.h"
#include "preprocess/readers/openpmd/layout.h"
#include "preprocess/readers/openpmd/source.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {
namespace {

constexpr std::size_t maxFiles = 100'000;

/// The files that a name with %T or %06T stands for ("run_%T.h5"), by their numbers, or the name itself.
Result<std::vector<std::filesystem::path>> expand(const std::filesystem::path& input) {
    std::error_code code;
    const std::string pattern = input.filename().string();
    if (std::filesystem::exists(input, code) || pattern.find('%') == std::string::npos) return {{input}};
    std::vector<std::pair<std::int64_t, std::filesystem::path>> found;
    const std::filesystem::path folder = input.parent_path().empty() ? "." : input.parent_path();
    for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end;
         entry.increment(code)) {
        if (const auto number = matchIteration(pattern, entry->path().filename().string())) {
            found.emplace_back(*number, entry->path());
        }
        if (found.size() > maxFiles) break;
    }
    if (found.empty()) return Error{ErrorCode::notFound, pattern, "no file has a name like this"};
    std::sort(found.begin(), found.end());
    std::vector<std::filesystem::path> files;
    for (auto& [number, path] : found) files.push_back(std::move(path));
    return files;
}

Result<std::vector<std::filesystem::path>> allFiles(const std::vector<std::filesystem::path>& inputs) {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& input : inputs) {
        const auto some = expand(input);
        if (!some) return some.error();
        files.insert(files.end(), some->begin(), some->end());
        if (files.size() > maxFiles) {
            return Error{ErrorCode::resourceExhausted, "inputs", "are more than 100000 files"};
        }
    }
    if (files.empty()) return Error{ErrorCode::invalidArgument, "inputs", "no input was given"};
    return files;
}

}  // namespace

Result<std::unique_ptr<ParticleSource>> openParticleSource(const proto::ParticlesJob& job,
                                                           const std::vector<std::filesystem::path>& inputs,
                                                           Progress& progress) {
    const auto files = allFiles(inputs);
    if (!files) return files.error();
    const auto format = formatOf(job, *files);
    if (!format) return format.error();
    if (!job.species().empty() && *format != Format::openpmd) {
        return Error{ErrorCode::invalidArgument, "species", "only openPMD files have species"};
    }
    const double mass = job.impact().mass();
    switch (*format) {
        case Format::openpmd:
            return openOpenpmd(*files, job.species(), progress);
        case Format::h5part:
            return openH5Part(*files, mass, progress);
        case Format::impactZ:
            return openImpact(ImpactDeck::Code::impactZ, *files, job.impact(), progress);
        case Format::impactT:
            return openImpact(ImpactDeck::Code::impactT, *files, job.impact(), progress);
        case Format::csv:
            return openCsv(*files, mass, progress);
        case Format::npy:
            return openNpy(*files, mass, progress);
    }
    return Error{ErrorCode::internal, "", "no reader is known for this format"};
}

}  // namespace mote::prep
