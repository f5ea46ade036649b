// SPDX-License-Identifier: GPL-3.0-or-later
//
// ViewFiles: where views are opened from and saved to, as the panel asks for it. Owned by the viewer; main
// thread.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace mote::client {

/// "~/film.json" as the shell has it.
std::filesystem::path expandHome(const std::string& typed);

/// A line for a shell that makes the picture of a saved view, with a running server or, if there are roots
/// ("NAME=DIR"), one of its own.
std::string commandOf(const std::filesystem::path& view, const std::filesystem::path& connection,
                      const std::vector<std::string>& spawn);

/// A line that the user's wish for all windows is kept in, in the folder of sessions; empty: none yet.
std::string keptWish(const char* name);
/// Keeps it; false if that cannot be.
bool keepWish(const char* name, const std::string& line);

/// Asks the user for the path of a file, in a window above all others. It stays until what was
/// asked for is done: its owner closes it, or lets it say what went wrong. Main thread, within a Dear ImGui
/// frame.
class PathPrompt {
  public:
    /// `verb` is on its button; `usual` is what it offers at first. `mayReplace`: what is there is replaced,
    /// but only once the user has said so.
    PathPrompt(std::string title, std::string verb, const std::string& usual, bool mayReplace);

    /// What was typed stays, unless a path is given that ends otherwise (".mp4").
    void open(const std::filesystem::path& usual = {});
    /// Something was typed, or offered.
    bool hasPath() const { return typed_[0] != '\0'; }
    /// Says what went wrong, as one sentence.
    void fail(std::string sentence);
    void close() { closing_ = true; }

    /// Tells whether the user has said that what has this path may be replaced.
    bool agreed(const std::filesystem::path& path) const { return agreed_ == path; }

    /// Draws it while it is open; the path, in the frame in which the user wants it.
    /// `more` draws what is to be chosen beside the path.
    std::optional<std::filesystem::path> draw(float scale, const std::function<void()>& more = {});

  private:
    void offer(const std::string& path);
    std::optional<std::filesystem::path> decide(bool pressed);

    const std::string title_, verb_;
    const bool mayReplace_;
    std::array<char, 4096> typed_{};
    std::string failure_;
    std::filesystem::path agreed_;  // a file that may be replaced
    bool opening_ = false, closing_ = false;
    bool focusing_ = false;  // the user goes on typing
};

struct ViewFiles {
    PathPrompt opening{"Open view", "Open", "view.json", false};
    PathPrompt saving{"Save view", "Save", "", true};
    PathPrompt openingStyle{"Open style", "Open", "style.json", false};
    PathPrompt savingStyle{"Save style", "Save", "style.json", true};
    PathPrompt savingPicture{"Save picture", "Save", "picture.png", true};
    std::array<int, 2> pictureSize{1920, 1080};  ///< pixels, of the next one
    /// What of the window the next one has.
    enum class PictureOf { view, viewWithoutBackground, window } pictureOf = PictureOf::view;

    /// Beside the path of a picture.
    void drawPictureChoices(float scale);
};

/// `usual`, or with the first number behind it that no file has: "view-2.json".
std::filesystem::path freshPath(const std::filesystem::path& usual);

}  // namespace mote::client
