// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/parked_file.h"

#include <utility>

#include "protocol/wire/private_file.h"
#include "server/log.h"

namespace mote::server {
namespace {

/// More than limits allow: a file of this size is none of ours.
constexpr std::size_t mostParkedBytes = std::size_t{16} << 20;

}  // namespace

ParkedFile::ParkedFile(asio::io_context& io, const std::filesystem::path& stateDirectory,
                       std::chrono::milliseconds pause, ParkedSessions& sessions)
    : file_(stateDirectory / "sessions"), pause_(pause), sessions_(sessions), timer_(io) {
    read();
    thread_ = std::thread([this] { write(); });
}

ParkedFile::~ParkedFile() {
    timer_.cancel();
    if (due_) hand();
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

/// Clients that come back know their views themselves: a file that cannot be read is said, and no more.
void ParkedFile::read() {
    const auto text = wire::readPrivateFile(file_, mostParkedBytes);
    if (!text.ok()) {
        if (text.error().code != ErrorCode::notFound) log::warn("{}", text.error().toString());
        return;
    }
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(text->data());
    const auto added = sessions_.add({bytes, text->size()}, Clock::now());
    if (!added.ok()) log::warn("{}", added.error().within(file_.string()).toString());
}

void ParkedFile::changed() {
    if (std::exchange(due_, true)) return;
    timer_.expires_after(pause_);
    timer_.async_wait([this](const asio::error_code& code) {
        if (!code) hand();
    });
}

void ParkedFile::hand() {
    due_ = false;
    const auto bytes = sessions_.toBytes();
    {
        const std::lock_guard lock(mutex_);
        text_.emplace(bytes.begin(), bytes.end());
    }
    wake_.notify_one();
}

void ParkedFile::write() {
    std::unique_lock lock(mutex_);
    bool failed = false;
    for (;;) {
        wake_.wait(lock, [this] { return stopping_ || text_; });
        if (!text_) return;
        const auto text = *std::exchange(text_, std::nullopt);
        lock.unlock();
        const auto written = wire::writePrivateFile(file_, text);
        // A full disk is said once, not at every view.
        if (!written.ok() && !failed) log::warn("{}", written.error().toString());
        failed = !written.ok();
        lock.lock();
    }
}

}  // namespace mote::server
