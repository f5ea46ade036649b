// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/window.h"

#include <epoxy/gl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "client/shared/part_file.h"
#include "client/shared/png_file.h"

namespace mote::client {

Status writeScreenshot(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                       int height) {
    if (width < 1 || height < 1) return invalid(path.string(), "the window shows no picture to be kept");
    const auto bytes =
        encodePng({static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 8, 3, rgb});
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(path));
    MOTE_RETURN_IF_ERROR(part->append(bytes));
    return part->publish();
}

}  // namespace mote::client

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>

#include "protocol/base/mote_check.h"

namespace mote::client {
namespace {

std::atomic<Window*> opened = nullptr;  // the one that there is, which can be woken
constexpr double devicePause = 0.03;    // seconds between looks at devices, which wake nobody

[[noreturn]] void fail(const char* what) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    throw WindowError(fmt::format("{}: {}", what, reason ? reason : "unknown reason"));
}

/// Keys that type nothing, and space.
constexpr std::array<std::pair<int, const char*>, 12> namedKeys{{{GLFW_KEY_LEFT, "Left"},
                                                                 {GLFW_KEY_RIGHT, "Right"},
                                                                 {GLFW_KEY_UP, "Up"},
                                                                 {GLFW_KEY_DOWN, "Down"},
                                                                 {GLFW_KEY_HOME, "Home"},
                                                                 {GLFW_KEY_END, "End"},
                                                                 {GLFW_KEY_SPACE, "Space"},
                                                                 {GLFW_KEY_TAB, "Tab"},
                                                                 {GLFW_KEY_ESCAPE, "Escape"},
                                                                 {GLFW_KEY_DELETE, "Delete"},
                                                                 {GLFW_KEY_F1, "F1"},
                                                                 {GLFW_KEY_F11, "F11"}}};

/// Letters are those of the user's keyboard. Empty: no key that a chord names.
std::string nameOfKey(int key, int scancode) {
    for (const auto& [code, name] : namedKeys) {
        if (code == key) return name;
    }
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9)  // wherever its digit is typed with Shift, too
        return std::string(1, static_cast<char>(key - GLFW_KEY_0 + '0'));
    const char* typed = glfwGetKeyName(key, scancode);
    if (typed == nullptr || typed[0] < 'a' || typed[0] > 'z' || typed[1] != 0) return {};
    return std::string(1, static_cast<char>(typed[0] - 'a' + 'A'));
}

void styleInterface(float scale, bool light) {
    ImGuiStyle& style = ImGui::GetStyle();
    style = ImGuiStyle();
    light ? ImGui::StyleColorsLight() : ImGui::StyleColorsDark();
    style.WindowRounding = 0.0F;
    style.FrameRounding = 4.0F;
    style.GrabRounding = 4.0F;
    style.WindowBorderSize = 0.0F;
    style.ItemSpacing = {8.0F, 6.0F};
    style.Colors[ImGuiCol_WindowBg] =
        light ? ImVec4(0.95F, 0.95F, 0.96F, 1.0F) : ImVec4(0.085F, 0.092F, 0.11F, 1.0F);
    style.Colors[ImGuiCol_Header] =
        light ? ImVec4(0.80F, 0.85F, 0.93F, 1.0F) : ImVec4(0.16F, 0.19F, 0.25F, 1.0F);
    style.Colors[ImGuiCol_PlotHistogram] =
        light ? ImVec4(0.55F, 0.72F, 0.98F, 1.0F) : ImVec4(0.18F, 0.38F, 0.70F, 1.0F);  // bars of progress
    if (light) {
        style.FrameBorderSize = 1.0F;  // white on nearly white
        style.Colors[ImGuiCol_TextDisabled] = {0.40F, 0.40F, 0.42F, 1.0F};
    }
    style.ScaleAllSizes(scale);
}

constexpr float letterHeight = 14.0F;  // screen coordinates at a content scale of 1

#if IMGUI_VERSION_NUM >= 18900
/// All events of a frame are for this frame: what must wait for the next one, the window keeps itself.
void takeEventsAtOnce() {
    ImGui::GetIO().ConfigInputTrickleEventQueue = false;
}

void pointTo(float x, float y) {
    ImGui::GetIO().AddMousePosEvent(x, y);
}

