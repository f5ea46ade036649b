// SPDX-License-Identifier: GPL-3.0-or-later
//
// Letters: those that the user interface draws, and the fonts that have them. Latin ones are there from the
// beginning, others once a text with them is learned, so that the font's texture stays small. Main thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace mote::client {

class Letters {
  public:
    /// So many others at most: a catalogue may hold anything.
    static constexpr std::size_t most = 4096;

    /// Learns the letters of a text in UTF-8; what is none is left out.
    void learn(std::string_view text);
    /// And of all texts in a message.
    void learn(const google::protobuf::Message& message);
    void learn(char32_t letter);
    /// Some were learned that the fonts were not yet asked for.
    bool isStale() const { return stale_; }
    /// Fills the atlas of Dear ImGui anew, letters being so many pixels high: from DejaVu Sans, else from
    /// Dear ImGui's own font, and from fonts of Chinese, Japanese and Korean for what that lacks. What none
    /// has is drawn as a question mark.
    void build(float pixels);

    /// Files of fonts that are there, by preference, for what DejaVu Sans lacks.
    static std::vector<std::filesystem::path> furtherFonts();

  private:
    std::set<char32_t> learned_;
    bool stale_ = false;
};

}  // namespace mote::client
