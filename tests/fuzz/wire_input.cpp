// SPDX-License-Identifier: GPL-3.0-or-later
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "protocol/scene/job_request.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/view.h"
#include "protocol/wire/framing.h"
#include "protocol/wire/row_filter.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

constexpr std::uint64_t mostPixels = 1 << 16;  // of a picture that is looked at

/// What of the bytes was not read yet.
class Stream {
  public:
    explicit Stream(std::string_view bytes)
        : rest_(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()) {}

    bool atEnd() const { return rest_.empty(); }
    bool has(std::size_t count) const { return count <= rest_.size(); }
    std::span<const std::uint8_t> take(std::size_t count) {
        const auto taken = rest_.first(count);
        rest_ = rest_.subspan(count);
        return taken;
    }
    template <std::size_t N>
    std::array<std::uint8_t, N> takeArray() {
        std::array<std::uint8_t, N> bytes{};
        std::ranges::copy(take(N), bytes.begin());
        return bytes;
    }

  private:
    std::span<const std::uint8_t> rest_;
};

/// What a server does with it: each has its own answer, and none ends the stream.
void lookAt(const proto::ClientMessage& message, std::span<const std::uint8_t>) {
    if (message.has_set_view()) static_cast<void>(parseView(message.set_view().view()));
    if (message.has_submit_job()) static_cast<void>(parseJobRequest(message.submit_job().job()));
    if (message.has_query()) static_cast<void>(parseSelection(message.query().select()));
}

/// Filtered pixels come back, whatever they are.
void lookAt(const proto::ServerMessage& message, std::span<const std::uint8_t> payload) {
    if (!message.has_frame()) return;
    const auto& frame = message.frame();
    const std::uint64_t pixels = std::uint64_t{frame.width()} * frame.height();
    const auto size = wire::filteredPixelSize(frame.format());
    if (size == 0 || pixels == 0 || pixels > mostPixels || payload.size() != pixels * size) return;
    std::vector<std::uint8_t> rgba(pixels * wire::pixelSize(frame.format())), again(payload.size());
    wire::unfilterRows(frame.format(), frame.width(), payload, rgba);
    wire::filterRows(frame.format(), frame.width(), rgba, again);
    require(std::ranges::equal(payload, again));
}

template <class Message>
std::string readFrame(Stream& stream, wire::FrameLimits limits) {
    if (!stream.has(sizeof(wire::Header))) return "it ends within a header";
    const auto header = wire::decodeHeader(stream.takeArray<sizeof(wire::Header)>(), limits);
    if (!header) return header.error().toString();
    require(header->message <= limits.message && header->payload <= limits.payload);
    if (!stream.has(header->message)) return "it ends within a message";
    Message message;
    const auto status = wire::decodeMessage(stream.take(header->message), message);
    if (!status) return status.error().toString();
    if (!stream.has(header->payload)) return "it ends within a payload";
    lookAt(message, stream.take(header->payload));

    std::vector<std::uint8_t> bytes;
    if (wire::encodeFrame(message, 0, limits, bytes).ok()) {
        Message again;
        const auto body = std::span<const std::uint8_t>(bytes).subspan(sizeof(wire::Header));
        require(wire::decodeMessage(body, again).ok());
    }
    return "";
}

template <class Message>
std::string readStream(Stream stream, wire::FrameLimits first, wire::FrameLimits later) {
    if (!stream.has(sizeof(wire::Greeting))) return "it ends within the greeting";
    const auto greeting = stream.takeArray<sizeof(wire::Greeting)>();
    const auto version = wire::decodeGreeting(greeting);
    if (!version) return version.error().toString();
    require(wire::encodeGreeting(*version) == greeting);
    for (auto limits = first; !stream.atEnd(); limits = later) {
        if (auto error = readFrame<Message>(stream, limits); !error.empty()) return error;
    }
    return "";
}

}  // namespace

std::string wireInput(std::string_view input) {
    // What is no text becomes an Error, as in the server, and no line on stderr.
    google::protobuf::SetLogHandler(nullptr);
    const auto [whose, bytes] = firstLine(input);
    if (whose == "server") {
        return readStream<proto::ServerMessage>(Stream(bytes), wire::serverLimits, wire::serverLimits);
    }
    return readStream<proto::ClientMessage>(Stream(bytes), wire::helloLimits, wire::clientLimits);
}

}  // namespace mote::test