/// ImGuiKey_None if Dear ImGui's controls have no use for it.
ImGuiKey keyOf(int key) {
    static const std::map<int, ImGuiKey> named = {
        {GLFW_KEY_TAB, ImGuiKey_Tab},
        {GLFW_KEY_LEFT, ImGuiKey_LeftArrow},
        {GLFW_KEY_RIGHT, ImGuiKey_RightArrow},
        {GLFW_KEY_UP, ImGuiKey_UpArrow},
        {GLFW_KEY_DOWN, ImGuiKey_DownArrow},
        {GLFW_KEY_PAGE_UP, ImGuiKey_PageUp},
        {GLFW_KEY_PAGE_DOWN, ImGuiKey_PageDown},
        {GLFW_KEY_HOME, ImGuiKey_Home},
        {GLFW_KEY_END, ImGuiKey_End},
        {GLFW_KEY_INSERT, ImGuiKey_Insert},
        {GLFW_KEY_DELETE, ImGuiKey_Delete},
        {GLFW_KEY_BACKSPACE, ImGuiKey_Backspace},
        {GLFW_KEY_SPACE, ImGuiKey_Space},
        {GLFW_KEY_ENTER, ImGuiKey_Enter},
        {GLFW_KEY_KP_ENTER, ImGuiKey_KeypadEnter},
        {GLFW_KEY_ESCAPE, ImGuiKey_Escape},
    };
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) return static_cast<ImGuiKey>(ImGuiKey_A + (key - GLFW_KEY_A));
    const auto found = named.find(key);
    return found != named.end() ? found->second : ImGuiKey_None;
}

/// Modifiers are those of the event; ImGui_ImplGlfw_KeyCallback would ask which are held now.
void pressKey(GLFWwindow* /*window*/, int key, int /*scancode*/, int action, int mods) {
    struct Modifier {
        ImGuiKey key;
        int mask, left, right;
    };
    constexpr std::array modifiers = {
        Modifier{ImGuiMod_Ctrl, GLFW_MOD_CONTROL, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL},
        Modifier{ImGuiMod_Shift, GLFW_MOD_SHIFT, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT},
        Modifier{ImGuiMod_Alt, GLFW_MOD_ALT, GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT},
        Modifier{ImGuiMod_Super, GLFW_MOD_SUPER, GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER},
    };
    auto& io = ImGui::GetIO();
    const bool down = action != GLFW_RELEASE;
    for (const auto& each : modifiers) {
        const bool itself = key == each.left || key == each.right;
        io.AddKeyEvent(each.key, itself ? down : (mods & each.mask) != 0);
    }
    if (const auto known = keyOf(key); known != ImGuiKey_None) io.AddKeyEvent(known, down);
}
#else
void takeEventsAtOnce() {}

void pointTo(float x, float y) {
    ImGui::GetIO().MousePos = {x, y};
}

void pressKey(GLFWwindow* window, int key, int scancode, int action, int mods) {
    ImGui_ImplGlfw_KeyCallback(window, key, scancode, action, mods);
}
#endif

}  // namespace

PartCopy PartCopy::ofCurrentContext() {
    constexpr int accelerated = 0x8186;  // GLX_RENDERER_ACCELERATED_MESA
    using Ask = int (*)(int attribute, unsigned* value);
    PartCopy made;
    for (const char* needed : {"GLX_MESA_copy_sub_buffer", "GLX_MESA_query_renderer"}) {
        if (glfwExtensionSupported(needed) != GLFW_TRUE) return made;
    }
    const auto find = [](const char* name) { return glfwGetProcAddress(name); };
    const auto ask = reinterpret_cast<Ask>(find("glXQueryCurrentRendererIntegerMESA"));
    const auto display = reinterpret_cast<void* (*)()>(find("glXGetCurrentDisplay"));
    const auto drawable = reinterpret_cast<unsigned long (*)()>(find("glXGetCurrentDrawable"));
    const auto copy = reinterpret_cast<Copy>(find("glXCopySubBufferMESA"));
    unsigned card = 1;
    if (ask == nullptr || display == nullptr || drawable == nullptr || ask(accelerated, &card) == 0 ||
        card != 0)
        return made;
    made.display_ = display();
    made.drawable_ = drawable();
    made.copy_ = copy;
    return made;
}

void PartCopy::show(const WindowPart& part, int height) const {
    copy_(display_, drawable_, part.left, height - part.bottom, part.right - part.left,
          part.bottom - part.top);
}

