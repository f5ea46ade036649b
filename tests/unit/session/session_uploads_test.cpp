// SPDX-License-Identifier: GPL-3.0-or-later
//
// Uploads of clients that mean harm, or break: refused at the field, without a file, and gone with their
// client.
#include <fmt/format.h>

#include <set>

#include "server/jobs/uploads.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class SessionUploads : public SessionFixture {
  protected:
    static proto::ClientMessage part(const std::string& name, std::uint64_t begin, const std::string& data,
                                     std::uint64_t size) {
        proto::ClientMessage message;
        auto& upload = *message.mutable_upload();
        upload.set_name(name);
        upload.set_begin(begin);
        upload.set_data(data);
        upload.set_size(size);
        return message;
    }

    static void expectRefused(TestClient& client, const proto::ClientMessage& message,
                              const std::string& code, const std::string& where) {
        const auto failure = client.ask(message).message.failure();
        EXPECT_EQ(failure.code(), code) << failure.ShortDebugString();
        EXPECT_EQ(failure.where(), where);
        EXPECT_FALSE(failure.message().empty());
        EXPECT_FALSE(failure.fatal());
    }

    /// Files beneath the server's folder of uploads.
    std::set<std::string> files() const {
        std::set<std::string> names;
        std::error_code ignored;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "state/uploads", ignored)) {
            if (!entry.is_directory()) names.insert(entry.path().filename());
        }
        return names;
    }
};

TEST_F(SessionUploads, HostileNamesAreRefused) {
    start();
    const auto sender = client();
    const auto before = std::distance(fs::recursive_directory_iterator(folder_.path()), {});
    std::vector<std::string> names{
        "",    ".",    "..",       "../x", "/etc/passwd",  "a/b",     ".hidden", "a\\b",   "a b",
        "x\n", "\x7f", "\xc3\xa4", "~",    "uploads/../x", "$(true)", "a;b.npy", "%2e%2e", "-\t"};
    names.emplace_back("a\0b", 3);
    names.emplace_back(129, 'a');
    names.emplace_back(300, 'a');
    for (char c = 1; c < ' '; ++c) names.push_back(fmt::format("a{}b", c));
    for (const auto& name : names) {
        SCOPED_TRACE(name);
        expectRefused(*sender, part(name, 0, "x", 1), "invalid_argument", "upload.name");
    }
    EXPECT_EQ(std::distance(fs::recursive_directory_iterator(folder_.path()), {}), before);
    const std::string longest(128, 'a');
    EXPECT_EQ(sender->ask(part(longest, 0, "x", 1)).message.uploaded().size(), 1U);
    EXPECT_EQ(files(), std::set{longest});
}

TEST_F(SessionUploads, SizesAndPlacesThatAreWrongAreRefused) {
    start();
    const auto sender = client();
    const auto most = server::Uploads::mostBytes;
    for (const auto size : {most + 1, std::uint64_t{1} << 63, ~std::uint64_t{0}})
        expectRefused(*sender, part("a", 0, "x", size), "resource_exhausted", "upload.size");
    expectRefused(*sender, part("a", 0, "xy", 1), "invalid_argument", "upload.data");
    expectRefused(*sender, part("new", 1, "x", 2), "invalid_argument", "upload.begin");
    ASSERT_EQ(sender->ask(part("b", 0, "xyz", 6)).message.uploaded().size(), 3U);
    for (const std::uint64_t begin : {std::uint64_t{4}, ~std::uint64_t{0}})
        expectRefused(*sender, part("b", begin, "x", 6), "invalid_argument", "upload.begin");
    expectRefused(*sender, part("b", 2, "xy", 6), "invalid_argument", "upload.begin");
    expectRefused(*sender, part("b", 3, "abcd", 6), "invalid_argument", "upload.data");
    EXPECT_EQ(sender->ask(part("b", 3, "abc", 6)).message.uploaded().size(), 6U);
    expectRefused(*sender, part("b", 6, "d", 7), "invalid_argument", "upload.data");
    // What is said of all files together counts, not what came of them.
    ASSERT_TRUE(sender->ask(part("c", 0, "", most - 100)).message.has_uploaded());
    expectRefused(*sender, part("d", 0, "", 100), "resource_exhausted", "upload.size");
    EXPECT_TRUE(sender->ask(part("c", 0, "", 1)).message.has_uploaded()) << "it was begun anew";
    EXPECT_TRUE(sender->ask(part("d", 0, "", 100)).message.has_uploaded());
}

TEST_F(SessionUploads, AreTheirClientsAloneAndGoWithIt) {
    settings_.parking.uploadsKept = 0s;
    start();
    auto sender = client();
    const auto other = client();
    for (const auto* const name : {"one", "two"})
        ASSERT_TRUE(sender->ask(part(name, 0, "secret", 6)).message.has_uploaded());
    ASSERT_TRUE(sender->ask(part("half", 0, "secret", 60)).message.has_uploaded());
    ASSERT_TRUE(other->ask(part("own", 0, "x", 1)).message.has_uploaded());
    EXPECT_EQ(files(), (std::set<std::string>{"half", "one", "own", "two"}));
    // Another's is not found, nor one's own that is not whole.
    proto::ClientMessage job;
    job.mutable_submit_job()->mutable_job()->mutable_particles()->add_inputs("uploads/one");
    expectRefused(*other, job, "not_found", "job.particles.inputs[0]");
    job.mutable_submit_job()->mutable_job()->mutable_particles()->set_inputs(0, "uploads/half");
    expectRefused(*sender, job, "invalid_argument", "job.particles.inputs[0]");
    sender.reset();
    for (const auto until = std::chrono::steady_clock::now() + 10s;
         files().size() > 1 && std::chrono::steady_clock::now() < until;)
        std::this_thread::sleep_for(1ms);
    EXPECT_EQ(files(), std::set<std::string>{"own"});
}

TEST_F(SessionUploads, GoOnAfterALineThatBroke) {
    start();
    proto::Hello hello;
    hello.set_token(connection_.token());
    {
        TestClient first(socket());
        hello.set_resume(first.connect(hello).message.welcome().resume());
        ASSERT_EQ(first.ask(part("a", 0, "abc", 9)).message.uploaded().size(), 3U);
        ASSERT_EQ(first.ask(part("a", 3, "def", 9)).message.uploaded().size(), 6U);
    }
    TestClient second(socket());
    ASSERT_TRUE(second.connect(hello).message.welcome().resumed());
    // Of the last part nobody knows whether it arrived: it is sent again.
    EXPECT_EQ(second.ask(part("a", 3, "def", 9)).message.uploaded().size(), 6U);
    EXPECT_EQ(second.ask(part("a", 6, "ghi", 9)).message.uploaded().size(), 9U);
    const auto folder = fs::directory_iterator(folder_ / "state/uploads")->path();
    std::ifstream file(folder / "a");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "abcdefghi");
    const auto other = client();
    proto::ClientMessage job;
    job.mutable_submit_job()->mutable_job()->mutable_particles()->add_inputs("uploads/a");
    expectRefused(*other, job, "not_found", "job.particles.inputs[0]");
}

}  // namespace
}  // namespace mote::test
