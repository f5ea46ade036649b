// SPDX-License-Identifier: GPL-3.0-or-later
//
// Window: a GLFW window with an OpenGL 3.3 context and Dear ImGui in it. Move-only by being neither; main
// thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/scene/error.h"

struct GLFWwindow;

namespace mote::client {

class WindowError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

class Window {
  public:
    /// Size in screen coordinates. Throws WindowError: no display, no OpenGL 3.3.
    Window(int width, int height, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    bool shouldClose() const;
    void setTitle(const std::string& title);
    /// Waits up to `seconds` for input, then starts a frame of the user interface.
    void beginFrame(double seconds);
    /// Draws the user interface into the back buffer.
    void drawFrame();
    /// Shows what was drawn.
    void presentFrame();
    /// Wakes a waiting beginFrame; any thread.
    static void wake();

    int framebufferWidth() const;   ///< pixels
    int framebufferHeight() const;  ///< pixels
    /// Pixels to a screen coordinate, more than 1 on dense displays.
    float contentScale() const;
    /// What was drawn, RGB, row 0 on top. Between drawFrame and presentFrame: what a window system keeps of a
    /// shown frame cannot be relied on.
    std::vector<std::uint8_t> readPixels() const;

  private:
    GLFWwindow* window_ = nullptr;
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
    /// What Dear ImGui calls it.
    void* handle() const;
    bool empty() const { return width_ == 0; }

  private:
    unsigned texture_ = 0;
    std::uint32_t width_ = 0, height_ = 0;
};

/// Writes pixels as a PNG that appears by one rename: RGB, 8 bits, row 0 on top. Errors: PartFile's,
/// invalidArgument (a window without a size), with the file's name.
Status writeScreenshot(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                       int height);

}  // namespace mote::client
