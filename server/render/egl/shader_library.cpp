// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/shader_library.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "server/render/device.h"
#include "server/render/egl/embedded_shaders.h"

namespace mote::render {
namespace {

std::string infoLog(GLuint object, bool program) {
    GLint length = 0;
    program ? glGetProgramiv(object, GL_INFO_LOG_LENGTH, &length)
            : glGetShaderiv(object, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    program ? glGetProgramInfoLog(object, length, nullptr, log.data())
            : glGetShaderInfoLog(object, length, nullptr, log.data());
    log.resize(std::min(log.find('\0'), std::size_t{600}));  // the first mistake says it
    return log;
}

GlProgram compile(std::string_view name, const std::string& source) {
    const GlShader shader(glCreateShader(GL_COMPUTE_SHADER));
    const char* text = source.c_str();
    glShaderSource(shader.get(), 1, &text, nullptr);
    glCompileShader(shader.get());
    GLint ok = GL_FALSE;
    glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &ok);
    if (ok != GL_TRUE) throw DeviceError("shader " + std::string(name) + ": " + infoLog(shader.get(), false));
    GlProgram program(glCreateProgram());
    glAttachShader(program.get(), shader.get());
    glLinkProgram(program.get());
    glGetProgramiv(program.get(), GL_LINK_STATUS, &ok);
    if (ok != GL_TRUE) throw DeviceError("shader " + std::string(name) + ": " + infoLog(program.get(), true));
    return program;
}

}  // namespace

std::string ShaderLibrary::source(std::string_view file) const {
    if (directory_.empty()) {
        for (const auto& [name, text] : embeddedShaders) {
            if (name == file) return std::string(text);
        }
        throw DeviceError("no shader is called \"" + std::string(file) + "\"");
    }
    const auto path = directory_ / file;
    std::ifstream stream(path);
    std::ostringstream text;
    text << stream.rdbuf();
    if (!stream) throw DeviceError("the shader " + path.string() + " cannot be read");
    return text.str();
}

std::string ShaderLibrary::expanded(std::string_view name, const Defines& defines) const {
    std::string result = "#version 450 core\n";
    for (const auto& [macro, value] : defines) {
        result += "#define " + std::string(macro) + " " + std::to_string(value) + "\n";
    }
    constexpr std::string_view include = "#include \"";
    std::istringstream lines(source(std::string(name) + ".comp"));
    for (std::string line; std::getline(lines, line); result += '\n') {
        const bool included = line.compare(0, include.size(), include) == 0;
        result += included ? source(line.substr(include.size(), line.rfind('"') - include.size())) : line;
    }
    return result;
}

GLuint ShaderLibrary::program(std::string_view name, const Defines& defines) {
    std::string key(name);
    for (const auto& [macro, value] : defines) key += " " + std::string(macro) + "=" + std::to_string(value);
    const auto found = programs_.find(key);
    if (found != programs_.end()) return found->second.get();
    return programs_.emplace(key, compile(name, expanded(name, defines))).first->second.get();
}

void ShaderLibrary::reloadChanged() {
    if (directory_.empty()) return;
    auto newest = loaded_;
    std::error_code ignored;  // a folder or file that is not there is reported where it is read
    for (const auto& entry : std::filesystem::directory_iterator(directory_, ignored)) {
        newest = std::max(newest, entry.last_write_time(ignored));
    }
    if (newest == loaded_) return;
    loaded_ = newest;
    programs_.clear();
}

}  // namespace mote::render
