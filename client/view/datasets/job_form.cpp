// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/job_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "protocol/scene/fields/facts.h"

namespace mote::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// What the file itself says, or the server, or what makes sense on a command line alone.
constexpr std::array<std::string_view, 7> notAsked{"inputs", "input",  "mesh",  "output",
                                                   "title",  "bounds", "follow"};
constexpr std::array<std::string_view, 13> askedFirst{
    "axes",   "species", "steps", "low",   "threshold", "representation", "isovalue",
    "points", "seed",    "up",    "front", "unit",      "field"};
constexpr std::uint64_t usualDots = 50'000;  // on a surface

template <std::size_t n>
bool holds(const std::array<std::string_view, n>& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
}

std::string numberText(double number) {
    return fmt::format("{}", number);
}

/// What a field says; empty: nothing.
std::string textOf(const Message& message, const FieldDescriptor& field) {
    const auto& reflection = *message.GetReflection();
    if (field.is_repeated()) {
        std::string text;
        for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
            if (i > 0) text += ",";
            if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
                text += reflection.GetRepeatedString(message, &field, i);
            else if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
                text += numberText(reflection.GetRepeatedDouble(message, &field, i));
            else
                text += std::to_string(reflection.GetRepeatedUInt32(message, &field, i));
        }
        return text;
    }
    if (!reflection.HasField(message, &field)) return {};
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_STRING:
            return reflection.GetString(message, &field);
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return numberText(reflection.GetDouble(message, &field));
        case FieldDescriptor::CPPTYPE_UINT64:
            return std::to_string(reflection.GetUInt64(message, &field));
        case FieldDescriptor::CPPTYPE_BOOL:
            return reflection.GetBool(message, &field) ? "true" : "";
        default:
            return std::to_string(reflection.GetUInt32(message, &field));
    }
}

std::string usualOf(const proto::Facts& facts) {
    if (!facts.default_word().empty()) return facts.default_word();
    return facts.default__size() > 0 ? numberText(facts.default_(0)) : "";
}

std::string labelOf(const FieldDescriptor& field) {
    std::string label = field.name();
    std::ranges::replace(label, '_', ' ');
    return label;
}

template <class Number>
std::optional<Number> numberIn(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// Parts between commas and blanks.
std::vector<std::string> partsOf(std::string_view text, std::string_view between) {
    std::vector<std::string> parts;
    while (!text.empty()) {
        const auto end = text.find_first_of(between);
        if (end != 0) parts.emplace_back(text.substr(0, end));
        if (end == std::string_view::npos) break;
        text.remove_prefix(end + 1);
    }
    return parts;
}

std::string trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return {};
    return std::string(text.substr(begin, text.find_last_not_of(' ') + 1 - begin));
}

/// Sets one field of a message from what was typed.
class FieldSetter {
  public:
    FieldSetter(const JobForm::Field& field, Message& message)
        : form_(field),
          field_(*field.path.back()),
          message_(message),
          reflection_(*message.GetReflection()) {}

    Status set(const std::string& text) {
        reflection_.ClearField(&message_, &field_);
        if (text.empty()) return success();
        if (!field_.is_repeated()) return setOne(text);
        const bool words = field_.cpp_type() == FieldDescriptor::CPPTYPE_STRING;
        for (const auto& part : partsOf(text, words ? "," : ", ")) MOTE_RETURN_IF_ERROR(add(trimmed(part)));
        return success();
    }

  private:
    Error wrong(std::string message) const { return invalid(form_.label, std::move(message)); }

    Status checkEnds(double number) const {
        const auto ends = endsOf(field_);
        if (!ends || (number >= ends->least && number <= ends->greatest)) return success();
        return wrong(fmt::format("is a number from {} to {}", ends->least, ends->greatest));
    }

    template <class Number>
    Result<Number> parsed(const std::string& text) const {
        const auto number = numberIn<Number>(text);
        const bool whole = std::is_integral_v<Number>;
        if (!number || !std::isfinite(static_cast<double>(*number)))
            return wrong(whole ? "is a whole number" : "is a number");
        MOTE_RETURN_IF_ERROR(checkEnds(static_cast<double>(*number)));
        return *number;
    }

