// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/job_form.h"

#include <gmock/gmock.h>

#include <set>

#include "protocol/scene/job_request.h"

namespace mote::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

proto::Look::Found foundOf(const std::string& kind, const std::string& name = "") {
    proto::Look::Found found;
    found.set_kind(kind);
    found.set_name(name);
    auto& column = *found.add_columns();
    column.set_min(10.0);
    column.set_max(20.0);
    (*found.mutable_facts()->mutable_fields())["axes"].set_string_value("x,px,y");
    return found;
}

JobForm formOf(const proto::JobRequest& request) {
    JobForm form;
    form.begin(request);
    form.output = "data/made";
    return form;
}

JobForm::Field* fieldOf(JobForm& form, std::string_view label) {
    const auto found = std::ranges::find(form.fields(), label, &JobForm::Field::label);
    return found != form.fields().end() ? &*found : nullptr;
}

TEST(JobForm, WhatIsFoundSetsWhatIsAsked) {
    const auto run = becomings({"data/run.h5"}, foundOf("particles", "electrons"));
    ASSERT_EQ(run.size(), 1U);
    auto form = formOf(run[0].request);
    EXPECT_EQ(fieldOf(form, "axes")->text, "x,px,y");
    EXPECT_EQ(fieldOf(form, "species")->text, "electrons");
    EXPECT_EQ(fieldOf(form, "volume level")->usual, "6");
    EXPECT_THAT(fieldOf(form, "lost")->words, ElementsAre("without", "with", "only"));
    EXPECT_EQ(fieldOf(form, "inputs"), nullptr);
    EXPECT_EQ(fieldOf(form, "follow"), nullptr) << "a server's jobs end";
    const auto request = form.request();
    ASSERT_TRUE(request.ok()) << request.error().toString();
    EXPECT_EQ(request->output(), "data/made.mote");
    EXPECT_THAT(request->particles().axes(), ElementsAre("x", "px", "y"));
    EXPECT_FALSE(request->particles().has_impact()) << "nothing is said of it";
    EXPECT_FALSE(request->particles().has_volume_level());
}

TEST(JobForm, EachKindBecomesJobsThatAServerTakes) {
    std::set<std::string> labels;
    for (const char* kind : {"particles", "volume", "mesh", "image"}) {
        for (const auto& each : becomings({"data/a"}, foundOf(kind))) {
            labels.insert(each.label);
            auto form = formOf(each.request);
            const auto request = form.request();
            ASSERT_TRUE(request.ok()) << each.label << request.error().toString();
            const auto parsed = parseJobRequest(*request);
            EXPECT_TRUE(parsed.ok()) << each.label << parsed.error().toString();
            EXPECT_EQ(jobInputs(*request).at(0).name, "data/a");
            for (const auto& field : form.fields()) EXPECT_FALSE(field.help.empty()) << field.label;
        }
    }
    EXPECT_EQ(labels.size(), 6U);
    EXPECT_TRUE(becomings({"data/a"}, foundOf("spectrum")).empty());
    EXPECT_EQ(becomings({"data/a"}, foundOf("volume"))[1].request.mesh().isovalue(), 15.0);
}

TEST(JobForm, SeveralFilesAreOneRun) {
    const std::vector<std::string> files{"data/1.h5", "data/2.h5"};
    EXPECT_THAT(becomings(files, foundOf("particles")).at(0).request.particles().inputs(),
                ElementsAre("data/1.h5", "data/2.h5"));
    const auto volumes = becomings(files, foundOf("volume"));
    ASSERT_EQ(volumes.size(), 1U);
    EXPECT_EQ(volumes[0].request.volume().inputs_size(), 2);
    EXPECT_TRUE(becomings(files, foundOf("mesh")).empty());
    EXPECT_TRUE(becomings({}, foundOf("image")).empty());
}

