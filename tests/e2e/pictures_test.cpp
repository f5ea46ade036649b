// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a run to picture files, through the real programs and a real socket.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <regex>
#include <sstream>

#include "protocol/scene/srgb.h"
#include "tests/e2e/station.h"

namespace mote::test {
namespace {

using testing::ElementsAre;

struct Pixels {
    int width = 0, height = 0;
    OIIO::TypeDesc type;
    std::vector<float> values;  // RGB; 8 bits as 0 to 1
};

Pixels readPixels(const std::filesystem::path& path) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) {
        ADD_FAILURE() << path << ": " << OIIO::geterror();
        return {};
    }
    const auto& spec = input->spec();
    EXPECT_EQ(spec.nchannels, 3);
    Pixels pixels{spec.width, spec.height, spec.format, {}};
    pixels.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) * 3);
    EXPECT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, pixels.values.data()));
    return pixels;
}

/// The share of pixels in which something is to be seen.
double litShare(const Pixels& pixels) {
    std::size_t lit = 0;
    for (std::size_t i = 0; i < pixels.values.size(); i += 3) {
        lit += pixels.values[i] + pixels.values[i + 1] + pixels.values[i + 2] > 0.02F;
    }
    return static_cast<double>(lit) / (static_cast<double>(pixels.values.size()) / 3.0);
}

/// The fields of a flat JSON object on one line; a line that is none has none.
std::map<std::string, std::string> fieldsOf(const std::string& line) {
    static const std::regex whole(R"(\{("\w+": ("[^"]*"|[-0-9.e]+)(, )?)+\})");
    static const std::regex field(R"re("(\w+)": (?:"([^"]*)"|([-0-9.e]+)))re");
    std::map<std::string, std::string> fields;
    if (!std::regex_match(line, whole)) return fields;
    for (std::sregex_iterator match(line.begin(), line.end(), field), end; match != end; ++match) {
        fields[(*match)[1]] = (*match)[2].str() + (*match)[3].str();
    }
    return fields;
}

class Pictures : public testing::Test {
  protected:
    void SetUp() override { station_.startServer(); }

    Pixels picture(const std::string& name) const { return readPixels(station_.out() / name); }

    Station station_;
};

TEST_F(Pictures, ShowTheBeamInEverySizeAsked) {
    const auto done = station_.frames(scriptOf({beamView(160), beamView(64, 1), beamView(160, 0, 2.5)}));
    ASSERT_EQ(done.status, 0) << done.errors;
    EXPECT_EQ(done.output, "");
    EXPECT_EQ(done.errors, "");  // not a terminal: no progress
    EXPECT_THAT(namesIn(station_.out()),
                ElementsAre("frame-000000.png", "frame-000001.png", "frame-000002.png"));
    const auto first = picture("frame-000000.png"), second = picture("frame-000001.png");
    EXPECT_EQ(first.width, 160);
    EXPECT_EQ(first.height, 120);
    EXPECT_EQ(first.type, OIIO::TypeDesc::UINT8);
    EXPECT_EQ(second.width, 64);
    EXPECT_EQ(second.height, 48);
    // A beam in the middle of its box: more than a speck, less than everything.
    for (const auto& each : {first, second}) {
        EXPECT_GT(litShare(each), 0.02);
        EXPECT_LT(litShare(each), 0.95);
    }
    EXPECT_GT(litShare(picture("frame-000002.png")), litShare(first));  // nearer
}

