// SPDX-License-Identifier: GPL-3.0-or-later
//
// Exports: made as other jobs are, kept and fetched as films are.
#include <gmock/gmock.h>
#include <signal.h>

#include <sstream>

#include "protocol/base/json.h"
#include "protocol/scene/selection.h"
#include "tests/unit/jobs/job_fixture.h"

namespace mote::server {
namespace {

using ::testing::HasSubstr;

class ExportJobTest : public JobTest {
  protected:
    /// Of a dataset that the fake does not open.
    proto::JobRequest exportRequest(const std::string& script) {
        std::filesystem::create_directories(root_ / "beam.mote");
        proto::JobRequest request;
        request.set_title(script);
        request.mutable_export_()->set_dataset("data/beam.mote");
        return request;
    }
    std::string submitExport(const proto::JobRequest& request) {
        const auto status = queue_->submit(request);
        EXPECT_TRUE(status.ok()) << status.error().toString();
        return status.ok() ? status->id() : std::string();
    }
};

TEST_F(ExportJobTest, itsFileStaysAndIsFetched) {
    startServer();
    const auto id = submitExport(exportRequest("half:writing file:export.h5"));
    EXPECT_EQ(waitForState(id, State::SUCCEEDED).progress(), 1.0);
    const auto piece = fetchVideo(id);
    ASSERT_TRUE(piece.ok()) << piece.error().toString();
    EXPECT_EQ(piece->message.name(), "export.h5");
    EXPECT_EQ(piece->bytes, std::vector<std::uint8_t>{'x'});
    const auto picture = fetchPicture(id, 0);
    ASSERT_FALSE(picture.ok());
    EXPECT_EQ(picture.error().code, ErrorCode::notFound);
    startServer();
    EXPECT_TRUE(fetchVideo(id).ok()) << "the next server has it too";
    ASSERT_TRUE(queue_->cancel(id).ok());
    EXPECT_FALSE(fetchVideo(id).ok());
}

TEST_F(ExportJobTest, aLargeSelectionIsTheProgramsAlone) {
    startServer();
    auto request = exportRequest("phase:on wait:go file:export.h5");
    for (std::uint64_t i = 0; i < 100'000; ++i) request.mutable_export_()->mutable_select()->add_ids(i * i);
    const auto id = submitExport(request);
    waitForPhase(id, "on");
    proto::JobRequest kept;
    ASSERT_TRUE(readJsonFile(directory_ / "state/jobs" / id / "request.json", kept).ok());
    EXPECT_EQ(kept.SerializeAsString(), request.SerializeAsString());
    EXPECT_LT(queue_->find(id)->ByteSizeLong(), 4096U);
    const auto told = queue_->find(id)->request().export_();
    ASSERT_TRUE(told.has_select()) << "absent means all particles";
    EXPECT_NE(told.select().named().find(std::to_string(request.export_().select().ByteSizeLong())),
              std::string::npos)
        << told.select().named();
    EXPECT_FALSE(parseSelection(told.select()).ok()) << "sent again it is refused, and not all";
    releaseFilm(id, "go");
    waitForState(id, State::SUCCEEDED);
    request.mutable_export_()->mutable_select()->clear_ids();
    request.mutable_export_()->mutable_select()->add_ids(7);
    request.set_title("file:export.h5");
    EXPECT_EQ(queue_->find(submitExport(request))->request().export_().select().ids(0), 7U)
        << "a small one is told";
}

TEST_F(ExportJobTest, begunAnewItFindsNothingOfBefore) {
    startServer();
    // Killed once it has made a file: the second attempt's has one byte, and not two.
    const auto id = submitExport(exportRequest("file:export.h5 file:export.h5.partial-1 pids: wait:go"));
    int first = 0;
    waitUntil(id, [&](const auto& status) {
        return static_cast<bool>(std::istringstream(status.phase()) >> first);
    });
    kill(first, SIGKILL);
    int second = 0;
    waitUntil(id, [&](const auto& status) {
        return (std::istringstream(status.phase()) >> second) && second != first;
    });
    releaseFilm(id, "go");
    waitForState(id, State::SUCCEEDED);
    EXPECT_EQ(fetchVideo(id)->bytes.size(), 1U);
}

TEST_F(ExportJobTest, whatFailsIsSaidAndIsNotThere) {
    startServer();
    const auto id = submitExport(exportRequest("print:mote-prep:_no_column exit:1"));
    EXPECT_EQ(waitForState(id, State::FAILED).error(), "mote-prep:_no_column");
    EXPECT_THAT(fetchVideo(id).error().message, HasSubstr("the export of job"));
    const auto none = waitForState(submitExport(exportRequest("phase:done")), State::FAILED);
    EXPECT_THAT(none.error(), HasSubstr("its export is not there"));
}

TEST_F(ExportJobTest, requestsAreCheckedBeforeTheyWait) {
    startServer();
    const auto refused = [&](const std::function<void(proto::JobRequest&)>& change) {
        auto request = exportRequest("");
        change(request);
        const auto status = queue_->submit(request);
        return status.ok() ? std::string("accepted") : status.error().where;
    };
    EXPECT_EQ(refused([](auto& request) { request.set_output("data/out.h5"); }), "output");
    EXPECT_EQ(refused([](auto& request) { request.mutable_export_()->set_dataset("data/none.mote"); }),
              "export.dataset");
    EXPECT_EQ(refused([](auto& request) { request.mutable_export_()->set_dataset("data/../../etc"); }),
              "export.dataset");
    EXPECT_EQ(refused([](auto& request) { request.mutable_export_()->set_steps("3:1"); }), "export.steps");
    EXPECT_EQ(refused([](auto& request) { request.mutable_export_()->add_columns("a\nb"); }),
              "export.columns[0]");
    EXPECT_THAT(refused([](auto& request) {
                    request.mutable_export_()->mutable_select()->mutable_polygon()->add_columns("x");
                }),
                HasSubstr("export.select.polygon"));
    EXPECT_EQ(refused([](auto&) {}), "accepted");
}

}  // namespace
}  // namespace mote::server
