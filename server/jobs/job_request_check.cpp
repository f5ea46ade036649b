// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_request_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace mote::server {
namespace {

constexpr std::size_t kLargestRequest = 64 * 1024;  // bytes of the whole message
constexpr std::size_t kLongestTitle = 256;          // bytes
constexpr std::size_t kLongestWord = 64;            // bytes of an axis, a format, a species, a range
constexpr std::size_t kLongestName = 1024;          // bytes of "ROOT/PATH"
constexpr std::size_t kLongestPart = 255;           // bytes between two "/", as Linux has it
constexpr int kMostInputs = 4096;
constexpr int kMostBounds = 16;

Error bad(std::string field, std::string message) {
    return {ErrorCode::invalidArgument, std::move(field), std::move(message)};
}

/// An error about a path, told of the field that holds it.
Error ofField(std::string field, const Error& error) {
    return {error.code, std::move(field), error.toString()};
}

Status checkWord(const std::string& word, std::string field, std::size_t longest = kLongestWord) {
    if (word.size() > longest) return bad(std::move(field), fmt::format("is longer than {} bytes", longest));
    for (const unsigned char c : word) {
        if (c < 0x20 || c == 0x7f) return bad(std::move(field), "holds a control character");
    }
    return success();
}

/// "ROOT/PATH" that a file may have; what it means is the roots' to say.
Status checkName(const std::string& name, const std::string& field) {
    MOTE_RETURN_IF_ERROR(checkWord(name, field, kLongestName));
    for (std::size_t begin = 0; begin < name.size();) {
        const auto end = std::min(name.find('/', begin), name.size());
        if (end - begin > kLongestPart) {
            return bad(field, fmt::format("has a part of more than {} bytes", kLongestPart));
        }
        begin = end + 1;
    }
    return success();
}

/// A file beneath a root.
Status checkInput(const std::string& name, const std::string& field, const storage::Roots& roots) {
    MOTE_RETURN_IF_ERROR(checkName(name, field));
    const auto path = roots.resolveExisting(name);
    if (!path.ok()) return ofField(field, path.error());
    return success();
}

Status checkInputs(const google::protobuf::RepeatedPtrField<std::string>& inputs, const std::string& field,
                   const storage::Roots& roots) {
    if (inputs.empty()) return bad(field, "names no file");
    if (inputs.size() > kMostInputs) return bad(field, fmt::format("names more than {} files", kMostInputs));
    for (int i = 0; i < inputs.size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkInput(inputs[i], fmt::format("{}[{}]", field, i), roots));
    }
    return success();
}

Status checkAxes(const proto::ParticlesJob& job) {
    if (job.axes_size() != 3)
        return bad("particles.axes", fmt::format("needs three names, not {}", job.axes_size()));
    for (int i = 0; i < 3; ++i) {
        const auto field = fmt::format("particles.axes[{}]", i);
        if (job.axes(i).empty()) return bad(field, "is empty");
        MOTE_RETURN_IF_ERROR(checkWord(job.axes(i), field));
        for (int j = 0; j < i; ++j) {
            if (job.axes(i) == job.axes(j))
                return bad(field, fmt::format("\"{}\" is given twice", job.axes(i)));
        }
    }
    return success();
}

Status checkBounds(const proto::ParticlesJob& job) {
    if (job.bounds_size() > kMostBounds) {
        return bad("particles.bounds", fmt::format("has more than {} entries", kMostBounds));
    }
    for (int i = 0; i < job.bounds_size(); ++i) {
        const auto& axis = job.bounds(i);
        const auto field = fmt::format("particles.bounds[{}]", i);
        MOTE_RETURN_IF_ERROR(checkWord(axis.name(), field + ".name"));
        MOTE_RETURN_IF_ERROR(checkWord(axis.unit(), field + ".unit"));
        if (!std::isfinite(axis.min()) || !std::isfinite(axis.max()) || !(axis.min() < axis.max())) {
            return bad(field, "needs finite numbers, min below max");
        }
    }
    return success();
}

Status checkImpact(const proto::ImpactOptions& impact) {
    for (const double value :
         {impact.frequency(), impact.mass(), impact.kinetic_energy(), impact.current()}) {
        if (!std::isfinite(value)) return bad("particles.impact", "needs finite numbers");
    }
    return success();
}

