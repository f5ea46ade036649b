// SPDX-License-Identifier: GPL-3.0-or-later
//
// ShaderLibrary: the compute programs of a device, compiled at first use. Sources are files of egl/shaders,
// embedded at build; a directory given at run time takes their place, and a file that changes there is
// compiled anew. Owned by a device, used while its context is current.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/render/egl/gl_objects.h"

namespace mote::render {

class ShaderLibrary {
  public:
    using Defines = std::vector<std::pair<std::string_view, unsigned>>;

    /// `directory` empty: the embedded sources.
    explicit ShaderLibrary(std::filesystem::path directory) : directory_(std::move(directory)) {}

    /// The program of "NAME.comp", compiled with the given macros. Lines `#include "FILE"` are replaced by
    /// that file, one level deep. Throws DeviceError with the compiler's words.
    GLuint program(std::string_view name, const Defines& defines = {});
    /// Forgets programs whose directory has changed since; does nothing for embedded sources.
    void reloadChanged();

  private:
    std::string source(std::string_view file) const;
    std::string expanded(std::string_view name, const Defines& defines) const;

    std::filesystem::path directory_;
    std::filesystem::file_time_type loaded_ = std::filesystem::file_time_type::min();
    std::map<std::string, GlProgram> programs_;
};

}  // namespace mote::render
