// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/view/panel_hand.h"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>
#include <imgui.h>
#include <algorithm>
#include <vector>

namespace mote::client {
namespace {

constexpr float width = 1600.0F, height = 1400.0F;  // the whole panel is to be seen
constexpr const char* columns[] = {"x", "y", "z", "px", "py", "pz"};

QueryLine noServer() {
    return {[](const proto::Query&, QueryLine::Reply) { return std::uint64_t{0}; }, [](std::uint64_t) {}};
}

void describeParticles(proto::ParticlesManifest& particles) {
    particles.set_density_min(1e2);
    particles.set_density_max(1e9);
    particles.set_ids(true);
    particles.set_mass(9.4e8);
    for (int i = 0; i < 3; ++i) {
        auto& step = *particles.add_steps();
        step.set_particles(1000);
        step.set_total_weight(1000.0);
        for (int bin = 0; bin < 64; ++bin) step.add_density_histogram(static_cast<std::uint64_t>(bin));
        auto& axis = *particles.add_axes();
        axis.set_name(columns[i]);
        axis.set_unit("m");
        axis.set_min(-1.0);
        axis.set_max(1.0);
    }
    for (const char* name : columns) {
        auto& column = *particles.add_columns();
        column.set_name(name);
        column.set_unit("m");
        column.set_min(-1.0);
        column.set_max(1.0);
    }
}

void describeVolume(proto::HybridManifest& hybrid) {
    for (const unsigned size : {20U, 10U, 5U}) hybrid.add_source_size(size);
    for (const unsigned size : {5U, 3U, 2U}) hybrid.add_low_size(size);
    for (const double number : {2, 0, 0, 1, 0, 2, 0, 1, 0, 0, 4, 2, 0, 0, 0, 1})
        hybrid.add_index_to_world(number);
    hybrid.set_value_min(-20.0);
    hybrid.set_value_max(255.0);
    hybrid.set_scalar_type("i16");
    hybrid.set_point_bytes(8);
    for (int i = 0; i < 3; ++i) {
        auto& step = *hybrid.add_steps();
        for (int bin = 0; bin < 256; ++bin) step.add_histogram(bin < 50 ? 1000 : 10);
    }
}

void describeMesh(proto::MeshManifest& mesh) {
    mesh.set_triangles(12);
    for (const double low : {0.0, 0.0, -10.0}) mesh.add_bounds_min(low);
    for (const double high : {20.0, 10.0, 0.0}) mesh.add_bounds_max(high);
}

}  // namespace

proto::Manifest manifestFor(const proto::Layer& layer) {
    proto::Manifest manifest;
    if (layer.has_hybrid()) {
        manifest.set_kind("hybrid");
        describeVolume(*manifest.mutable_hybrid());
    } else if (layer.has_mesh() || layer.has_ink() || layer.has_stipple()) {
        manifest.set_kind(layer.has_stipple() ? "stipple" : "mesh");
        if (layer.has_stipple()) manifest.mutable_stipple()->set_domain(proto::StippleManifest::SURFACE);
        describeMesh(*manifest.mutable_mesh());
    } else {
        manifest.set_kind("particles");
        describeParticles(*manifest.mutable_particles());
    }
    return manifest;
}

PanelHand::PanelHand() : frames_(width, height), numbers_(noServer()) {
    server_.connected = true;
    handles_.cuts = handles_.places = true;
}

void PanelHand::describe(const proto::Manifest& manifest) {
    auto shown = std::make_shared<proto::Description>();
    *shown->mutable_manifest() = manifest;
    server_.shown = std::move(shown);
}

void PanelHand::draw(ViewModel& model) {
    ImGui::NewFrame();
    drawPanel(model, numbers_, handles_, server_, {}, 1.0F);
    PanelActions more;
    bool pulled = false;
    handles_.draw(model, {width - panelWidth, height, 1.0F}, pulled);
    EXPECT_FALSE(pulled);  // the mouse is on the panel
    const auto* manifest = server_.shown ? &server_.shown->manifest() : nullptr;
    numbers_.drawOver(model, manifest, {width - panelWidth, height, 1.0F, 0.0F, 0.0F, 1260, 1400}, more,
                      false);
    ImGui::Render();
}

void PanelHand::drag(ViewModel& model, test::Random& random) {
    auto& io = ImGui::GetIO();
    io.MousePos = {width - panelWidth * static_cast<float>(random.unit()),
                   height * static_cast<float>(random.unit())};
    draw(model);
    io.MouseDown[random.chance(0.05) ? ImGuiMouseButton_Right : ImGuiMouseButton_Left] = true;
    draw(model);
    io.MousePos.x += static_cast<float>(random.between(-40.0, 40.0));
    io.MousePos.y += static_cast<float>(random.between(-10.0, 10.0));
    draw(model);
    io.MouseDown[ImGuiMouseButton_Left] = io.MouseDown[ImGuiMouseButton_Right] = false;
    draw(model);
    draw(model);
}

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::util::MessageDifferencer;

/// Hears of each difference.
class Listener final : public MessageDifferencer::Reporter {
  public:
    using Message = google::protobuf::Message;
    using Path = std::vector<MessageDifferencer::SpecificField>;

    void ReportAdded(const Message&, const Message&, const Path& path) override { hear(path, true); }
    void ReportDeleted(const Message&, const Message&, const Path& path) override { hear(path, true); }
    void ReportModified(const Message&, const Message&, const Path& path) override { hear(path, false); }

    std::set<std::string> heard;

  private:
    void hear(const Path& path, bool came) {
        std::string name;
        for (std::size_t i = 0; i < path.size(); ++i) {
            const auto& field = *path[i].field;
            name += (i > 0 ? "." : "") + field.name();
            const bool isMessage = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
            const bool last = i + 1 == path.size(), whole = came && last;
            if (last && isMessage && !came) return;  // what of it is, is heard by itself
            if (field.is_repeated() && isMessage && !whole) name += fmt::format("[{}]", path[i].index);
        }
        heard.insert(name);
    }
};

}  // namespace

std::set<std::string> changedFields(const google::protobuf::Message& before,
                                    const google::protobuf::Message& after) {
    Listener listener;
    MessageDifferencer differencer;
    differencer.ReportDifferencesTo(&listener);
    differencer.Compare(before, after);
    std::set<std::string> fields;
    for (const auto& field : listener.heard) {
        const auto isOfGrown = [&](const std::string& list) { return field.starts_with(list + "["); };
        if (std::none_of(listener.heard.begin(), listener.heard.end(), isOfGrown)) fields.insert(field);
    }
    return fields;
}

}  // namespace mote::client
