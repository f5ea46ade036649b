// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "client/shared/decode.h"
#include "client/shared/jobs.h"
#include "client/view/layers/field_controls.h"
#include "client/view/slider_values.h"
#include "protocol/scene/dataset.h"

namespace mote::client {
namespace {

const char* encodingName(proto::Frame::Encoding encoding) {
    switch (encoding) {
        case proto::Frame::ZSTD:
            return "lossless";
        case proto::Frame::H264:
            return "H.264";
        default:
            return H264Decoder::available() ? "JPEG" : "JPEG: libavcodec is not installed";
    }
}

/// Beyond a gigabit a second a link is as good as none.
std::string linkName(double bytesPerSecond) {
    if (bytesPerSecond <= 0.0) return "not measured";
    return bytesPerSecond > 125e6 ? "local" : metric(8.0 * bytesPerSecond, "bit/s");
}

/// A button that does what a command of the viewer does; `label` where it says more.
void commandButton(PanelActions& actions, const char* command, const char* label = nullptr) {
    if (ImGui::Button(label != nullptr ? label : command)) actions.command = command;
    if (label != nullptr && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command);
}

/// What is always at hand.
void drawMenu(PanelActions& actions) {
    commandButton(actions, "Open view...", "Open...");
    ImGui::SameLine();
    commandButton(actions, "Save view...", "Save...");
    ImGui::SameLine();
    commandButton(actions, "Undo");
    ImGui::SameLine();
    commandButton(actions, "Redo");
    ImGui::SameLine();
    commandButton(actions, "Commands", "Do...");
    ImGui::SameLine();
    commandButton(actions, "Keys", "?");
}

/// Where the time of the last picture went, the longest part first.
std::string whatLimits(const ServerState& server) {
    if (!server.frame) return {};
    const auto& frame = *server.frame;
    const double bytes =
        server.framesPerSecond > 0.0 ? server.bytesPerSecond / server.framesPerSecond : 0.0;  // of a picture
    const double link = frame.link_bytes_per_second();
    std::array<std::pair<double, const char*>, 4> parts{
        {{frame.queued_ms(), "waiting"},
         {frame.plan_ms() + frame.render_ms(), "drawing"},
         {frame.encode_ms(), "encoding"},
         {server.roundTripMs + (link > 0.0 ? 1000.0 * bytes / link : 0.0), "the line"}}};
    std::ranges::sort(parts, std::greater<>());
    std::string said = "The last picture:";
    for (const auto& [milliseconds, part] : parts) said += fmt::format("\n{:.1f} ms {}", milliseconds, part);
    return said;
}

void drawConnection(const ServerState& server, PanelActions& actions) {
    dim(server.connection);
    const auto limits = whatLimits(server);
    if (!server.connected) {
        commandButton(actions, "Connect now");
    } else {
        text(fmt::format("{:.1f} frames/s   {:.1f} ms   {}", server.framesPerSecond, server.roundTripMs,
                         metric(server.bytesPerSecond, "B/s")));
        helpAtRest(limits);
    }
    if (server.frame) {
        const auto& frame = *server.frame;
        text(fmt::format("{}   {} x {}   {}", metric(static_cast<double>(frame.points_drawn()), "points"),
                         frame.width(), frame.height(), frame.final() ? "exact" : "refining"));
        helpAtRest(limits);
        text(fmt::format("{}   link {}", encodingName(frame.encoding()),
                         linkName(frame.link_bytes_per_second())));
        helpAtRest(limits);
        ImGui::SameLine();
        bool saves = server.savesData;
        ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0.0F, 0.0F});  // as high as the line
        if (ImGui::Checkbox("data saver", &saves)) actions.command = "Data saver on or off";
        ImGui::PopStyleVar();
        helpAtRest("for a line that is paid for: smaller pictures, and few of them while they move");
    }
}

/// What a loaded view says of steps that the slider cannot show.
void drawOddStep(ViewModel& model, PanelActions& actions) {
    const auto last = static_cast<std::uint32_t>(std::max(model.steps(), 1)) - 1;
    if (const auto towards = model.towards())
        dim(fmt::format("{:.4g}% of the way to step {}", 100.0 * towards->share(), towards->step()));
    if (model.step() <= last) return;
    dim(fmt::format("The view shows step {}, which the dataset does not have.", model.step()));
    if (!ImGui::Button(fmt::format("Show step {}", last).c_str())) return;
    model.setStep(last);
    actions.viewChanged = true;
}