    Status setOne(const std::string& text) {
        switch (field_.cpp_type()) {
            case FieldDescriptor::CPPTYPE_STRING:
                reflection_.SetString(&message_, &field_, text);
                return success();
            case FieldDescriptor::CPPTYPE_BOOL:
                reflection_.SetBool(&message_, &field_, text == "true");
                return success();
            case FieldDescriptor::CPPTYPE_DOUBLE: {
                MOTE_ASSIGN_OR_RETURN(const auto number, parsed<double>(text));
                reflection_.SetDouble(&message_, &field_, number);
                return success();
            }
            case FieldDescriptor::CPPTYPE_UINT64: {
                MOTE_ASSIGN_OR_RETURN(const auto number, parsed<std::uint64_t>(text));
                reflection_.SetUInt64(&message_, &field_, number);
                return success();
            }
            default: {
                MOTE_ASSIGN_OR_RETURN(const auto number, parsed<std::uint32_t>(text));
                reflection_.SetUInt32(&message_, &field_, number);
                return success();
            }
        }
    }

    Status add(const std::string& part) {
        if (field_.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
            reflection_.AddString(&message_, &field_, part);
        } else if (field_.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
            MOTE_ASSIGN_OR_RETURN(const auto number, parsed<double>(part));
            reflection_.AddDouble(&message_, &field_, number);
        } else {
            MOTE_ASSIGN_OR_RETURN(const auto number, parsed<std::uint32_t>(part));
            reflection_.AddUInt32(&message_, &field_, number);
        }
        return success();
    }

    const JobForm::Field& form_;
    const FieldDescriptor& field_;
    Message& message_;
    const google::protobuf::Reflection& reflection_;
};

/// Whether a control can hold the field.
bool isPlain(const FieldDescriptor& field) {
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) return false;
    return !field.is_repeated() || field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ||
           field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE ||
           field.cpp_type() == FieldDescriptor::CPPTYPE_UINT32;
}

void addFields(const Message& message, const std::vector<const FieldDescriptor*>& above,
               std::vector<JobForm::Field>& fields) {
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        auto path = above;
        path.push_back(&field);
        const auto& facts = factsOf(field);
        if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field.is_repeated() && !above.empty()) {
            addFields(message.GetReflection()->GetMessage(message, &field), path, fields);
        } else if (isPlain(field) && !facts.help().empty() && !holds(notAsked, field.name())) {
            fields.push_back({std::move(path),
                              labelOf(field),
                              facts.help(),
                              usualOf(facts),
                              {facts.one_of().begin(), facts.one_of().end()},
                              field.cpp_type() == FieldDescriptor::CPPTYPE_BOOL,
                              holds(askedFirst, field.name()),
                              textOf(message, field)});
        }
    }
}

Message& messageOf(proto::JobRequest& request, const JobForm::Field& field) {
    Message* message = &request;
    for (std::size_t i = 0; i + 1 < field.path.size(); ++i)
        message = message->GetReflection()->MutableMessage(message, field.path[i]);
    return *message;
}

/// Whether there is a message that the field could be cleared in: one that says nothing is not made.
bool isThere(const proto::JobRequest& request, const JobForm::Field& field) {
    const Message* message = &request;
    for (std::size_t i = 0; i + 1 < field.path.size(); ++i) {
        if (!message->GetReflection()->HasField(*message, field.path[i])) return false;
        message = &message->GetReflection()->GetMessage(*message, field.path[i]);
    }
    return true;
}

proto::JobRequest particlesOf(const std::vector<std::string>& inputs, const proto::Look::Found& found) {
    proto::JobRequest request;
    auto& job = *request.mutable_particles();
    job.mutable_inputs()->Add(inputs.begin(), inputs.end());
    job.set_species(found.name());
    const auto axes = found.facts().fields().find("axes");
    if (axes != found.facts().fields().end()) {
        for (const auto& axis : partsOf(axes->second.string_value(), ",")) job.add_axes(axis);
    }
    return request;
}

proto::JobRequest surfaceOf(const std::string& input, const proto::Look::Found& found) {
    proto::JobRequest request;
    auto& job = *request.mutable_mesh();
    job.set_input(input);
    job.mutable_source()->set_field(found.name());
    const bool known = found.columns_size() > 0 && found.columns(0).has_min();
    job.set_isovalue(known ? 0.5 * (found.columns(0).min() + found.columns(0).max()) : 0.0);
    return request;
}