Status checkParticles(const proto::ParticlesJob& job, const storage::Roots& roots) {
    MOTE_RETURN_IF_ERROR(checkAxes(job));
    MOTE_RETURN_IF_ERROR(checkWord(job.format(), "particles.format"));
    MOTE_RETURN_IF_ERROR(checkWord(job.species(), "particles.species", 256));
    MOTE_RETURN_IF_ERROR(checkWord(job.steps(), "particles.steps"));
    MOTE_RETURN_IF_ERROR(checkBounds(job));
    MOTE_RETURN_IF_ERROR(checkImpact(job.impact()));
    return checkInputs(job.inputs(), "particles.inputs", roots);
}

Status checkSynthBeam(const proto::SynthBeamJob& job) {
    if (job.particles() == 0) return bad("synthBeam.particles", "must be at least 1");
    if (job.steps() == 0) return bad("synthBeam.steps", "must be at least 1");
    if (!std::isfinite(job.mismatch())) return bad("synthBeam.mismatch", "must be a finite number");
    return success();
}

Status checkStipple(const proto::StippleJob& job, const storage::Roots& roots) {
    if (job.points() == 0) return bad("stipple.points", "must be at least 1");
    if (!std::isfinite(job.relaxation())) return bad("stipple.relaxation", "must be a finite number");
    return job.mesh().empty() ? success() : checkInput(job.mesh(), "stipple.mesh", roots);
}

Status checkVolume(const proto::VolumeJob& job, const storage::Roots& roots) {
    if (!std::isfinite(job.threshold())) return bad("volume.threshold", "must be a finite number");
    MOTE_RETURN_IF_ERROR(checkWord(job.filter(), "volume.filter"));
    MOTE_RETURN_IF_ERROR(checkWord(job.representation(), "volume.representation"));
    return checkInputs(job.inputs(), "volume.inputs", roots);
}

Result<JobOutput> checkOutput(const proto::JobRequest& request, const storage::Roots& roots) {
    MOTE_RETURN_IF_ERROR(checkName(request.output(), "output"));
    const std::string_view ending = request.has_synth_beam() ? ".h5" : ".mote";
    const auto slash = request.output().rfind('/');
    const auto file = std::string_view(request.output()).substr(slash == std::string::npos ? 0 : slash + 1);
    if (file.size() <= ending.size() || !file.ends_with(ending) || file.starts_with('.')) {
        return bad("output", fmt::format("must be ROOT/PATH and end in a name like NAME{}", ending));
    }
    auto output = findOutput(request, roots);
    if (!output.ok()) return ofField("output", output.error());
    if (output->exists) {
        return Error{ErrorCode::alreadyExists, "output", fmt::format("{} exists already", request.output())};
    }
    return output;
}

}  // namespace

Result<JobOutput> checkJobRequest(const proto::JobRequest& request, const storage::Roots& roots) {
    if (request.ByteSizeLong() > kLargestRequest) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("the request has more than {} bytes", kLargestRequest)};
    }
    MOTE_RETURN_IF_ERROR(checkWord(request.title(), "title", kLongestTitle));
    switch (request.kind_case()) {
        case proto::JobRequest::kParticles:
            MOTE_RETURN_IF_ERROR(checkParticles(request.particles(), roots));
            break;
        case proto::JobRequest::kSynthBeam:
            MOTE_RETURN_IF_ERROR(checkSynthBeam(request.synth_beam()));
            break;
        case proto::JobRequest::kStipple:
            MOTE_RETURN_IF_ERROR(checkStipple(request.stipple(), roots));
            break;
        case proto::JobRequest::kMesh:
            MOTE_RETURN_IF_ERROR(checkInput(request.mesh().input(), "mesh.input", roots));
            break;
        case proto::JobRequest::kImage:
            MOTE_RETURN_IF_ERROR(checkInput(request.image().input(), "image.input", roots));
            break;
        case proto::JobRequest::kVolume:
            MOTE_RETURN_IF_ERROR(checkVolume(request.volume(), roots));
            break;
        case proto::JobRequest::KIND_NOT_SET:
            return bad("kind", "is missing: give particles, volume, synthBeam, stipple, image or mesh");
    }
    return checkOutput(request, roots);
}

}  // namespace mote::server