Window::Window(int width, int height, const std::string& title) {
    if (glfwInit() == GLFW_FALSE) fail("no window system can be reached");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
        const char* reason = nullptr;
        glfwGetError(&reason);
        const auto message = fmt::format("no window with OpenGL 3.3: {}", reason ? reason : "unknown reason");
        glfwTerminate();
        throw WindowError(message);
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    ImGui::CreateContext();
    setLight(false);
    ImGui::GetIO().IniFilename = nullptr;  // the panel has one place; nothing to remember
    letters_.build(letterHeight * contentScale());
    takeEventsAtOnce();
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    // In place of Dear ImGui's, which hear of keys when a frame has them.
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, onKey);
    glfwSetCharCallback(window_, onLetter);
    glfwSetCursorEnterCallback(window_, onEnter);
    glfwSetCursorPosCallback(window_, onMove);
    glfwSetMouseButtonCallback(window_, onButton);
    glfwSetJoystickCallback(onDevice);
    glfwSetWindowRefreshCallback(window_, onExposed);
    partCopy_ = PartCopy::ofCurrentContext();
    opened = this;
    for (int device = GLFW_JOYSTICK_1; device <= GLFW_JOYSTICK_LAST; ++device) {
        if (glfwJoystickPresent(device) == GLFW_TRUE) onDevice(device, GLFW_CONNECTED);
    }
}

Window::~Window() {
    opened = nullptr;
    glfwSetJoystickCallback(nullptr);
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
    glfwTerminate();
}

bool Window::shouldClose() const {
    return glfwWindowShouldClose(window_) != GLFW_FALSE;
}

void Window::setTitle(const std::string& title) {
    glfwSetWindowTitle(window_, title.c_str());
}

void Window::stayOpen() {
    glfwSetWindowShouldClose(window_, GLFW_FALSE);
}

void Window::setLight(bool light) {
    styleInterface(contentScale(), light);
}

void Window::toggleFullScreen() {
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    if (glfwGetWindowMonitor(window_) != nullptr || monitor == nullptr) {
        const auto& [x, y, width, height] = place_;
        if (width > 0) glfwSetWindowMonitor(window_, nullptr, x, y, width, height, GLFW_DONT_CARE);
        return;
    }
    glfwGetWindowPos(window_, &place_[0], &place_[1]);
    glfwGetWindowSize(window_, &place_[2], &place_[3]);
    const GLFWvidmode* mode = glfwGetVideoMode(monitor);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::onKey(GLFWwindow* window, int key, int scancode, int action, int mods) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))
        ->events_.push_back({key, scancode, action, mods, 0});
}

void Window::onLetter(GLFWwindow* window, unsigned codepoint) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))
        ->events_.push_back({-1, 0, GLFW_PRESS, 0, codepoint});
}

void Window::onEnter(GLFWwindow* window, int entered) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->isInside_ = entered == GLFW_TRUE;
    ImGui_ImplGlfw_CursorEnterCallback(window, entered);
}

void Window::onMove(GLFWwindow* window, double x, double y) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
    self.pointerX_ = static_cast<float>(x);
    self.pointerY_ = static_cast<float>(y);
}

void Window::onButton(GLFWwindow* window, int button, int action, int /*mods*/) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
    if (button >= 0 && button < static_cast<int>(self.down_.size()))
        self.buttons_.push_back({button, action == GLFW_PRESS, self.pointerX_, self.pointerY_});
}

void Window::pourButtons() {
    auto& io = ImGui::GetIO();
    if (!buttons_.empty()) {
        const auto event = buttons_.front();
        buttons_.pop_front();
        down_[static_cast<std::size_t>(event.button)] = event.down;
        pointTo(event.x, event.y);
    } else if (isInside_ || std::ranges::find(down_, true) != down_.end()) {
        pointTo(pointerX_, pointerY_);
    }
    std::ranges::copy(down_, io.MouseDown);
}