TEST(JobForm, WhatIsTypedIsTakenByItsType) {
    auto form = formOf(becomings({"data/ct.nrrd"}, foundOf("volume", "density"))[0].request);
    fieldOf(form, "low")->text = " 64 ";
    fieldOf(form, "threshold")->text = "0.05";
    fieldOf(form, "spacing")->text = "1, 1 2.5";
    fieldOf(form, "big endian")->text = "true";
    fieldOf(form, "max points")->text = "5000000000";
    fieldOf(form, "unit")->text = "mm";
    form.title = " Chest ";
    const auto request = form.request();
    ASSERT_TRUE(request.ok()) << request.error().toString();
    const auto& job = request->volume();
    EXPECT_EQ(job.low(), 64U);
    EXPECT_EQ(job.threshold(), 0.05);
    EXPECT_EQ(job.max_points(), 5'000'000'000U);
    EXPECT_THAT(job.source().spacing(), ElementsAre(1.0, 1.0, 2.5));
    EXPECT_TRUE(job.source().big_endian());
    EXPECT_EQ(job.source().field(), "density");
    EXPECT_EQ(request->unit(), "mm");
    EXPECT_EQ(request->title(), "Chest");
    fieldOf(form, "field")->text = "";
    EXPECT_EQ(form.request()->volume().source().field(), "") << "what is emptied says nothing";
}

TEST(JobForm, WhatCannotBeIsToldWithItsName) {
    const auto wrong = [](const char* kind, const char* label, const char* text) {
        auto form = formOf(becomings({"data/a"}, foundOf(kind))[0].request);
        fieldOf(form, label)->text = text;
        const auto request = form.request();
        EXPECT_FALSE(request.ok()) << label;
        return request.ok() ? std::string() : request.error().toString();
    };
    EXPECT_THAT(wrong("volume", "threshold", "2"), HasSubstr("threshold: is a number from 0 to 1"));
    EXPECT_THAT(wrong("volume", "threshold", "nan"), HasSubstr("threshold: is a number"));
    EXPECT_THAT(wrong("volume", "low", "-3"), HasSubstr("low: is a whole number"));
    EXPECT_THAT(wrong("volume", "spacing", "1,x"), HasSubstr("spacing: is a number"));
    EXPECT_THAT(wrong("particles", "volume level", "9"), HasSubstr("from 1 to 8"));
    EXPECT_THAT(wrong("particles", "axes", "x,px"), HasSubstr("axes: are three names"));
    auto form = formOf(becomings({"data/a"}, foundOf("image"))[0].request);
    for (const char* name : {"", "made", "data/", "  "}) {
        form.output = name;
        EXPECT_EQ(form.request().error().where, "dataset") << name;
    }
    form.output = "data/x.mote";
    EXPECT_EQ(form.request()->output(), "data/x.mote");
}

TEST(JobForm, ADatasetLiesBesideItsFileUnderAFreeName) {
    const auto none = [](const std::string&) { return false; };
    EXPECT_EQ(outputFor({"data/runs/beam_1.5mm.h5"}, "", none), "data/runs/beam_1.5mm");
    EXPECT_EQ(outputFor({"data/ct.nii.gz"}, "", none), "data/ct");
    EXPECT_EQ(outputFor({"data/.profile"}, "", none), "data/.profile");
    EXPECT_EQ(outputFor({"data/v1.2/run"}, "", none), "data/v1.2/run");
    EXPECT_EQ(outputFor({"data"}, "", none), "data/data");
    EXPECT_EQ(outputFor({"data/run.h5"}, "e-/fast ones", none), "data/run-e-_fast_ones");
    EXPECT_EQ(outputFor({"data/runs/scan_007.h5", "data/runs/scan_008.h5"}, "", none), "data/runs/scan");
    EXPECT_EQ(outputFor({"data/007.h5", "data/008.h5"}, "", none), "data/007");
    const std::set<std::string> there{"data/run.mote", "data/run-2.mote"};
    EXPECT_EQ(outputFor({"data/run.h5"}, "", [&](const std::string& path) { return there.contains(path); }),
              "data/run-3");
}

}  // namespace
}  // namespace mote::client
