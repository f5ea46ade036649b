// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/job_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "protocol/quantity/quantity.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/film/film_job.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/space/length_unit.h"
#include "protocol/scene/step_range.h"

namespace mote {
namespace {

using Request = proto::JobRequest;

constexpr std::size_t largestRequest = std::size_t{64} * 1024;  // bytes of the whole message
constexpr std::size_t largestFilm = std::size_t{900} * 1024;    // likewise; it holds a script
constexpr std::size_t largestExport = largestFilm;              // likewise; it holds a selection
constexpr std::size_t longestJobTitle = 256;                    // bytes
constexpr std::size_t longestWord = 64;                         // bytes of an axis, a format, a range
constexpr std::size_t longestSpecies = 256;                     // bytes
constexpr std::size_t longestName = 1024;                       // bytes of "ROOT/PATH"
constexpr std::size_t longestPart = 255;                        // bytes between two "/", as Linux has it
constexpr int mostInputs = 4096;
constexpr int mostBounds = 16;
constexpr int mostColumns = 256;

Status checkWord(const std::string& word, std::string_view field, std::size_t longest = longestWord) {
    if (word.size() > longest) return invalid(field, fmt::format("is longer than {} bytes", longest));
    for (const unsigned char c : word) {
        if (c < 0x20 || c == 0x7f) return invalid(field, "holds a control character");
    }
    return success();
}

/// "ROOT/PATH" that a file may have; what it means is the roots' to say.
Status checkName(const std::string& name, const std::string& field) {
    MOTE_RETURN_IF_ERROR(checkWord(name, field, longestName));
    for (std::size_t begin = 0; begin < name.size();) {
        const auto end = std::min(name.find('/', begin), name.size());
        if (end - begin > longestPart) {
            return invalid(field, fmt::format("has a part of more than {} bytes", longestPart));
        }
        begin = end + 1;
    }
    return success();
}

Status checkCount(int inputs, const char* field) {
    if (inputs == 0) return invalid(field, "names no file");
    if (inputs <= mostInputs) return success();
    return invalid(field, fmt::format("names more than {} files", mostInputs));
}

Status checkFinite(double value, const char* field) {
    return std::isfinite(value) ? success() : invalid(field, "must be a finite number");
}

Status checkAxes(const proto::ParticlesJob& job) {
    if (job.axes_size() != 3)
        return invalid("axes", fmt::format("needs three names, not {}", job.axes_size()));
    for (int i = 0; i < 3; ++i) {
        const auto field = fmt::format("axes[{}]", i);
        if (job.axes(i).empty()) return invalid(field, "is empty");
        MOTE_RETURN_IF_ERROR(checkColumnName(job.axes(i), field));
        for (int j = 0; j < i; ++j) {
            if (job.axes(i) == job.axes(j))
                return invalid(field, fmt::format("\"{}\" is given twice", job.axes(i)));
        }
    }
    return success();
}

Status checkBounds(const proto::ParticlesJob& job) {
    if (job.bounds_size() > mostBounds) {
        return invalid("bounds", fmt::format("has more than {} entries", mostBounds));
    }
    for (int i = 0; i < job.bounds_size(); ++i) {
        const auto& axis = job.bounds(i);
        const auto field = fmt::format("bounds[{}]", i);
        MOTE_RETURN_IF_ERROR(checkColumnName(axis.name(), field + ".name"));
        MOTE_RETURN_IF_ERROR(checkWord(axis.unit(), field + ".unit"));
        if (axis.unit() == "step") continue;  // each step's own, as requests said before bounds_of
        if (!std::isfinite(axis.min()) || !std::isfinite(axis.max()) || !(axis.min() < axis.max())) {
            return invalid(field, "needs finite numbers, min below max");
        }
    }
    return success();
}

Status checkParticles(const Request& request) {
    const auto& job = request.particles();
    MOTE_RETURN_IF_ERROR(checkAxes(job));
    MOTE_RETURN_IF_ERROR(checkWord(job.format(), "format"));
    MOTE_RETURN_IF_ERROR(checkWord(job.species(), "species", longestSpecies));
    MOTE_RETURN_IF_ERROR(checkWord(job.steps(), "steps"));
    if (!job.bounds_of().empty() && job.bounds_of() != "run" && job.bounds_of() != "step")
        return invalid("boundsOf", "must be run or step");
    MOTE_RETURN_IF_ERROR(checkBounds(job));
    const auto& impact = job.impact();
    for (const double value :
         {impact.frequency(), impact.mass(), impact.kinetic_energy(), impact.current()}) {
        if (!std::isfinite(value)) return invalid("impact", "needs finite numbers");
    }
    if (job.follow())
        return invalid("follow", "is for mote-prep beside the run; a server takes its steps with append");
    if (job.closes() && !job.append()) return invalid("closes", "needs \"append\" beside it");
    if (job.closes() && job.inputs().empty()) return success();
    return checkCount(job.inputs_size(), "inputs");
}

Status checkSynthBeam(const Request& request) {
    const auto& job = request.synth_beam();
    if (job.particles() == 0) return invalid("particles", "must be at least 1");
    if (job.steps() == 0) return invalid("steps", "must be at least 1");
    return checkFinite(job.mismatch(), "mismatch");
}

Status checkStipple(const Request& request) {
    const auto& job = request.stipple();
    if (job.points() == 0) return invalid("points", "must be at least 1");
    return checkFinite(job.relaxation(), "relaxation");
}

Status checkMesh(const Request& request) {
    return checkMeshJob(request.mesh());
}

Status checkVolume(const Request& request) {
    const auto& job = request.volume();
    MOTE_RETURN_IF_ERROR(checkFinite(job.threshold(), "threshold"));
    MOTE_RETURN_IF_ERROR(checkWord(job.filter(), "filter"));
    MOTE_RETURN_IF_ERROR(checkWord(job.representation(), "representation"));
    return checkCount(job.inputs_size(), "inputs");
}

Status checkFilm(const Request& request) {
    return checkFilmJob(request.film());
}

Status checkExport(const Request& request) {
    const auto& job = request.export_();
    MOTE_RETURN_IF_ERROR(checkStepRange(job.steps()));
    if (const auto selection = parseSelection(job.select()); !selection.ok())
        return selection.error().within("select");
    if (job.columns_size() > mostColumns)
        return invalid("columns", fmt::format("names more than {}", mostColumns));
    for (int i = 0; i < job.columns_size(); ++i) {
        const auto name = checkColumnName(job.columns(i), fmt::format("columns[{}]", i));
        if (!name.ok()) return name.error();
    }
    return success();
}

Status checkNothing(const Request&) {
    return success();
}

using Inputs = std::vector<JobInput>;

template <class Names>
Inputs listed(const Names& names) {
    Inputs inputs;
    for (const auto& name : names) inputs.push_back({fmt::format("inputs[{}]", inputs.size()), name});
    return inputs;
}

Inputs particlesInputs(const Request& request) {
    return listed(request.particles().inputs());
}
Inputs volumeInputs(const Request& request) {
    return listed(request.volume().inputs());
}
Inputs stippleInputs(const Request& request) {
    const auto& mesh = request.stipple().mesh();
    return mesh.empty() ? Inputs{} : Inputs{{"mesh", mesh}};
}
Inputs meshInputs(const Request& request) {
    return {{"input", request.mesh().input()}};
}
Inputs imageInputs(const Request& request) {
    return {{"input", request.image().input()}};
}
Inputs exportInputs(const Request& request) {
    return {{"dataset", request.export_().dataset()}};
}
Inputs noInputs(const Request&) {
    return {};
}

/// What must be said of each kind of job; places are within its own field.
struct RequestKind {
    Request::KindCase kind;
    Inputs (*inputs)(const Request&);
    Status (*check)(const Request&);
    std::string_view ending = ".mote";  ///< of what it makes; empty: that stays with the job
    std::size_t largest = largestRequest;
    bool ranks = false;  ///< several processes may do it together
};

constexpr std::array kinds{
    RequestKind{Request::kParticles, particlesInputs, checkParticles, ".mote", largestRequest, true},
    RequestKind{Request::kSynthBeam, noInputs, checkSynthBeam, ".h5"},
    RequestKind{Request::kStipple, stippleInputs, checkStipple},
    RequestKind{Request::kMesh, meshInputs, checkMesh},
    RequestKind{Request::kImage, imageInputs, checkNothing},
    RequestKind{Request::kVolume, volumeInputs, checkVolume, ".mote", largestRequest, true},
    RequestKind{Request::kFilm, noInputs, checkFilm, "", largestFilm},
    RequestKind{Request::kExport, exportInputs, checkExport, "", largestExport},
};

RequestKind kindOf(const Request& request) {
    const auto* const found = std::ranges::find(kinds, request.kind_case(), &RequestKind::kind);
    return found != kinds.end() ? *found : RequestKind{request.kind_case(), noInputs, checkNothing};
}

const google::protobuf::OneofDescriptor& choices() {
    return *Request::descriptor()->FindOneofByName("kind");
}

/// "particles", the field that holds the job.
std::string fieldOf(const Request& request) {
    const auto* field = Request::GetReflection()->GetOneofFieldDescriptor(request, &choices());
    return field ? field->json_name() : std::string();
}

Error missingKind() {
    std::vector<std::string> names;
    names.reserve(static_cast<std::size_t>(choices().field_count()));
    for (int i = 0; i < choices().field_count(); ++i) names.push_back(choices().field(i)->json_name());
    return invalid("kind", fmt::format("is missing: give one of {}", fmt::join(names, ", ")));
}

Status checkOutput(const std::string& output, std::string_view ending) {
    if (ending.empty() && output.empty()) return success();
    if (ending.empty()) return invalid("output", "must be left out: a film or an export stays with its job");
    MOTE_RETURN_IF_ERROR(checkName(output, "output"));
    const auto slash = output.rfind('/');
    const auto file = std::string_view(output).substr(slash == std::string::npos ? 0 : slash + 1);
    if (file.size() > ending.size() && file.ends_with(ending) && !file.starts_with('.')) return success();
    return invalid("output", fmt::format("must be ROOT/PATH and end in a name like NAME{}", ending));
}

}  // namespace

Status checkMeshJob(const proto::MeshJob& job) {
    MOTE_RETURN_IF_ERROR(checkFinite(job.isovalue(), "isovalue"));
    if (!job.has_isovalue() && (job.has_source() || job.clip_size() > 0))
        return invalid("isovalue",
                       "is missing: only of a volume there is anything to clip, or another way to read");
    if (job.clip_size() == 0) return success();
    if (job.clip_size() != 6)
        return invalid("clip", fmt::format("needs six numbers, not {}", job.clip_size()));
    for (int i = 0; i < 3; ++i) {
        if (std::isfinite(job.clip(i)) && std::isfinite(job.clip(i + 3)) && job.clip(i) < job.clip(i + 3))
            continue;
        return invalid("clip", "needs finite numbers, the least below the greatest");
    }
    return success();
}

namespace {

/// Axes by their names, and the front across the upper side.
Status checkOutlook(const Request& message) {
    const auto direction = [](const std::string& name, const char* field) -> Status {
        if (name.empty() || findDirection(name)) return success();
        return invalid(field, "is x, -x, y, -y, z or -z");
    };
    MOTE_RETURN_IF_ERROR(direction(message.up(), "up"));
    MOTE_RETURN_IF_ERROR(direction(message.front(), "front"));
    if (message.front().empty()) return success();
    if (message.up().empty()) return invalid("front", "needs \"up\" beside it");
    if (message.up().back() != message.front().back()) return success();
    return invalid("front", "lies across what is up");
}

/// Of what lies in a world of its own.
Status checkUnit(const Request& message) {
    const auto& unit = message.unit();
    if (unit.empty()) return success();
    if (std::ranges::find(ownLengthUnits, unit, &LengthUnit::name) == ownLengthUnits.end())
        return invalid("unit", fmt::format("is one of {}", lengthUnitNames()));
    const bool surface = message.has_stipple() && !message.stipple().mesh().empty();
    if (message.has_volume() || message.has_mesh() || surface) return success();
    return invalid("unit", "only volumes, meshes and surfaces lie in a world with a unit");
}

}  // namespace

bool mayHaveRanks(const Request& message) {
    return kindOf(message).ranks && !appendsSteps(message);
}

bool staysWithJob(const Request& message) {
    return kindOf(message).ending.empty();
}

bool appendsSteps(const Request& message) {
    return message.particles().append();
}

std::vector<JobInput> jobInputs(const Request& message) {
    auto inputs = kindOf(message).inputs(message);
    for (auto& input : inputs) input.field = fmt::format("{}.{}", fieldOf(message), input.field);
    return inputs;
}

Result<JobRequest> parseJobRequest(const Request& message) {
    const auto kind = kindOf(message);
    if (message.ByteSizeLong() > kind.largest) {
        return Error{ErrorCode::resourceExhausted, "",
                     fmt::format("the request has more than {} bytes", kind.largest)};
    }
    MOTE_RETURN_IF_ERROR(checkWord(message.title(), "title", longestJobTitle));
    if (message.kind_case() == Request::KIND_NOT_SET) return missingKind();
    MOTE_RETURN_IF_ERROR(checkOutlook(message));
    MOTE_RETURN_IF_ERROR(checkUnit(message));
    MOTE_RETURN_IF_ERROR(kind.check(message), fieldOf(message));
    JobRequest request{message, jobInputs(message)};
    for (const auto& input : request.inputs) MOTE_RETURN_IF_ERROR(checkName(input.name, input.field));
    MOTE_RETURN_IF_ERROR(checkOutput(message.output(), kind.ending));
    return request;
}

}  // namespace mote