/// What is not dots lies on the sheet as an image; mote-frames knows its own documents again.
TEST_F(Pictures, OnPaper) {
    const auto script = scriptOf({beamView(160)});
    const std::map<std::string, std::pair<std::string, std::string>> marks{
        {"svg", {"width=\"100mm\" height=\"80mm\"", "<image x=\"10\" y=\"10\" width=\"80\" height=\"60\""}},
        {"eps", {"%!PS-Adobe-3.0 EPSF-3.0", "/ImageType 1"}},
        {"pdf", {"%PDF-", "/Subtype /Image"}}};
    for (const auto& [format, texts] : marks) {
        const std::vector<std::string> sheet{"--format", format, "--page", "100x80", "--margin", "10"};
        const auto done = station_.frames(script, sheet);
        ASSERT_EQ(done.status, 0) << done.errors;
        const auto file = station_.out() / ("frame-000000." + format);
        EXPECT_THAT(bytesOf(file), testing::HasSubstr(texts.first));
        EXPECT_THAT(bytesOf(file), testing::HasSubstr(texts.second));
        const auto written = std::filesystem::last_write_time(file);
        auto again = sheet;
        again.emplace_back("--resume");
        ASSERT_EQ(station_.frames(script, again).status, 0);
        EXPECT_EQ(std::filesystem::last_write_time(file), written);
        again[3] = "90x80";
        ASSERT_EQ(station_.frames(script, again).status, 0);
        EXPECT_NE(std::filesystem::last_write_time(file), written);
    }
}

TEST_F(Pictures, AreTheSameBytesEveryTime) {
    const auto script = scriptOf({beamView(160), beamView(160, 1)});
    for (const std::string format : {"png", "exr", "jpg", "svg", "eps", "pdf"}) {
        const std::string names[] = {"frame-000000." + format, "frame-000001." + format};
        ASSERT_EQ(station_.frames(script, {"--format", format}).status, 0);
        const std::string first[] = {bytesOf(station_.out() / names[0]), bytesOf(station_.out() / names[1])};
        ASSERT_EQ(station_.frames(script, {"--format", format}).status, 0);
        for (int i = 0; i < 2; ++i) {
            EXPECT_FALSE(first[i].empty());
            EXPECT_EQ(bytesOf(station_.out() / names[i]), first[i]) << names[i];
        }
        EXPECT_NE(first[0], first[1]);
    }
}

TEST_F(Pictures, ExrIsTheLinearPictureThatPngIsTheEncodingOf) {
    const auto script = scriptOf({beamView(160)});
    ASSERT_EQ(station_.frames(script, {"--format", "exr"}).status, 0);
    ASSERT_EQ(station_.frames(script).status, 0);
    const auto linear = picture("frame-000000.exr"), encoded = picture("frame-000000.png");
    EXPECT_EQ(linear.type, OIIO::TypeDesc::HALF);
    ASSERT_EQ(linear.values.size(), encoded.values.size());
    double greatest = 0.0;
    for (std::size_t i = 0; i < linear.values.size(); ++i) {
        const double want = linearToSrgb(std::min(1.0, static_cast<double>(linear.values[i])));
        greatest = std::max(greatest, std::abs(want - static_cast<double>(encoded.values[i])));
    }
    // Rounding to 8 bits is off by 1/510. A half is off by 2^-11 of its value, which the encoding (x^(1/2.4))
    // makes 2^-11 / 2.4 of at most 1: 1/4900. Anything else, such as encoding twice, is far more.
    EXPECT_LT(greatest, 1.0 / 510.0 + 1.0 / 4900.0 + 1e-6);
}

TEST_F(Pictures, JpegIsNearlyThePng) {
    const auto script = scriptOf({beamView(160)});
    ASSERT_EQ(station_.frames(script, {"--format", "jpg"}).status, 0);
    ASSERT_EQ(station_.frames(script).status, 0);
    const auto lossy = picture("frame-000000.jpg"), exact = picture("frame-000000.png");
    ASSERT_EQ(lossy.values.size(), exact.values.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < exact.values.size(); ++i) {
        squares += std::pow(static_cast<double>(lossy.values[i] - exact.values[i]), 2.0);
    }
    // Quality 95 keeps pictures of single points above 30 dB; another picture, or one in other channels,
    // stays below 20.
    EXPECT_LT(squares / static_cast<double>(exact.values.size()), 1e-3);
}