/// Where several kinds of layers draw the dataset.
void drawKinds(ViewModel& model, const proto::Manifest& manifest, PanelActions& actions) {
    const auto kinds = layersThatDraw(manifest.kind());
    // A loaded view may say one that does not.
    const bool drawn = std::find(kinds.begin(), kinds.end(), model.kind()) != kinds.end();
    if (kinds.size() < 2 || !drawn) return;
    const auto nameOf = [](proto::Layer::KindCase kind) -> std::string_view {
        return proto::Layer::descriptor()->FindFieldByNumber(kind)->name();
    };
    std::vector<std::string_view> names;
    for (const auto kind : kinds) names.push_back(nameOf(kind));
    std::string chosen(nameOf(model.kind()));
    nameList(actions, "drawn as", chosen, names);
    model.drawAs(
        kinds[static_cast<std::size_t>(std::find(names.begin(), names.end(), chosen) - names.begin())],
        manifest);
}

/// `facts`: also what the shown step holds, and its axes.
void drawDataset(ViewModel& model, LayerPanel& layer, bool facts) {
    if (!section("Dataset")) return;
    const auto label = model.dataset() + "##dataset";
    ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, {0.0F, 0.5F});
    if (ImGui::Button(label.c_str(), {ImGui::CalcItemWidth(), 0.0F}))
        layer.actions.command = "Open dataset...";
    ImGui::PopStyleVar();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("another one (D)");
    ImGui::SameLine(0.0F, ImGui::GetStyle().ItemInnerSpacing.x);
    text("dataset");
    if (!layer.server.shown || !model.isDescribed()) return;
    drawOddStep(model, layer.actions);
    layer.step = model.step();
    if (!facts) return;
    drawKinds(model, layer.server.shown->manifest(), layer.actions);
    model.editor().drawFacts(layer);
}

bool isMissing(const ServerState& server, const std::string& dataset) {
    const auto& known = server.catalogue.datasets();
    return !dataset.empty() && server.connected &&
           std::ranges::none_of(known, [&](const auto& entry) { return entry.name() == dataset; });
}

