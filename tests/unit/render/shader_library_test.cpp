// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/shader_library.h"

#include <gtest/gtest.h>

#include <fstream>

#include "server/render/device.h"
#include "server/render/egl/egl_context.h"
#include "tests/support/temp_dir.h"

namespace mote::render {
namespace {

class ShaderLibraryTest : public testing::Test {
  protected:
    void write(const std::string& name, const std::string& text) {
        std::ofstream(folder_.path() / name) << text;
    }
    std::string errorOf(ShaderLibrary& library, std::string_view name) {
        try {
            library.program(name, {{"SIZE", 8}});
        } catch (const DeviceError& error) {
            return error.what();
        }
        return "";
    }

    test::TempDir folder_;
    EglContext context_;
    EglContext::Current current_{context_};
};

const char* const sound =
    "layout(local_size_x = SIZE) in;\n#include \"part.glsl\"\nvoid main() { value = part(); }\n";
const char* const part =
    "layout(std430, binding = 0) buffer B { uint value; };\nuint part() { return 1u; }\n";

TEST_F(ShaderLibraryTest, CompilesWithMacrosAndIncludesOnce) {
    write("one.comp", sound);
    write("part.glsl", part);
    ShaderLibrary library(folder_.path());
    const GLuint program = library.program("one", {{"SIZE", 8}});
    EXPECT_NE(program, 0U);
    EXPECT_EQ(library.program("one", {{"SIZE", 8}}), program);
    EXPECT_NE(library.program("one", {{"SIZE", 16}}), program);
}

TEST_F(ShaderLibraryTest, SaysWhatIsWrongAndWhere) {
    ShaderLibrary library(folder_.path());
    EXPECT_NE(errorOf(library, "one").find("one.comp"), std::string::npos);
    write("one.comp", sound);
    EXPECT_NE(errorOf(library, "one").find("part.glsl"), std::string::npos);
    write("part.glsl", "uint part() { return nonsense; }\n");
    EXPECT_NE(errorOf(library, "one").find("nonsense"), std::string::npos);
    ShaderLibrary embedded({});
    EXPECT_NE(errorOf(embedded, "no_such_shader").find("no_such_shader"), std::string::npos);
}

TEST_F(ShaderLibraryTest, TakesUpChangedFiles) {
    write("one.comp", sound);
    write("part.glsl", part);
    ShaderLibrary library(folder_.path());
    library.reloadChanged();
    library.program("one", {{"SIZE", 8}});
    library.reloadChanged();
    write("part.glsl", "uint part() { return nonsense; }\n");
    const auto later =
        std::filesystem::last_write_time(folder_.path() / "part.glsl") + std::chrono::seconds(2);
    std::filesystem::last_write_time(folder_.path() / "part.glsl", later);
    EXPECT_EQ(errorOf(library, "one"), "");  // not before it is asked to look
    library.reloadChanged();
    EXPECT_NE(errorOf(library, "one").find("nonsense"), std::string::npos);
}

}  // namespace
}  // namespace mote::render