void Window::pour(const KeyEvent& event) {
    const auto pressed = [&](const std::string& chord) {
        keys_.push_back({chord, event.action == GLFW_REPEAT});
    };
    if (event.letter != 0) {
        letters_.learn(static_cast<char32_t>(event.letter));
        constexpr std::string_view others = "?[]+-";
        ImGui_ImplGlfw_CharCallback(window_, event.letter);
        const bool plain = event.letter < 128 && others.find(static_cast<char>(event.letter)) != others.npos;
        if (plain) pressed(std::string(1, static_cast<char>(event.letter)));
        return;
    }
    pressKey(window_, event.key, event.scancode, event.action, event.mods);
    auto name = event.action == GLFW_RELEASE ? std::string() : nameOfKey(event.key, event.scancode);
    if (name.empty()) return;
    if ((event.mods & GLFW_MOD_SHIFT) != 0) name = "Shift+" + name;
    if ((event.mods & GLFW_MOD_ALT) != 0) name = "Alt+" + name;
    if ((event.mods & GLFW_MOD_CONTROL) != 0) name = "Ctrl+" + name;
    pressed(name);
}

void Window::pourKeys() {
    const bool typing = ImGui::GetIO().WantTextInput ||
                        ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
    std::set<int> changed;
    const bool waits = held_ > 0;
    held_ -= waits ? 1 : 0;
    for (bool ends = false; !ends && !events_.empty(); events_.pop_front()) {
        const auto event = events_.front();
        if (waits && event.action != GLFW_RELEASE) break;  // what is let go must not repeat itself
        if (event.letter == 0 && !changed.insert(event.key).second && typing) break;
        pour(event);
        const bool letter =
            event.letter != 0 || (event.key >= GLFW_KEY_SPACE && event.key <= GLFW_KEY_GRAVE_ACCENT);
        const bool modifier = event.key >= GLFW_KEY_LEFT_SHIFT && event.key <= GLFW_KEY_RIGHT_SUPER;
        // What follows may be for what this opens or ends.
        const bool pressed = event.action != GLFW_RELEASE && !modifier;
        ends = pressed && ((event.mods & GLFW_MOD_CONTROL) != 0 || (typing && !letter));
        const bool decides =
            event.key == GLFW_KEY_ENTER || event.key == GLFW_KEY_KP_ENTER || event.key == GLFW_KEY_ESCAPE;
        if (pressed && typing && decides) held_ = 2;
    }
}

bool Window::isHeld(char letter) const {
    return glfwGetKey(window_, GLFW_KEY_A + (letter - 'A')) == GLFW_PRESS;
}

void Window::onDevice(int device, int event) {
    auto& self = *opened.load();
    std::erase(self.pads_, device);
    std::erase(self.pucks_, device);
    if (event != GLFW_CONNECTED) return;
    if (glfwJoystickIsGamepad(device) == GLFW_TRUE) return self.pads_.push_back(device);
    int axes = 0;
    glfwGetJoystickAxes(device, &axes);
    const char* name = glfwGetJoystickName(device);
    if (isPuck(name != nullptr ? name : "", axes)) self.pucks_.push_back(device);
}

void Window::useDevices(bool used) {
    usesDevices_ = used;
}

Devices Window::devices() const {
    Devices all;
    for (std::size_t i = 0; usesDevices_ && i < pads_.size(); ++i) {
        GLFWgamepadstate state{};
        if (glfwGetGamepadState(pads_[i], &state) != GLFW_TRUE) continue;
        auto& pad = all.pads.emplace_back();
        std::ranges::copy(state.axes, pad.axes.begin());
        std::ranges::transform(state.buttons, pad.buttons.begin(), [](auto b) { return b == GLFW_PRESS; });
    }
    for (std::size_t i = 0; usesDevices_ && i < pucks_.size(); ++i) {
        int count = 0;
        const float* axes = glfwGetJoystickAxes(pucks_[i], &count);
        auto& puck = all.pucks.emplace_back();
        if (axes != nullptr && count == static_cast<int>(puck.axes.size()))
            std::copy_n(axes, count, puck.axes.begin());
    }
    return all;
}

/// False if none came.
bool Window::waitForInput(std::optional<double> seconds) {
    const double begin = glfwGetTime();
    if (!events_.empty() || !buttons_.empty()) {
        glfwPollEvents();
    } else if (usesDevices_ && !(pads_.empty() && pucks_.empty())) {
        return waitBesideDevices(seconds);
    } else if (seconds) {
        glfwWaitEventsTimeout(*seconds);
    } else {
        glfwWaitEvents();
    }
    return !seconds || !events_.empty() || !buttons_.empty() || glfwGetTime() - begin < *seconds;
}