/// An eye, a name that is dragged to another place; the topmost is drawn last.
void drawLayerRow(ViewModel& model, int index, const LayerPanel& panel) {
    const std::string dataset = model.layers().Get(index).dataset();
    const std::string given = model.layers().Get(index).name();
    const auto shownKind = model.layers().Get(index).kind_case();
    ImGui::PushID(index);
    bool shown = model.isShown(index);
    if (ImGui::Checkbox("##eye", &shown)) {
        model.setShown(index, shown);
        panel.actions.viewChanged = true;
    }
    fieldHelp(proto::Layer::default_instance(), proto::Layer::kHiddenFieldNumber);
    ImGui::SameLine();
    const bool missing = isMissing(panel.server, dataset);
    const auto& kind = proto::Layer::descriptor()->FindFieldByNumber(shownKind)->name();
    const auto name =
        fmt::format("{}{}  {}", given.empty() ? dataset : given, missing ? " (missing)" : "", kind);
    if (missing) pushWarningColor();
    // The dataset alone tells it, so that it stays the same while its name is typed.
    if (ImGui::Selectable((name + "###" + dataset).c_str(), index == model.chosen())) model.choose(index);
    if (missing) ImGui::PopStyleColor();
    if (!given.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", dataset.c_str());
    if (ImGui::BeginDragDropSource()) {
        ImGui::SetDragDropPayload("layer", &index, sizeof index);
        text(name);
        ImGui::EndDragDropSource();
    }
    if (ImGui::BeginDragDropTarget()) {
        if (const auto* dropped = ImGui::AcceptDragDropPayload("layer")) {
            model.moveLayer(*static_cast<const int*>(dropped->Data), index);
            panel.actions.viewChanged = true;
        }
        ImGui::EndDragDropTarget();
    }
    ImGui::PopID();
}

/// What people call the chosen layer; what is no name is not taken.
void drawLayerName(ViewModel& model, PanelActions& actions) {
    std::array<char, Layer::maxNameBytes + 1> typed{};
    const auto& name = model.layer().name();
    std::copy_n(name.begin(), std::min(name.size(), typed.size() - 1), typed.begin());
    const bool changed =
        ImGui::InputTextWithHint("layer's name", model.dataset().c_str(), typed.data(), typed.size());
    fieldHelp(model.layer(), proto::Layer::kNameFieldNumber);
    actions.viewChanged |= changed && model.setName(model.chosen(), typed.data()).ok();
}

void drawLayers(ViewModel& model, const LayerPanel& panel) {
    if (!section("Layers")) return;
    const int count = model.layers().size();
    for (int i = model.layers().size() - 1; i >= 0 && model.layers().size() == count; --i)
        if (model.layers().Get(i).kind_case() != proto::Layer::KIND_NOT_SET) drawLayerRow(model, i, panel);
    commandButton(panel.actions, "Add dataset...", "Add...");
    ImGui::SameLine();
    ImGui::BeginDisabled(model.layers().empty());
    if (ImGui::Button("Duplicate")) {
        model.duplicateLayer(model.chosen());
        panel.actions.viewChanged = true;
    }
    ImGui::SameLine();
    commandButton(panel.actions, "Replace dataset...", "Replace...");
    ImGui::SameLine();
    if (ImGui::Button("Remove")) {
        model.removeLayer(model.chosen());
        panel.actions.viewChanged = true;
    }
    ImGui::EndDisabled();
    if (model.layers().empty()) return dim("Nothing is drawn: add a dataset.");
    drawLayerName(model, panel.actions);
    auto opacity = static_cast<float>(model.layer().has_opacity() ? model.layer().opacity() : 1.0);
    const float before = opacity;
    slider(panel.actions, "layer's opacity", opacity, 0.0F, 1.0F);
    fieldHelp(model.layer(), proto::Layer::kOpacityFieldNumber);
    if (opacity != before) model.setOpacity(model.chosen(), share(decimal(opacity)));
    text("style");
    ImGui::SameLine();
    commandButton(panel.actions, "Copy style", "Copy");
    ImGui::SameLine();
    commandButton(panel.actions, "Paste style", "Paste");
    ImGui::SameLine();
    commandButton(panel.actions, "Open style...", "Open...");
    ImGui::SameLine();
    commandButton(panel.actions, "Save style...", "Save...");
}

void drawTypedCamera(ViewModel& model, PanelActions& actions) {
    if (!ImGui::TreeNode("by numbers")) return;
    auto camera = model.camera(1.0);
    bool typed = typeNumbers("eye", camera.eye);
    typed |= typeNumbers("target", camera.target);
    typed |= typeNumbers("up", camera.up);
    double& span = camera.perspective() ? camera.fovYDegrees : *camera.orthographicHeight;
    typed |= ImGui::InputDouble(camera.perspective() ? "angle, deg" : "height", &span, 0.0, 0.0, "%.6g",
                                ImGuiInputTextFlags_EnterReturnsTrue);
    if (typed && parseCamera(toProto(camera)).ok()) {  // others are no cameras
        model.setCamera(camera);
        actions.viewChanged = true;
    }
    ImGui::TreePop();
}

void drawDepthContrast(ViewModel& model, PanelActions& actions) {
    proto::View view;
    view.set_depth_contrast(model.depthContrast());
    const proto::View shown = view;
    const auto alone = [](std::string_view name) { return name == "depthContrast"; };
    if (fieldControls(actions, view, shown, alone)) model.setDepthContrast(view.depth_contrast());
}

/// A camera's name goes there; what else can be done with it is behind the dots.
void drawNamedCamera(const NamedCamera& camera, std::size_t index, PanelActions& actions) {
    using What = CameraWish::What;
    const float dots = ImGui::CalcTextSize("...").x + 2.0F * ImGui::GetStyle().FramePadding.x;
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    ImGui::PushID(static_cast<int>(index));
    ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, {0.0F, 0.5F});
    if (ImGui::Button((camera.name + "###go").c_str(), {ImGui::GetContentRegionAvail().x - dots - gap, 0.0F}))
        actions.camera = CameraWish{What::go, index};
    ImGui::PopStyleVar();
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", index < 9 ? fmt::format("go there ({})", index + 1).c_str() : "go there");
    ImGui::SameLine(0.0F, gap);
    std::array<char, NamedCamera::maxNameBytes + 1> typed{};
    std::copy_n(camera.name.begin(), std::min(camera.name.size(), typed.size() - 1), typed.begin());
    if (ImGui::Button("...")) ImGui::OpenPopup("camera");
    if (ImGui::BeginPopup("camera")) {
        endByEscape();
        if (ImGui::InputText("name", typed.data(), typed.size(), ImGuiInputTextFlags_EnterReturnsTrue)) {
            if (typed[0] != '\0') actions.camera = CameraWish{What::rename, index, typed.data()};
            ImGui::CloseCurrentPopup();
        }
        if (ImGui::Selectable("Replace by what is seen now"))
            actions.camera = CameraWish{What::replace, index};
        if (ImGui::Selectable("Remove")) actions.camera = CameraWish{What::remove, index};
        ImGui::EndPopup();
    }
    ImGui::PopID();
}

