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
#include <set>
#include <string_view>

#include "protocol/scene/mote_check.h"

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

void loadFont(float scale) {
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // the panel has one place; nothing to remember
    // A readable font where the system has it; Dear ImGui's own bitmap font otherwise.
    const char* font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    if (std::filesystem::exists(font)) io.Fonts->AddFontFromFileTTF(font, 14.0F * scale);
}

}  // namespace

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
    loadFont(contentScale());
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    // In place of Dear ImGui's, which hear of keys when a frame has them.
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, onKey);
    glfwSetCharCallback(window_, onLetter);
    glfwSetCursorPosCallback(window_, onMove);
    glfwSetMouseButtonCallback(window_, onButton);
    glfwSetJoystickCallback(onDevice);
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
        io.MousePos = {event.x, event.y};
    }
    std::ranges::copy(down_, io.MouseDown);
}

void Window::pour(const KeyEvent& event) {
    const auto pressed = [&](const std::string& chord) {
        keys_.push_back({chord, event.action == GLFW_REPEAT});
    };
    if (event.letter != 0) {
        constexpr std::string_view others = "?[]+-";
        ImGui_ImplGlfw_CharCallback(window_, event.letter);
        const bool plain = event.letter < 128 && others.find(static_cast<char>(event.letter)) != others.npos;
        if (plain) pressed(std::string(1, static_cast<char>(event.letter)));
        return;
    }
    ImGui_ImplGlfw_KeyCallback(window_, event.key, event.scancode, event.action, event.mods);
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
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    pourButtons();
    ImGui::NewFrame();
    return came;
}

void Window::drawFrame() {
    ImGui::Render();
    glViewport(0, 0, framebufferWidth(), framebufferHeight());
    glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::presentFrame() {
    glfwSwapBuffers(window_);
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

std::vector<std::uint8_t> Window::readPixels() const {
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
    glBindTexture(GL_TEXTURE_2D, texture_);
    for (const auto which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTexParameteri(GL_TEXTURE_2D, which, mixed ? GL_LINEAR : GL_NEAREST);
}

void* PictureTexture::handle() const {
    return reinterpret_cast<void*>(static_cast<std::uintptr_t>(texture_));
}

}  // namespace mote::client