bool Window::waitBesideDevices(std::optional<double> seconds) {
    const double begin = glfwGetTime();
    for (double now = begin; !seconds || now - begin < *seconds; now = glfwGetTime()) {
        const double pause = seconds ? std::min(*seconds - (now - begin), devicePause) : devicePause;
        glfwWaitEventsTimeout(pause);
        const bool woken = glfwGetTime() - now < pause;
        if (woken || !events_.empty() || !buttons_.empty() || !devices().atRest()) return true;
    }
    return false;
}

bool Window::beginFrame(std::optional<double> seconds) {
    const bool came = waitForInput(seconds);
    pourKeys();
    if (letters_.isStale()) {
        letters_.build(letterHeight * contentScale());
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
        changes_.forget();
    }
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    pourButtons();
    ImGui::NewFrame();
    return came;
}

void Window::onExposed(GLFWwindow* window) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->changes_.forget();
}

void Window::noteTexture(void* texture) {
    if (auto* window = opened.load()) window->changes_.touch(texture);
}

void Window::drawPart(const WindowPart& part) const {
    glViewport(0, 0, framebufferWidth(), framebufferHeight());
    glEnable(GL_SCISSOR_TEST);
    glScissor(part.left, framebufferHeight() - part.bottom, part.right - part.left, part.bottom - part.top);
    glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::drawFrame() {
    ImGui::Render();
    auto& data = *ImGui::GetDrawData();
    const WindowPart whole{0, 0, framebufferWidth(), framebufferHeight()};
    drawn_.reset();
    if (partCopy_.exists()) drawn_ = changes_.take(data);
    long long pixels = 0;
    for (const auto& part : drawn_.value_or(std::vector<WindowPart>())) pixels += part.pixels();
    if (2 * pixels > whole.pixels()) drawn_.reset();
    if (!drawn_) return drawPart(whole);
    for (const auto& part : *drawn_) {
        const auto clips = ChangedParts::clipTo(data, part);
        drawPart(part);
        ChangedParts::restoreClips(data, clips);
    }
}

void Window::presentFrame() {
    if (!drawn_) return glfwSwapBuffers(window_);
    for (const auto& part : *drawn_) partCopy_.show(part, framebufferHeight());
}

void Window::wake() {
    if (opened != nullptr) glfwPostEmptyEvent();
}

int Window::framebufferWidth() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return width;
}

int Window::framebufferHeight() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return height;
}

float Window::contentScale() const {
    float x = 1.0F, y = 1.0F;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::max(x, 1.0F);
}

std::vector<std::uint8_t> Window::readPixels() {
    if (drawn_) drawPart({0, 0, framebufferWidth(), framebufferHeight()});
    drawn_.reset();
    const auto width = static_cast<std::size_t>(framebufferWidth());
    const auto height = static_cast<std::size_t>(framebufferHeight());
    std::vector<std::uint8_t> pixels(3 * width * height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_BACK);
    glReadPixels(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height), GL_RGB, GL_UNSIGNED_BYTE,
                 pixels.data());
    for (std::size_t row = 0; row < height / 2; ++row) {
        std::swap_ranges(pixels.begin() + static_cast<std::ptrdiff_t>(3 * width * row),
                         pixels.begin() + static_cast<std::ptrdiff_t>(3 * width * (row + 1)),
                         pixels.begin() + static_cast<std::ptrdiff_t>(3 * width * (height - 1 - row)));
    }
    return pixels;
}

PictureTexture::PictureTexture() {
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

PictureTexture::~PictureTexture() {
    glDeleteTextures(1, &texture_);
}

void PictureTexture::upload(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height) {
    MOTE_CHECK(pixels.size() == 4ULL * width * height);
    Window::noteTexture(handle());
    glBindTexture(GL_TEXTURE_2D, texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
    if (width != width_ || height != height_) {
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, w, h, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
        width_ = width;
        height_ = height;
    } else {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    }
}

void PictureTexture::drawnInto(std::uint32_t width, std::uint32_t height) {
    const bool mixed = width != width_ || height != height_;
    if (std::exchange(mixed_, mixed) == mixed) return;
    Window::noteTexture(handle());
    glBindTexture(GL_TEXTURE_2D, texture_);
    for (const auto which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTexParameteri(GL_TEXTURE_2D, which, mixed ? GL_LINEAR : GL_NEAREST);
}

void* PictureTexture::handle() const {
    return reinterpret_cast<void*>(static_cast<std::uintptr_t>(texture_));
}

}  // namespace mote::client