void drawNamedCameras(std::span<const NamedCamera> cameras, PanelActions& actions) {
    static std::array<char, NamedCamera::maxNameBytes + 1> typed{};
    bool keep = ImGui::InputTextWithHint("##camera's name", "this camera's name", typed.data(), typed.size(),
                                         ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine(0.0F, ImGui::GetStyle().ItemInnerSpacing.x);
    keep |= ImGui::Button("Keep it");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("under this name, or as \"camera 1\", for this dataset");
    if (keep) {
        actions.camera = CameraWish{CameraWish::What::keep, 0, typed.data()};
        typed.fill('\0');
    }
    for (std::size_t i = 0; i < cameras.size(); ++i) drawNamedCamera(cameras[i], i, actions);
}

void drawCamera(ViewModel& model, std::span<const NamedCamera> cameras, PanelActions& actions) {
    if (!section("Camera")) return;
    commandButton(actions, "Fit", "Fit (F)");
    ImGui::SameLine();
    commandButton(actions, "Other projection",
                  model.camera(1.0).perspective() ? "Orthographic (O)" : "Perspective (O)");
    ImGui::SameLine();
    commandButton(actions, "Film", "Film (K)");
    commandButton(actions, "Save picture...");
    ImGui::SameLine();
    commandButton(actions, "Copy picture", "Copy it");
    ImGui::SameLine();
    commandButton(actions, "Copy the command that makes this picture", "Copy command");
    commandButton(actions, "Camera before", "<");
    ImGui::SameLine();
    commandButton(actions, "Camera after", ">");
    ImGui::SameLine();
    text("from");
    constexpr std::array<std::array<const char*, 2>, 6> sides{{{"Look from -x", "-x"},
                                                               {"Look from +x", "+x"},
                                                               {"Look from -y", "-y"},
                                                               {"Look from +y", "+y"},
                                                               {"Look from -z", "-z"},
                                                               {"Look from +z", "+z"}}};
    for (const auto& [command, label] : sides) {
        ImGui::SameLine();
        commandButton(actions, command, label);
    }
    drawNamedCameras(cameras, actions);
    if (model.layers().size() > 1) drawDepthContrast(model, actions);
    drawTypedCamera(model, actions);
}

void drawViews(const PanesShown& panes, PanelActions& actions) {
    if (!section("Views")) return;
    constexpr std::array<std::pair<const char*, const char*>, 3> counts{
        {{"One view", "1##views"}, {"Two views", "2##views"}, {"Four views", "4##views"}}};
    for (const auto& [command, label] : counts) {
        commandButton(actions, command, label);
        ImGui::SameLine();
    }
    text("in the window");
    if (panes.count < 2) return;
    ImGui::AlignTextToFramePadding();
    text("linked");
    const std::array<std::tuple<const char*, const char*, bool>, 3> links{
        {{"Link or unlink steps", "step##views", panes.links.steps},
         {"Link or unlink selections", "selection##views", panes.links.selections},
         {"Link or unlink cameras", "camera##views", panes.links.cameras}}};
    for (auto [command, label, linked] : links) {
        ImGui::SameLine();
        if (ImGui::Checkbox(label, &linked)) actions.command = command;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command);
    }
}

