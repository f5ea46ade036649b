// SPDX-License-Identifier: GPL-3.0-or-later
//
// Window: a GLFW window with an OpenGL 3.3 context and Dear ImGui in it. Move-only by being neither; main
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "client/view/changed_parts.h"
#include "client/view/hand/steering.h"
#include "client/view/letters.h"
#include "protocol/base/error.h"

struct GLFWwindow;

namespace mote::client {

class WindowError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A key that was pressed, as people write it: "Ctrl+Shift+Z", "Right", "Space", "F11"; what is no letter, by
/// what it types: "?", "[".
struct PressedKey {
    std::string chord;
    bool repeated = false;  ///< it stays down
};

/// PartCopy: shows a part of what was drawn and leaves the rest of the window as it is, by
/// GLX_MESA_copy_sub_buffer. Only where a processor draws the window: a graphics card shows all of it sooner.
class PartCopy {
  public:
    PartCopy() = default;
    /// For the window whose context is current.
    static PartCopy ofCurrentContext();
    bool exists() const { return copy_ != nullptr; }
    /// `height` of the window, pixels.
    void show(const WindowPart& part, int height) const;

  private:
    using Copy = void (*)(void* display, unsigned long drawable, int x, int y, int width, int height);
    Copy copy_ = nullptr;
    void* display_ = nullptr;
    unsigned long drawable_ = 0;
};

class Window {
  public:
    /// Size in screen coordinates. Throws WindowError: no display, no OpenGL 3.3.
    Window(int width, int height, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    bool shouldClose() const;
    /// The user is to be asked first.
    void stayOpen();
    void setTitle(const std::string& title);
    /// Fills the screen, or is as it was before.
    void toggleFullScreen();
    /// Dark letters on light ground, or the other way round.
    void setLight(bool light);
    /// Letters that the user interface has from the next frame on.
    Letters& letters() { return letters_; }
    /// Waits for input, at most so long, then starts a frame of the user interface. True if something came.
    bool beginFrame(std::optional<double> seconds);
    /// Keys that this frame has, in order: each tap is one, however long frames take. Where something is
    /// typed into, the user interface has one change of a key a frame, so that it misses none either.
    std::vector<PressedKey> takeKeys() { return std::exchange(keys_, {}); }
    /// Keys wait for so many frames: what they are for is only being opened.
    void holdKeys(int frames) { held_ = frames; }
    /// A key is down now, 'A' to 'Z' by its place on a keyboard of the United States.
    bool isHeld(char letter) const;
    /// Gamepads and 3D mice, as they are now; none while they are not used. They wake a waiting beginFrame.
    Devices devices() const;
    void useDevices(bool used);
    /// Draws the user interface into the back buffer; of a window that a processor draws, what is not as in
    /// the frame before.
    void drawFrame();
    /// Shows what was drawn.
    void presentFrame();
    /// A texture of the user interface has other pixels.
    static void noteTexture(void* texture);
    /// Wakes a waiting beginFrame, if a window is open; any thread.
    static void wake();

    int framebufferWidth() const;   ///< pixels
    int framebufferHeight() const;  ///< pixels
    /// Pixels to a screen coordinate, more than 1 on dense displays.
    float contentScale() const;
    /// The window as it is drawn, RGB, row 0 on top. Between drawFrame and presentFrame: what a window system
    /// keeps of a shown frame cannot be relied on.
    std::vector<std::uint8_t> readPixels();

  private:
    static void onKey(GLFWwindow* window, int key, int scancode, int action, int mods);
    static void onLetter(GLFWwindow* window, unsigned codepoint);
    static void onEnter(GLFWwindow* window, int entered);
    static void onMove(GLFWwindow* window, double x, double y);
    static void onButton(GLFWwindow* window, int button, int action, int mods);
    static void onDevice(int device, int event);
    static void onExposed(GLFWwindow* window);

    /// A key, or a letter that was typed (then `letter` is not 0).
    struct KeyEvent {
        int key, scancode, action, mods;
        unsigned letter;
    };

    /// A button of the mouse, where the pointer was then.
    struct ButtonEvent {
        int button;
        bool down;
        float x, y;
    };

    void drawPart(const WindowPart& part) const;
    bool waitForInput(std::optional<double> seconds);
    bool waitBesideDevices(std::optional<double> seconds);
    /// One button changes in a frame, in the place where it did: a long frame makes no other of it.
    void pourButtons();
    void pourKeys();
    void pour(const KeyEvent& event);

    GLFWwindow* window_ = nullptr;
    Letters letters_;
    ChangedParts changes_;
    std::optional<std::vector<WindowPart>> drawn_;  // parts of this frame; null: all of it
    PartCopy partCopy_;
    std::deque<KeyEvent> events_;  // that no frame had yet
    int held_ = 0;                 // frames
    std::vector<PressedKey> keys_;
    std::deque<ButtonEvent> buttons_;  // that no frame had yet
    bool usesDevices_ = true;
    std::vector<int> pads_, pucks_;  // GLFW's numbers of those that are connected
    std::array<bool, 3> down_{};
    bool isInside_ = false;
    float pointerX_ = 0.0F, pointerY_ = 0.0F;  // as the window system told it last
    std::array<int, 4> place_{};  // of a window that fills the screen, before: x, y, width, height
};

/// PictureTexture: the frame that is shown, as an OpenGL texture. Owned by the viewer; main thread, its
/// context current.
class PictureTexture {
  public:
    PictureTexture();
    ~PictureTexture();
    PictureTexture(const PictureTexture&) = delete;
    PictureTexture& operator=(const PictureTexture&) = delete;

    /// RGBA, 8 bits, sRGB-encoded, row 0 on top; `pixels` holds 4 * width * height bytes.
    void upload(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height);
    /// It is drawn into so many pixels: where they are its own each is read once and not mixed of four, which
    /// costs a processor that draws the window most of its time.
    void drawnInto(std::uint32_t width, std::uint32_t height);
    /// What Dear ImGui calls it.
    void* handle() const;
    bool empty() const { return width_ == 0; }

  private:
    unsigned texture_ = 0;
    std::uint32_t width_ = 0, height_ = 0;
    bool mixed_ = true;
};

/// Writes pixels as a PNG that appears by one rename: RGB, 8 bits, row 0 on top. Errors: PartFile's,
/// invalidArgument (a window without a size), with the file's name.
Status writeScreenshot(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                       int height);

}  // namespace mote::client