proto::JobRequest volumeOf(const std::vector<std::string>& inputs, const proto::Look::Found& found) {
    proto::JobRequest request;
    auto& job = *request.mutable_volume();
    job.mutable_inputs()->Add(inputs.begin(), inputs.end());
    job.mutable_source()->set_field(found.name());
    return request;
}

}  // namespace

std::vector<Becoming> becomings(const std::vector<std::string>& inputs, const proto::Look::Found& found) {
    if (inputs.empty()) return {};
    const auto& input = inputs.front();
    if (found.kind() == "particles") return {{"a plot of particles", particlesOf(inputs, found)}};
    if (found.kind() == "volume" && inputs.size() > 1)
        return {{"a volume, a step each", volumeOf(inputs, found)}};
    if (found.kind() == "volume")
        return {{"a volume", volumeOf(inputs, found)}, {"the surface of a value", surfaceOf(input, found)}};
    proto::JobRequest one, other;
    if (inputs.size() > 1) return {};
    if (found.kind() == "mesh") {
        one.mutable_mesh()->set_input(input);
        other.mutable_stipple()->set_mesh(input);
        other.mutable_stipple()->set_points(usualDots);
        return {{"a surface", one}, {"dots on a surface", other}};
    }
    if (found.kind() != "image") return {};
    one.mutable_image()->set_input(input);
    return {{"an image", one}};
}

std::string outputFor(const std::vector<std::string>& inputs, const std::string& found,
                      const std::function<bool(const std::string& path)>& taken) {
    const auto& input = inputs.front();
    const auto slash = input.rfind('/');
    auto stem = input;
    if (slash == std::string::npos) stem = input + "/" + input;  // a root itself
    for (const std::string_view packed : {".gz", ".zst"}) {
        if (stem.ends_with(packed)) stem.erase(stem.size() - packed.size());
    }
    const auto dot = stem.rfind('.');
    if (dot != std::string::npos && dot > stem.rfind('/') + 1) stem.erase(dot);
    // Of a run's files the number goes.
    const auto kept = stem.find_last_not_of("0123456789_-.");
    if (inputs.size() > 1 && kept != std::string::npos && stem[kept] != '/') stem.erase(kept + 1);
    if (!found.empty()) {
        stem += "-";
        for (const char letter : found)
            stem += std::string_view("/\\ \t\n").find(letter) == std::string_view::npos ? letter : '_';
    }
    auto output = stem;
    for (int number = 2; taken(output + ".mote"); ++number) output = fmt::format("{}-{}", stem, number);
    return output;
}

void JobForm::begin(const proto::JobRequest& request) {
    preset_ = request;
    fields_.clear();
    const auto* kind = proto::JobRequest::descriptor()->FindFieldByNumber(request.kind_case());
    if (kind == nullptr) return;
    addFields(request.GetReflection()->GetMessage(request, kind), {kind}, fields_);
    if (request.has_mesh() || request.has_volume()) addFields(request, {}, fields_);
    // A surface of triangles has no volume's options.
    if (request.has_mesh() && !request.mesh().has_isovalue()) {
        std::erase_if(fields_, [](const Field& field) {
            return field.path.size() > 2 || field.label == "isovalue" || field.label == "clip";
        });
    }
    std::stable_partition(fields_.begin(), fields_.end(), [](const Field& field) { return field.first; });
}

Result<proto::JobRequest> JobForm::request() const {
    auto made = preset_;
    for (const auto& field : fields_) {
        auto text = trimmed(field.text);
        if (text.empty() && !isThere(made, field)) continue;
        MOTE_RETURN_IF_ERROR(FieldSetter(field, messageOf(made, field)).set(text));
    }
    if (made.has_particles()) {
        const auto& axes = made.particles().axes();
        if (axes.size() != 3) return invalid("axes", "are three names, separated by commas");
    }
    auto name = trimmed(output);
    if (name.empty() || name.find('/') == std::string::npos || name.ends_with('/'))
        return invalid("dataset", "is ROOT/NAME: where it is to lie, and its name");
    if (!name.ends_with(".mote")) name += ".mote";
    made.set_output(name);
    made.set_title(trimmed(title));
    return made;
}

}  // namespace mote::client