/// The last lines that a job wrote.
void drawLog(const proto::JobStatus& job) {
    if (job.log().empty() || !ImGui::TreeNode("log")) return;
    for (const auto& line : job.log()) dim(line);
    ImGui::TreePop();
}

/// What can be done with a job, and why it ended so.
void drawJob(const proto::JobStatus& job, PanelActions& actions) {
    ImGui::PushID(job.id().c_str());
    const bool ended = job.state() == proto::JobStatus::SUCCEEDED;
    text(fmt::format("{}: {}", jobName(job.request()), stateName(job.state())));
    if (isUnderWay(job)) {
        const float button = ImGui::CalcTextSize("Cancel").x + 2.0F * ImGui::GetStyle().FramePadding.x;
        const auto said = fmt::format("{:.0f}%  {}", 100.0 * job.progress(), job.phase());
        ImGui::ProgressBar(static_cast<float>(job.progress()),
                           {-button - ImGui::GetStyle().ItemSpacing.x, ImGui::GetFrameHeight()},
                           said.c_str());
        ImGui::SameLine();
        if (ImGui::Button("Cancel")) actions.cancelJob = job.id();
    }
    if (isReadyFilm(job)) {
        if (ImGui::SmallButton("Save film...")) actions.saveFilm = job.id();
        ImGui::SameLine();
    }
    if (ended && !job.request().output().empty()) {
        if (ImGui::SmallButton("Open it")) actions.openDataset = datasetName(job.request());
    } else if (ended && ImGui::SmallButton("Again")) {
        actions.retryJob = job.id();
    }
    if (mayBeTriedAgain(job) && ImGui::SmallButton("Try again")) actions.retryJob = job.id();
    if (!job.error().empty()) dim(job.error());
    drawLog(job);
    ImGui::PopID();
}

/// What the drawer says while it is shut: what is under way, or how the last one ended.
std::string jobsInShort(const ServerState& server) {
    const auto underWay = std::ranges::count_if(server.jobs, isUnderWay);
    const auto last = std::ranges::find_if(server.jobs, isUnderWay);
    if (server.jobs.empty()) return "Jobs: none";
    if (underWay == 0)
        return fmt::format("Jobs: {} {}", jobName(server.jobs.front().request()),
                           stateName(server.jobs.front().state()));
    const auto more = underWay > 1 ? fmt::format(" and {} more", underWay - 1) : std::string();
    return fmt::format("Jobs: {:.0f}% of {}{}", 100.0 * last->progress(), jobName(last->request()), more);
}

/// Below all else of the panel, whatever that shows: it is never scrolled away.
class JobDrawer {
  public:
    explicit JobDrawer(const ServerState& server)
        : server_(server), open_(ImGui::GetID("jobs open")), content_(ImGui::GetID("jobs content")) {}

    float height() const {
        const float row = ImGui::GetFrameHeightWithSpacing();
        return isOpen() ? row + list() + ImGui::GetStyle().ItemSpacing.y : row;
    }

    void draw(PanelActions& actions) {
        ImGui::SetNextItemOpen(isOpen());
        const bool open = ImGui::CollapsingHeader((jobsInShort(server_) + "###jobs").c_str());
        ImGui::GetStateStorage()->SetBool(open_, open);
        drawProgress();
        if (!open) return;
        ImGui::BeginChild("jobs", {0.0F, list()});
        for (const auto& job : server_.jobs) drawJob(job, actions);
        if (server_.jobs.empty()) dim("What is prepared, and films that the server makes, stand here.");
        if (server_.jobs.size() < server_.allJobs && ImGui::SmallButton("Older jobs..."))
            actions.moreJobs = true;
        const float content = ImGui::GetCursorPosY();
        ImGui::EndChild();
        ImGui::GetStateStorage()->SetFloat(content_, content);
    }

  private:
    bool isOpen() const { return ImGui::GetStateStorage()->GetBool(open_, false); }
    /// As much as there is, and no more than leaves the panel usable.
    float list() const {
        const float wanted = ImGui::GetStateStorage()->GetFloat(content_, 3.0F * ImGui::GetFrameHeight());
        return std::min(wanted, 0.4F * ImGui::GetIO().DisplaySize.y);
    }
    /// A line along the header.
    void drawProgress() const {
        const auto job = std::ranges::find_if(server_.jobs, isUnderWay);
        if (job == server_.jobs.end()) return;
        const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
        const float along = static_cast<float>(std::clamp(job->progress(), 0.0, 1.0)) * (to.x - from.x);
        ImGui::GetWindowDrawList()->AddRectFilled({from.x, to.y - 0.15F * ImGui::GetFontSize()},
                                                  {from.x + along, to.y},
                                                  ImGui::GetColorU32(ImGuiCol_SliderGrabActive));
    }