TEST_F(Pictures, JsonSaysWhatWasDrawn) {
    const auto done = station_.frames(scriptOf({beamView(64), beamView(96, 1)}), {"--json"});
    ASSERT_EQ(done.status, 0) << done.errors;
    std::istringstream lines(done.output);
    std::string line;
    for (int index = 0; index < 2; ++index) {
        ASSERT_TRUE(std::getline(lines, line));
        const auto object = fieldsOf(line);
        std::vector<std::string> keys;
        for (const auto& [key, value] : object) keys.push_back(key);
        EXPECT_THAT(keys,
                    testing::UnorderedElementsAre("index", "file", "width", "height", "device", "pointsDrawn",
                                                  "planMs", "renderMs", "encodeMs", "totalMs"));
        const auto number = [&](const char* key) { return std::stod(object.at(key)); };
        EXPECT_EQ(number("index"), index);
        EXPECT_EQ(number("width"), index == 0 ? 64 : 96);
        EXPECT_EQ(number("height"), index == 0 ? 48 : 72);
        EXPECT_GT(number("pointsDrawn"), 0.0);
        EXPECT_GT(number("renderMs"), 0.0);
        EXPECT_GE(number("totalMs"), number("renderMs"));
        EXPECT_NE(object.at("device"), "");
        EXPECT_TRUE(std::filesystem::exists(object.at("file")));
    }
    EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(Pictures, AnEmptyViewIsItsBackground) {
    const auto done = station_.frames("{'views': [{'width': 5, 'height': 3, 'background': [1, 0.5, 0]}]}");
    ASSERT_EQ(done.status, 0) << done.errors;
    const auto pixels = picture("frame-000000.png");
    ASSERT_EQ(pixels.values.size(), 45U);
    for (std::size_t i = 0; i < pixels.values.size(); i += 3) {
        EXPECT_EQ(pixels.values[i], 1.0F);
        EXPECT_NEAR(pixels.values[i + 1], 0.5F, 1.01F / 255.0F);  // 127 or 128
        EXPECT_EQ(pixels.values[i + 2], 0.0F);
    }
}

TEST_F(Pictures, ResumeDrawsWhatIsMissingBrokenOrAnotherView) {
    const std::vector<std::string> views{beamView(64), beamView(64, 1), beamView(64, 0, 3.0),
                                         beamView(64, 1, 3.0)};
    ASSERT_EQ(station_.frames(scriptOf(views)).status, 0);
    const auto file = [&](int i) { return station_.out() / ("frame-00000" + std::to_string(i) + ".png"); };
    std::string before[4];
    std::filesystem::file_time_type times[4];
    for (int i = 0; i < 4; ++i) {
        before[i] = bytesOf(file(i));
        times[i] = std::filesystem::last_write_time(file(i));
    }
    const auto drawn = [&](const std::vector<std::string>& script) {
        const auto done = station_.frames(scriptOf(script), {"--resume", "--json"});
        EXPECT_EQ(done.status, 0) << done.errors;
        return std::count(done.output.begin(), done.output.end(), '\n');
    };
    EXPECT_EQ(drawn(views), 0);
    std::filesystem::remove(file(1));
    std::filesystem::resize_file(file(2), before[2].size() / 2);
    EXPECT_EQ(drawn(views), 2);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(bytesOf(file(i)), before[i]) << i;
    EXPECT_EQ(std::filesystem::last_write_time(file(0)), times[0]);
    EXPECT_EQ(std::filesystem::last_write_time(file(3)), times[3]);
    auto changed = views;
    changed[3] = beamView(64, 1, 3.5);
    EXPECT_EQ(drawn(changed), 1);
    EXPECT_NE(bytesOf(file(3)), before[3]);
    EXPECT_EQ(namesIn(station_.out()).size(), 4U);
}

}  // namespace
}  // namespace mote::test
