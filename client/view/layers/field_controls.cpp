// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/field_controls.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "client/view/slider_values.h"
#include "protocol/scene/color_map.h"
#include "protocol/scene/fields/facts.h"

namespace mote::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using proto::Facts;

/// The control of one field.
class FieldControl {
  public:
    FieldControl(PanelActions& actions, Message& message, const Message& shown, const FieldDescriptor& field,
                 const FieldFilter& filter)
        : actions_(actions),
          message_(message),
          shown_(shown),
          field_(field),
          filter_(filter),
          facts_(factsOf(field)),
          reflection_(*message.GetReflection()),
          label_(facts_.label().c_str()) {}

    bool draw() {
        ImGui::PushID(field_.full_name().c_str());
        const bool changed = drawByType();
        ImGui::PopID();
        return changed;
    }

  private:
    bool drawByType() {
        switch (field_.cpp_type()) {
            case FieldDescriptor::CPPTYPE_MESSAGE:
                return drawMessage();
            case FieldDescriptor::CPPTYPE_DOUBLE:
                if (facts_.as() == Facts::COLOR) return drawColor();
                return field_.is_repeated() ? drawDirection() : drawNumber();
            case FieldDescriptor::CPPTYPE_BOOL:
                return drawSwitch();
            default:
                return drawWord();
        }
    }

    bool said() const { return reflection_.HasField(message_, &field_); }
    /// The message that holds what is shown.
    const Message& source() const { return said() ? message_ : shown_; }

    /// Notes what was done with the last widget.
    bool noted(bool changed) {
        note(actions_, changed);
        helpAtRest(facts_.help());
        return changed;
    }

    double numberShown() const {
        if (said() || !field_.has_presence() || reflection_.HasField(shown_, &field_))
            return reflection_.GetDouble(source(), &field_);
        return facts_.default_(0);
    }

    const char* format() const {
        if (facts_.as() == Facts::LENGTH) return said() ? "%.1f px" : "usual %.1f px";
        return facts_.unit() == "degrees" ? "%.0f deg" : "%.2f";
    }

    bool drawNumber() {
        const auto& slider = facts_.slider();
        const bool own = facts_.has_slider();
        const double least = own ? slider.from() : facts_.from(), greatest = own ? slider.to() : facts_.to();
        const int how = ImGuiSliderFlags_AlwaysClamp |
                        (slider.log() ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
        double value = numberShown();
        if (!noted(
                ImGui::SliderScalar(label_, ImGuiDataType_Double, &value, &least, &greatest, format(), how)))
            return false;
        reflection_.SetDouble(&message_, &field_, std::clamp(value, facts_.from(), facts_.to()));
        return true;
    }

    bool drawSwitch() {
        bool value = reflection_.GetBool(message_, &field_);
        if (!noted(ImGui::Checkbox(label_, &value))) return false;
        reflection_.SetBool(&message_, &field_, value);
        return true;
    }

    bool drawWord() {
        std::vector<std::string_view> names;
        if (!facts_.empty_word().empty()) names.emplace_back(facts_.empty_word());
        const bool colors = facts_.as() == Facts::COLOR_MAP && names.empty();
        if (facts_.as() == Facts::COLOR_MAP)
            names.insert(names.end(), ColorMap::names().begin(), ColorMap::names().end());
        else
            names.insert(names.end(), facts_.one_of().begin(), facts_.one_of().end());
        if (names.empty()) return false;  // any text
        std::string chosen = reflection_.GetString(source(), &field_);
        if (chosen.empty()) chosen = facts_.empty_word();
        if (!noted(colors ? chooseColorMap(label_, chosen) : chooseName(label_, chosen, names))) return false;
        reflection_.SetString(&message_, &field_, chosen == facts_.empty_word() ? "" : chosen);
        return true;
    }

    std::array<double, 3> numbersOf(const Message& message) const {
        std::array<double, 3> numbers{};
        for (int i = 0; i < std::min(3, reflection_.FieldSize(message, &field_)); ++i)
            numbers[static_cast<std::size_t>(i)] = reflection_.GetRepeatedDouble(message, &field_, i);
        return numbers;
    }
    bool saysNumbers() const { return reflection_.FieldSize(message_, &field_) > 0; }
    void setNumbers(const std::array<double, 3>& numbers) {
        reflection_.ClearField(&message_, &field_);
        for (const double number : numbers) reflection_.AddDouble(&message_, &field_, number);
    }

    /// One that follows from other things where it is not said is the view's own or none.
    bool drawColor() {
        bool own = saysNumbers();
        auto color = numbersOf(own ? message_ : shown_);
        if (facts_.default__size() == 0) {
            if (noted(ImGui::Checkbox(("own " + facts_.label()).c_str(), &own))) {
                own ? setNumbers(color) : reflection_.ClearField(&message_, &field_);
                return true;
            }
            if (!own) return false;
            ImGui::SameLine();
        }
        auto shown = toFloats({color[0], color[1], color[2]});
        if (!noted(ImGui::ColorEdit3(label_, shown.data(), ImGuiColorEditFlags_NoInputs))) return false;
        for (std::size_t i = 0; i < 3; ++i) color[i] = share(shown[i]);
        setNumbers(color);
        return true;
    }

    bool drawDirection() {
        const auto at = numbersOf(saysNumbers() ? message_ : shown_);
        constexpr float pole = 89.9F;  // at which "across" is still told
        auto angles = LightAngles::of({at[0], at[1], at[2]});
        const auto before = angles;
        angleSliders(actions_, label_, angles);
        if (angles == before) return false;
        angles.above = std::clamp(angles.above, -pole, pole);
        const auto direction = angles.direction();
        setNumbers({direction.x, direction.y, direction.z});
        return true;
    }

    /// What is there without being said, and what has been asked for.
    bool drawMessage() {
        bool there = said();
        if (!facts_.filled() && !facts_.label().empty() && noted(ImGui::Checkbox(label_, &there))) {
            there ? static_cast<void>(reflection_.MutableMessage(&message_, &field_))
                  : reflection_.ClearField(&message_, &field_);
            return true;
        }
        if (!there && !facts_.filled()) return false;
        const auto& part = reflection_.GetMessage(message_, &field_);
        const std::unique_ptr<Message> edited(part.New());
        edited->CopyFrom(part);
        const auto within = [&](std::string_view name) {
            return !filter_ || filter_(fmt::format("{}.{}", field_.json_name(), name));
        };
        if (!fieldControls(actions_, *edited, reflection_.GetMessage(shown_, &field_), within)) return false;
        reflection_.MutableMessage(&message_, &field_)->CopyFrom(*edited);
        return true;
    }

    PanelActions& actions_;
    Message& message_;
    const Message& shown_;
    const FieldDescriptor& field_;
    const FieldFilter& filter_;
    const Facts& facts_;
    const google::protobuf::Reflection& reflection_;
    const char* label_;
};

}  // namespace

bool fieldControls(PanelActions& actions, Message& message, const Message& shown, const FieldFilter& filter) {
    bool changed = false;
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
        const auto& field = *type.field(i);
        const bool drawn = !factsOf(field).label().empty() || factsOf(field).filled();
        if (!drawn || (filter && !filter(field.json_name()))) continue;
        if (FieldControl(actions, message, shown, field, filter).draw()) changed = true;
    }
    return changed;
}

}  // namespace mote::client
