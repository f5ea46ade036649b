// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/job_request.h"

#include <gmock/gmock.h>

#include <limits>
#include <string>

namespace mote {
namespace {

using testing::HasSubstr;

std::vector<std::string> fieldsOf(const proto::JobRequest& request) {
    std::vector<std::string> fields;
    for (const auto& input : jobInputs(request)) fields.push_back(input.field + "=" + input.name);
    return fields;
}

TEST(JobRequest, NamesItsInputsByField) {
    proto::JobRequest request;
    EXPECT_TRUE(fieldsOf(request).empty());
    request.mutable_volume()->add_inputs("a");
    request.mutable_volume()->add_inputs("b");
    EXPECT_THAT(fieldsOf(request), testing::ElementsAre("volume.inputs[0]=a", "volume.inputs[1]=b"));
    request.mutable_particles()->add_inputs("c");
    EXPECT_THAT(fieldsOf(request), testing::ElementsAre("particles.inputs[0]=c"));
    request.mutable_image();
    EXPECT_THAT(fieldsOf(request), testing::ElementsAre("image.input=")) << "there must be one";
    request.mutable_mesh()->set_input("m");
    EXPECT_THAT(fieldsOf(request), testing::ElementsAre("mesh.input=m"));
    request.mutable_stipple();
    EXPECT_TRUE(fieldsOf(request).empty()) << "the plane";
    request.mutable_stipple()->set_mesh("m");
    EXPECT_THAT(fieldsOf(request), testing::ElementsAre("stipple.mesh=m"));
    request.mutable_synth_beam();
    EXPECT_TRUE(fieldsOf(request).empty());
}

TEST(JobRequest, ParsedItHasWhatTheMessageSays) {
    proto::JobRequest message;
    message.set_output("data/new.mote");
    message.mutable_mesh()->set_input("data/a.obj");
    const auto request = parseJobRequest(message);
    ASSERT_TRUE(request.ok()) << request.error().toString();
    EXPECT_EQ(request->message.output(), "data/new.mote");
    ASSERT_EQ(request->inputs.size(), 1U);
    EXPECT_EQ(request->inputs[0].name, "data/a.obj");
}

TEST(JobRequest, WhatIsMissingIsSaidWithAllKinds) {
    const auto request = parseJobRequest({});
    ASSERT_FALSE(request.ok());
    EXPECT_EQ(request.error().where, "kind");
    for (const char* kind :
         {"particles", "synthBeam", "stipple", "mesh", "image", "volume", "film", "export"}) {
        EXPECT_THAT(request.error().message, HasSubstr(kind));
    }
}

TEST(JobRequest, PlacesAreThoseOfJson) {
    proto::JobRequest message;
    message.set_output("data/a.h5");
    message.mutable_synth_beam()->set_particles(1);
    EXPECT_EQ(parseJobRequest(message).error().where, "synthBeam.steps");
    message.mutable_synth_beam()->set_steps(1);
    EXPECT_TRUE(parseJobRequest(message).ok());
    message.mutable_image()->set_input(std::string(300, 'a'));
    EXPECT_EQ(parseJobRequest(message).error().where, "image.input");
    message.mutable_image()->set_input("data/a.png");
    EXPECT_EQ(parseJobRequest(message).error().where, "output") << "a dataset ends with .mote";
}

TEST(JobRequest, OnlyASurfaceOfAVolumeIsClipped) {
    proto::JobRequest message;
    message.set_output("data/a.mote");
    auto& mesh = *message.mutable_mesh();
    mesh.set_input("data/chest.nrrd");
    for (const double side : {0.0, 0.0, 0.0, 1.0, 1.0, 1.0}) mesh.add_clip(side);
    EXPECT_EQ(parseJobRequest(message).error().where, "mesh.isovalue");
    mesh.set_isovalue(220.0);
    EXPECT_TRUE(parseJobRequest(message).ok());
    mesh.set_clip(3, 0.0);
    EXPECT_EQ(parseJobRequest(message).error().where, "mesh.clip");
    mesh.mutable_clip()->RemoveLast();
    EXPECT_EQ(parseJobRequest(message).error().where, "mesh.clip");
    mesh.clear_clip();
    mesh.set_isovalue(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(parseJobRequest(message).error().where, "mesh.isovalue");
}

}  // namespace
}  // namespace mote