    const ServerState& server_;
    ImGuiID open_, content_;
};

/// The panel's left edge, which is dragged; a double click gives it its usual place again.
void drawEdge(float width, float scale, PanelActions& actions) {
    const ImVec2 display = ImGui::GetIO().DisplaySize, before = ImGui::GetCursorPos();
    const ImVec2 corner{display.x - width * scale, 0.0F};
    ImGui::SetCursorScreenPos(corner);
    ImGui::PushClipRect(corner, display, false);  // within the padding, too
    ImGui::InvisibleButton("edge", {5.0F * scale, display.y});
    ImGui::PopClipRect();
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    const bool usual = ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    // Let go, it is where the pointer was then: a long frame has missed the way there.
    const bool held = ImGui::IsItemActive() || ImGui::IsItemDeactivated();
    const auto& io = ImGui::GetIO();
    const bool moved = held && std::abs(io.MousePos.x - io.MouseClickedPos[0].x) > 3.0F;
    const float most = std::max(0.75F * display.x / scale, leastPanelWidth);
    if (moved) actions.panelWidth = std::clamp((display.x - io.MousePos.x) / scale, leastPanelWidth, most);
    if (usual) actions.panelWidth = panelWidth;
    ImGui::SetCursorPos(before);
}

/// Two sides of the panel, as tabs where the layer has numbers.
void drawSides(ViewModel& model, NumbersEditor& numbers, Handles& handles, const PanesShown& panes,
               LayerPanel& layer) {
    const auto drawPicture = [&] {
        drawBrush(model, handles.brush, layer);
        if (model.kind() != proto::Layer::KIND_NOT_SET) model.editor().draw(layer);
        drawCutAway(model, handles, layer);
        drawPlacement(model, handles, layer);
        drawCamera(model, panes.cameras, layer.actions);
        drawViews(panes, layer.actions);
        drawAnnotations(layer.actions, model.numbers.annotations);
    };
    if (!layer.server.shown || model.kind() != proto::Layer::kParticles) return drawPicture();
    const float gap = ImGui::GetStyle().ItemSpacing.x;
    const float width = 0.5F * (ImGui::GetContentRegionAvail().x - gap);
    const char* labels[] = {"Picture", "Numbers (N)"};
    for (const bool side : {false, true}) {
        if (side) ImGui::SameLine();
        const bool chosen = numbers.open == side;
        if (chosen) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
        if (ImGui::Button(labels[side ? 1 : 0], {width, 0.0F})) numbers.open = side;
        if (chosen) ImGui::PopStyleColor();
    }
    if (!numbers.open) return drawPicture();
    numbers.drawPanel(model, layer.server.shown->manifest(), layer.scale, layer.actions);
}

}  // namespace

PanelActions drawPanel(ViewModel& model, NumbersEditor& numbers, Handles& handles, const ServerState& server,
                       const PanesShown& panes, float scale, float width) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x - width * scale, 0.0F});
    ImGui::SetNextWindowSize({width * scale, display.y});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoScrollWithMouse);
    PanelActions actions;
    drawEdge(width, scale, actions);
    JobDrawer jobs(server);
    ImGui::BeginChild("controls", {0.0F, -jobs.height()});
    ImGui::PushItemWidth(-95.0F * scale);
    LayerPanel layer{server, model.step(), model.camera(1.0).eye, scale, model.background, actions};
    drawMenu(actions);
    drawConnection(server, actions);
    // Numbers need the room.
    const bool roomy = !(numbers.open && model.kind() == proto::Layer::kParticles);
    drawDataset(model, layer, roomy);
    if (roomy) drawLayers(model, layer);
    drawSides(model, numbers, handles, panes, layer);
    ImGui::PopItemWidth();
    ImGui::EndChild();
    jobs.draw(actions);
    ImGui::End();
    return actions;
}

}  // namespace mote::client
