// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "server/jobs/job_files.h"
#include "server/jobs/job_inputs.h"

namespace mote::server {
namespace {

class JobRequestTest : public ::testing::Test {
  protected:
    JobRequestTest() {
        auto pattern = (std::filesystem::temp_directory_path() / "mote-request-XXXXXX").string();
        directory_ = mkdtemp(pattern.data());
        std::filesystem::create_directory(directory_ / "root");
        std::filesystem::create_directory(directory_ / "root/old.mote");
        std::ofstream(directory_ / "root/run.h5") << "x";
        std::ofstream(directory_ / "outside.h5") << "x";
        std::filesystem::create_symlink("../outside.h5", directory_ / "root/link.h5");
        std::filesystem::create_symlink("run.h5", directory_ / "root/inner.h5");
        roots_ = storage::Roots::parse({"data=" + (directory_ / "root").string()}).value();
    }
    ~JobRequestTest() override { std::filesystem::remove_all(directory_); }

    static proto::JobRequest good() {
        proto::JobRequest request;
        request.set_output("data/new.mote");
        auto& job = *request.mutable_particles();
        job.add_inputs("data/run.h5");
        for (const char* axis : {"x", "px", "y"}) job.add_axes(axis);
        return request;
    }

    std::filesystem::path directory_;
    storage::Roots roots_;
};

void addSmallView(proto::JobRequest& film) {
    auto& view = *film.mutable_film()->mutable_script()->add_views();
    view.set_width(64);
    view.set_height(48);
}

TEST_F(JobRequestTest, aFilmHasNoOutputAndMayBeLarge) {
    proto::JobRequest request;
    auto& film = *request.mutable_film();
    const auto addView = [&] {
        auto& view = *film.mutable_script()->add_views();
        view.set_width(64);
        view.set_height(48);
        auto& layer = *view.add_layers();
        layer.set_dataset("data/" + std::string(900, 'a'));
        layer.mutable_particles();
    };
    addView();
    EXPECT_TRUE(checkJobRequest(request, roots_).ok());
    while (request.ByteSizeLong() < 899 * 1024) addView();
    EXPECT_TRUE(checkJobRequest(request, roots_).ok());
    while (request.ByteSizeLong() <= 900 * 1024) addView();
    EXPECT_EQ(checkJobRequest(request, roots_).error().code, ErrorCode::resourceExhausted);
}

TEST_F(JobRequestTest, badFilmsAreRefusedWithTheirField) {
    const auto nan = std::numeric_limits<double>::quiet_NaN();
    using Film = proto::FilmJob;
    const std::vector<std::pair<const char*, std::function<void(Film&)>>> table{
        {"film.script", [](Film& f) { f.clear_script(); }},
        {"film.script.views[0].width", [](Film& f) { f.mutable_script()->mutable_views(0)->set_width(0); }},
        {"film.format", [](Film& f) { f.set_format("tiff"); }},
        {"film.format", [](Film& f) { f.set_format("../png"); }},
        {"film.video", [](Film& f) { f.set_video("avi"); }},
        {"film.quality", [](Film& f) { f.set_quality(64); }},
        {"film.chroma", [](Film& f) { f.set_chroma("quartered"); }},
        {"film.samples", [](Film& f) { f.set_samples(2); }},
        {"film.shutterDegrees", [](Film& f) { f.set_shutter_degrees(-1); }},
        {"film.shutterDegrees", [](Film& f) { f.set_shutter_degrees(361); }},
        {"film.shutterDegrees", [nan](Film& f) { f.set_shutter_degrees(nan); }},
        {"film.subframes", [](Film& f) { f.set_subframes(65); }},
    };
    for (const auto& [where, spoil] : table) {
        proto::JobRequest request;
        addSmallView(request);
        ASSERT_TRUE(checkJobRequest(request, roots_).ok());
        spoil(*request.mutable_film());
        const auto place = checkJobRequest(request, roots_);
        ASSERT_FALSE(place.ok()) << where;
        EXPECT_EQ(place.error().code, ErrorCode::invalidArgument);
        EXPECT_EQ(place.error().where, where);
    }
    proto::JobRequest request;
    addSmallView(request);
    request.set_output("data/film.mp4");
    EXPECT_EQ(checkJobRequest(request, roots_).error().where, "output");
}

struct Bad {
    const char* what;
    ErrorCode code;
    const char* where;
    std::function<void(proto::JobRequest&)> spoil;
};

TEST_F(JobRequestTest, aGoodRequestNamesItsOutput) {
    const auto place = checkJobRequest(good(), roots_);
    ASSERT_TRUE(place.ok()) << place.error().toString();
    EXPECT_EQ(place.value().path, std::filesystem::canonical(directory_ / "root") / "new.mote");
    auto inner = good();
    inner.mutable_particles()->set_inputs(0, "data/inner.h5");
    EXPECT_TRUE(checkJobRequest(inner, roots_).ok()) << "a link within the root is fine";
}

TEST_F(JobRequestTest, badRequestsAreRefusedWithTheirField) {
    const auto nan = std::numeric_limits<double>::quiet_NaN();
    const auto input = [](const std::string& name) {
        return [name](proto::JobRequest& r) { r.mutable_particles()->set_inputs(0, name); };
    };
    const auto output = [](const std::string& name) {
        return [name](proto::JobRequest& r) { r.set_output(name); };
    };
    const auto bounds = [](proto::JobRequest& r, double min, double max) {
        auto& axis = *r.mutable_particles()->add_bounds();
        axis.set_name("x");
        axis.set_min(min);
        axis.set_max(max);
    };
    const auto invalid = ErrorCode::invalidArgument;
    const std::vector<Bad> table{
        {"no kind", invalid, "kind", [](auto& r) { r.clear_particles(); }},
        {"no output", invalid, "output", output("")},
        {"no root", invalid, "output", output("new.mote")},
        {"unknown root", ErrorCode::notFound, "output", output("other/new.mote")},
        {"absolute", invalid, "output", output("/data/new.mote")},
        {"leads out", invalid, "output", output("data/../new.mote")},
        {"dot", invalid, "output", output("data/./new.mote")},
        {"double slash", invalid, "output", output("data//new.mote")},
        {"slash at the end", invalid, "output", output("data/new.mote/")},
        {"wrong ending", invalid, "output", output("data/new.h5")},
        {"only an ending", invalid, "output", output("data/.mote")},
        {"hidden", invalid, "output", output("data/.new.mote")},
        {"line break", invalid, "output", output("data/a\nb.mote")},
        {"NUL", invalid, "output", output(std::string("data/a\0b.mote", 13))},
        {"long part", invalid, "output", output("data/" + std::string(300, 'a') + ".mote")},
        {"long name", invalid, "output", output("data/" + std::string(2000, 'a'))},
        {"beneath a file", ErrorCode::notFound, "output", output("data/run.h5/new.mote")},
        {"there already", ErrorCode::alreadyExists, "output", output("data/old.mote")},
        {"no input", invalid, "particles.inputs", [](auto& r) { r.mutable_particles()->clear_inputs(); }},
        {"too many inputs", invalid, "particles.inputs",
         [](auto& r) {
             for (int i = 0; i < 4096; ++i) r.mutable_particles()->add_inputs("data/r");
         }},
        {"missing input", ErrorCode::notFound, "particles.inputs[0]", input("data/none.h5")},
        {"input out by a link", invalid, "particles.inputs[0]", input("data/link.h5")},
        {"input out by dots", invalid, "particles.inputs[0]", input("data/../outside.h5")},
        {"two axes", invalid, "particles.axes",
         [](auto& r) { r.mutable_particles()->mutable_axes()->RemoveLast(); }},
        {"four axes", invalid, "particles.axes", [](auto& r) { r.mutable_particles()->add_axes("z"); }},
        {"an axis twice", invalid, "particles.axes[2]",
         [](auto& r) { r.mutable_particles()->set_axes(2, "x"); }},
        {"an empty axis", invalid, "particles.axes[1]",
         [](auto& r) { r.mutable_particles()->set_axes(1, ""); }},
        {"a long axis", invalid, "particles.axes[1]",
         [](auto& r) { r.mutable_particles()->set_axes(1, std::string(100, 'x')); }},
        {"a long title", invalid, "title", [](auto& r) { r.set_title(std::string(1000, 'x')); }},
        {"an escape in the title", invalid, "title", [](auto& r) { r.set_title("\x1b[31m"); }},
        {"a long range", invalid, "particles.steps",
         [](auto& r) { r.mutable_particles()->set_steps(std::string(100, '1')); }},
        {"bounds upside down", invalid, "particles.bounds[0]", [bounds](auto& r) { bounds(r, 1.0, 0.0); }},
        {"bounds that are no numbers", invalid, "particles.bounds[0]",
         [bounds, nan](auto& r) { bounds(r, 0.0, nan); }},
        {"bounds of no axis", invalid, "particles.bounds[0].name",
         [](auto& r) { r.mutable_particles()->add_bounds()->set_max(1.0); }},
        {"bounds of something else", invalid, "particles.boundsOf",
         [](auto& r) { r.mutable_particles()->set_bounds_of("bunch"); }},
        {"a mass that is none", invalid, "particles.impact",
         [nan](auto& r) { r.mutable_particles()->mutable_impact()->set_mass(nan); }},
        {"too large", ErrorCode::resourceExhausted, "",
         [](auto& r) {
             for (int i = 0; i < 4000; ++i) r.mutable_particles()->add_inputs("data/" + std::string(40, 'a'));
         }},
        {"no particles", invalid, "synthBeam.particles",
         [](auto& r) {
             r.set_output("data/new.h5");
             r.mutable_synth_beam()->set_steps(1);
         }},
        {"a hierarchy of no points", invalid, "stipple.points", [](auto& r) { r.mutable_stipple(); }},
        {"a relaxation that is none", invalid, "stipple.relaxation",
         [nan](auto& r) {
             r.mutable_stipple()->set_points(1);
             r.mutable_stipple()->set_relaxation(nan);
         }},
        {"a missing mesh", ErrorCode::notFound, "stipple.mesh",
         [](auto& r) {
             r.mutable_stipple()->set_points(1);
             r.mutable_stipple()->set_mesh("data/none.obj");
         }},
        {"a dataset from a synthetic run", invalid, "output",
         [](auto& r) {
             r.mutable_synth_beam()->set_steps(1);
             r.mutable_synth_beam()->set_particles(1);
         }},
    };
    for (const auto& bad : table) {
        auto request = good();
        bad.spoil(request);
        const auto place = checkJobRequest(request, roots_);
        ASSERT_FALSE(place.ok()) << bad.what;
        EXPECT_EQ(place.error().code, bad.code) << bad.what << ": " << place.error().toString();
        EXPECT_EQ(place.error().where, bad.where) << bad.what;
        EXPECT_FALSE(place.error().message.empty()) << bad.what;
    }
}

TEST(PlainTextTest, anyBytesBecomePrintableUtf8) {
    EXPECT_EQ(plainText("a\tb", 10), "a b");
    EXPECT_EQ(plainText("\x1b[0m", 10), "?[0m");
    EXPECT_EQ(plainText("\xc2\x9b"
                        "0m",
                        10),
              "?0m");                                          // the same in C1
    EXPECT_EQ(plainText("\xe2\x82\xac", 10), "\xe2\x82\xac");  // the euro sign
    EXPECT_EQ(plainText("\xe2\x82\xac", 2), "");               // not cut in two
    EXPECT_EQ(plainText("\xe2\x82", 10), "??");
    EXPECT_EQ(plainText("\xed\xa0\x80", 10), "???");       // a surrogate
    EXPECT_EQ(plainText("\xf4\x90\x80\x80", 10), "????");  // beyond U+10FFFF
    EXPECT_EQ(plainText("\xc0\xaf", 10), "??");            // overlong
    EXPECT_EQ(plainText(std::string(50, 'x'), 10), std::string(10, 'x'));
}

}  // namespace
}  // namespace mote::server
